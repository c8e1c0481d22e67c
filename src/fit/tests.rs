use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::fit::*;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, find};
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::recording::Recording;
use crate::sim::{Options, simulate};

pub(super) fn paper() -> Model {
    Preset::embedded("paper").unwrap().model
}

pub(super) fn made(model: &Model, drive: &str, duration: f64, seed: u64) -> Recording {
    let waveform = Waveform::parse(drive, duration).unwrap();
    let mut trace = simulate(model, &waveform, duration, &Options::default()).unwrap();
    let sensor = Sensor {
        noise: 20e-9,
        ..Sensor::default()
    };
    sensor.add_noise(&mut trace.proof_mass, seed);
    sensor.add_noise(&mut trace.cantilever, seed + 1000);
    let (time, volts) = (trace.times(), Some(trace.voltage.clone()));
    let xc = Some(trace.cantilever.clone());
    Recording::new(drive, time, volts, trace.proof_mass.clone(), xc).unwrap()
}

pub(super) fn part(recording: Recording) -> Part {
    Part::whole(Arc::new(recording))
}

fn two(model: &Model) -> Vec<Part> {
    vec![
        part(made(model, "sine:50Hz:8V", 0.05, 1)),
        part(made(model, "square:100Hz:8V", 0.03, 2)),
    ]
}

pub(super) fn options(free: &[&str]) -> FitOptions {
    FitOptions {
        free: free.iter().map(|id| (*id).to_owned()).collect(),
        ..FitOptions::for_model(&paper())
    }
}

pub(super) fn run(
    start: &Model,
    parts: &[Part],
    options: &FitOptions,
) -> Result<FitResult, FitError> {
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    fit(start, parts, &[], options, &control)
}

pub(super) fn off(mut model: Model, changes: &[(&str, f64)]) -> Model {
    for (id, factor) in changes {
        let value = model.get(id).unwrap();
        model.set(id, value * factor).unwrap();
    }
    model
}

const START_FACTORS: [(&str, f64); 3] = [("eta", 0.6), ("zeta1", 1.5), ("dp", 1.1)];

#[test]
fn a_bad_start_converges_and_the_result_repeats() {
    let truth = paper();
    let start = off(paper(), &START_FACTORS);
    let parts = two(&truth);
    let free = options(&["eta", "dp", "zeta1", "alpha"]);
    let first = run(&start, &parts, &free).unwrap();
    for p in &first.parameters {
        let expected = truth.get(&p.id).unwrap();
        let error = (p.value / expected - 1.0).abs();
        assert!(error < 0.03, "{}: {:+.2} %", p.id, 100.0 * error);
        assert!(p.std_error > 0.0 && p.std_error.is_finite());
    }
    assert!(
        first.train.0.rms < 2.0 * first.train.0.noise,
        "{:?}",
        first.train.0
    );
    // The same bytes again.
    let again = run(&start, &parts, &free).unwrap();
    assert_eq!(first.parameters, again.parameters);
    // The order of the recordings does not matter beyond rounding.
    let turned: Vec<Part> = parts.iter().rev().cloned().collect();
    let turned = run(&start, &turned, &free).unwrap();
    for (a, b) in first.parameters.iter().zip(&turned.parameters) {
        assert!((a.value - b.value).abs() < 0.2 * a.std_error, "{}", a.id);
    }
}

#[test]
fn readings_that_are_not_the_devices_do_not_move_a_fit() {
    let truth = paper();
    let start = off(paper(), &START_FACTORS);
    let free = options(&["eta", "dp"]);
    let sound = made(&truth, "sine:50Hz:8V", 0.05, 1);
    let mut faulty = sound.clone();
    for i in (150..2400).step_by(220) {
        faulty.proof_mass[i] += if i % 440 == 150 { 9e-6 } else { -9e-6 };
    }
    for start in [400, 1300] {
        let held = faulty.proof_mass[start];
        faulty.proof_mass[start..start + 6].fill(held);
    }
    let a = run(&start, &[part(sound)], &free).unwrap();
    let b = run(&start, &[part(faulty)], &free).unwrap();
    for (a, b) in a.parameters.iter().zip(&b.parameters) {
        let moved = (a.value - b.value).abs() / a.std_error;
        assert!(moved < 1.0, "{}: {moved} standard errors", a.id);
    }
    for words in ["spikes in xp", "repeated readings in xp"] {
        assert!(!a.remarks.iter().any(|r| r.contains(words)));
        assert!(
            b.remarks.iter().any(|r| r.contains(words)),
            "{:?}",
            b.remarks
        );
    }
}

#[test]
fn a_wrong_connection_is_refused_before_a_fit() {
    let mut inverted = made(&paper(), "square:15Hz:8V", 0.2, 1);
    for x in inverted.voltage.iter_mut().flatten() {
        *x = -*x;
    }
    let error = run(&paper(), &[part(inverted)], &options(&["eta"])).unwrap_err();
    assert!(error.to_string().contains("give --sign V=-1"), "{error}");
}

#[test]
fn a_shifted_clock_gives_the_same_values() {
    let truth = paper();
    let start = off(paper(), &START_FACTORS);
    let free = options(&["eta", "dp"]);
    let parts = vec![part(made(&truth, "sine:50Hz:8V", 0.05, 1))];
    let r = &parts[0].recording;
    let time = r.time.iter().map(|t| t + 0.25).collect();
    let (volts, xc) = (r.voltage.clone(), r.cantilever.clone());
    let later = Recording::new("later", time, volts, r.proof_mass.clone(), xc).unwrap();
    let a = run(&start, &parts, &free).unwrap();
    let b = run(&start, &[part(later)], &free).unwrap();
    for (a, b) in a.parameters.iter().zip(&b.parameters) {
        assert!(
            (a.value - b.value).abs() < 0.5 * a.std_error,
            "{}: {a:?} {b:?}",
            a.id
        );
    }
}

#[test]
fn a_cancelled_fit_keeps_the_best_so_far() {
    let parts = two(&paper());
    let start = off(paper(), &START_FACTORS);
    let cancel = AtomicBool::new(false);
    let calls = AtomicUsize::new(0);
    let stop = |_: &Progress| {
        if calls.fetch_add(1, Ordering::Relaxed) == 1 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let control = Control {
        cancel: &cancel,
        progress: &stop,
    };
    let result = fit(&start, &parts, &[], &options(&["eta", "dp"]), &control).unwrap();
    assert!(result.cancelled);
    assert!(calls.load(Ordering::Relaxed) < 4);
    let eta = result.model.get("eta").unwrap() / paper().get("eta").unwrap();
    assert!((eta - 1.0).abs() < 0.3, "{eta}");
}

#[test]
fn a_bare_oscillator_is_fitted() {
    let mut truth = Preset::embedded("oscillator").unwrap().model;
    truth.set("zeta1", 0.004).unwrap();
    let trace = simulate(
        &truth,
        &Waveform::Rest,
        10.0,
        &Options {
            rate: 100.0,
            ..Options::default()
        },
    );
    let mut trace = trace.unwrap();
    let sensor = Sensor {
        noise: 1e-3,
        ..Sensor::default()
    };
    sensor.add_noise(&mut trace.proof_mass, 3);
    let recording = Recording::new("o", trace.times(), None, trace.proof_mass.clone(), None);
    let start = off(truth.clone(), &[("f1", 1.5), ("zeta1", 0.5)]);
    let free = FitOptions::for_model(&start);
    let result = run(&start, &[part(recording.unwrap())], &free).unwrap();
    for p in &result.parameters {
        let expected = truth.get(&p.id).unwrap();
        let miss = (p.value - expected) / p.std_error;
        assert!(
            miss.abs() < 4.0,
            "{}: {} should be {expected}",
            p.id,
            p.value
        );
    }
}

#[test]
fn viscous_quadratic_and_dry_damping_are_fitted_together() {
    let mut truth = paper();
    truth.has_ground = false;
    let laws = [("quadratic_drag", "cd", 2e-7), ("dry_friction", "fc", 5e-9)];
    for (id, parameter, value) in laws {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        assert!(effect.set(parameter, value));
        truth.effects.push(effect);
    }
    let factors = [
        ("zeta1", 1.6),
        ("quadratic_drag.cd", 0.5),
        ("dry_friction.fc", 2.0),
    ];
    let parts = vec![
        part(made(&truth, "square:40Hz:6V", 0.1, 1)),
        part(made(&truth, "sine:50Hz:8V", 0.06, 2)),
    ];
    let free = FitOptions {
        free: factors.map(|(id, _)| id.to_owned()).to_vec(),
        ..FitOptions::for_model(&truth)
    };
    let found = run(&off(truth.clone(), &factors), &parts, &free).unwrap();
    assert_eq!(found.parameters.len(), 3);
    for p in &found.parameters {
        let expected = truth.get(&p.id).unwrap();
        let off = (p.value - expected).abs();
        assert!(off < 5.0 * p.std_error + 0.02 * expected, "{p:?}");
        assert!(p.std_error < 0.2 * expected, "{p:?}");
    }
}

#[test]
fn a_profile_is_the_parabola_of_the_standard_errors() {
    let truth = paper();
    let parts = two(&truth);
    let free = options(&["dp", "alpha", "Cs", "gp"]);
    let result = run(&truth, &parts, &free).unwrap();
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    let shifts = [-3.0, 0.0, 3.0];
    for fitted in &result.parameters {
        let id = &fitted.id;
        let points = profile_of(&result, &parts, id, &shifts, &free, &control).unwrap();
        let middle = points[1].value;
        assert!((middle - fitted.value).abs() < 0.3 * fitted.std_error);
        assert_eq!(points.len(), 3);
        for (point, shift) in points.iter().zip(shifts) {
            let at = (point.value - middle) / fitted.std_error;
            assert!((at - shift).abs() < 1e-6, "{id}: {points:?}");
            let expected = shift * shift;
            assert!(
                (point.rise - expected).abs() < 0.05 + 0.15 * expected,
                "{id}: {points:?}"
            );
        }
    }
    let error = profile_of(&result, &parts, "f1", &[1.0], &free, &control).unwrap_err();
    assert!(error.to_string().contains("f1 was not fitted"), "{error}");
}

#[test]
fn a_failed_fit_names_recordings_of_different_devices() {
    let model = paper();
    let mut other = model.clone();
    other.set("f1", 500.0).unwrap();
    let parts = [
        part(made(&model, "sine:50Hz:8V", 0.04, 1)),
        part(made(&other, "sine:50Hz:8V", 0.04, 2)),
    ];
    let free = options(&["eta", "zeta1"]);
    let result = run(&model, &parts, &free).unwrap();
    let says = |words: &str| result.remarks.iter().any(|r| r.contains(words));
    assert!(says("does not fit"), "{:?}", result.remarks);
    assert!(says("different devices"), "{:?}", result.remarks);
    assert!(says("f1 is"), "{:?}", result.remarks);
    // One of them by itself is as it should be.
    let result = run(&model, &parts[..1], &free).unwrap();
    assert!(
        result.remarks.iter().all(|r| !r.contains("does not fit")),
        "{:?}",
        result.remarks
    );
}

#[test]
fn requested_starts_are_made() {
    let parts = two(&paper());
    let stages = |starts: usize| {
        let begun = AtomicUsize::new(0);
        let last = std::sync::Mutex::new("");
        let progress = |p: &Progress| {
            let before = std::mem::replace(&mut *last.lock().unwrap(), p.stage);
            if p.stage == "drive and structure" && before != p.stage {
                begun.fetch_add(1, Ordering::Relaxed);
            }
        };
        let cancel = AtomicBool::new(false);
        let control = Control {
            cancel: &cancel,
            progress: &progress,
        };
        let how = FitOptions {
            starts,
            ..options(&["eta", "zeta1"])
        };
        fit(&paper(), &parts, &[], &how, &control).unwrap();
        begun.load(Ordering::Relaxed)
    };
    assert_eq!((stages(0), stages(1)), (1, 2));
}

#[test]
fn a_cancelled_fit_skips_event_revision_and_held_out_recordings() {
    // Every bounce obeys another law, so that events are read again and again.
    let mut truth = paper();
    truth.set("alpha", 0.6).unwrap();
    let parts = vec![part(made(&truth, "square:100Hz:8V", 0.05, 2))];
    let held = vec![part(made(&truth, "sine:50Hz:8V", 0.03, 3))];
    let cancel = AtomicBool::new(false);
    let after = AtomicUsize::new(0);
    let stop = |p: &Progress| {
        if cancel.load(Ordering::Relaxed) {
            after.fetch_add(1, Ordering::Relaxed);
        }
        if p.stage == "revising events" {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let control = Control {
        cancel: &cancel,
        progress: &stop,
    };
    let result = fit(&paper(), &parts, &held, &options(&["eta"]), &control).unwrap();
    assert!(result.cancelled && result.held_out.is_none());
    // Segments in work on other cores may still have said that they begin.
    assert!(after.load(Ordering::Relaxed) < 16, "{after:?}");
    let ended = |r: &String| r.contains("ended before it was done");
    assert!(result.remarks.iter().any(ended), "{:?}", result.remarks);
}
