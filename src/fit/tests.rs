use super::*;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::recording::Recording;
use crate::sim::{Options, simulate};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

fn paper() -> Model {
    Preset::embedded("paper").unwrap().model
}

fn made(model: &Model, drive: &str, duration: f64, seed: u64) -> Recording {
    with_noise(model, drive, duration, seed, 20e-9)
}

fn with_noise(model: &Model, drive: &str, duration: f64, seed: u64, noise: f64) -> Recording {
    let waveform = Waveform::parse(drive, duration).unwrap();
    let mut trace = simulate(model, &waveform, duration, &Options::default()).unwrap();
    let sensor = Sensor {
        noise,
        ..Sensor::default()
    };
    sensor.add_noise(&mut trace.proof_mass, seed);
    sensor.add_noise(&mut trace.cantilever, seed + 1000);
    let (time, volts) = (trace.times(), Some(trace.voltage.clone()));
    let xc = Some(trace.cantilever.clone());
    Recording::new(drive, time, volts, trace.proof_mass.clone(), xc).unwrap()
}

fn part(recording: Recording) -> Part {
    Part::whole(Arc::new(recording))
}

fn two(model: &Model) -> Vec<Part> {
    vec![
        part(made(model, "sine:50Hz:8V", 0.05, 1)),
        part(made(model, "square:100Hz:8V", 0.03, 2)),
    ]
}

fn options(free: &[&str]) -> FitOptions {
    FitOptions {
        free: free.iter().map(|id| (*id).to_owned()).collect(),
        ..FitOptions::for_model(&paper())
    }
}

fn run(start: &Model, parts: &[Part], options: &FitOptions) -> Result<FitResult, FitError> {
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    fit(start, parts, &[], options, &control)
}

fn off(mut model: Model, changes: &[(&str, f64)]) -> Model {
    for (id, factor) in changes {
        let value = model.get(id).unwrap();
        model.set(id, value * factor).unwrap();
    }
    model
}

const START: [(&str, f64); 3] = [("eta", 0.6), ("zeta1", 1.5), ("dp", 1.1)];

#[test]
fn a_bad_start_leads_back_and_the_result_repeats() {
    let truth = paper();
    let start = off(paper(), &START);
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
fn a_later_clock_gives_the_same() {
    let truth = paper();
    let start = off(paper(), &START);
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
fn cancelled_it_keeps_the_best_so_far() {
    let parts = two(&paper());
    let start = off(paper(), &START);
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
fn values_stay_within_their_bounds() {
    // A ground that throws the mass off faster than it came.
    let mut truth = paper();
    truth.set("alpha", 1.0).unwrap();
    truth.set("Ca0", 0.0).unwrap();
    let parts = vec![part(made(&truth, "square:300Hz:6V", 0.02, 5))];
    let start = off(truth.clone(), &[("alpha", 0.6)]);
    let result = run(&start, &parts, &options(&["alpha", "eta", "dp"])).unwrap();
    let alpha = result.model.get("alpha").unwrap();
    assert!(alpha <= 1.0, "{alpha}");
    result.model.check().unwrap();
}

#[test]
fn bad_input_is_named_before_anything_is_computed() {
    let model = paper();
    let good = || made(&model, "sine:50Hz:8V", 0.03, 1);
    let all = FitOptions::for_model(&model);
    let says = |parts: Vec<Part>, options: &FitOptions, words: &str| {
        let error = run(&model, &parts, options).unwrap_err().to_string();
        assert!(error.contains(words), "\"{error}\" should say \"{words}\"");
    };
    says(
        vec![part(good())],
        &options(&[]),
        "all parameters are locked",
    );
    says(
        vec![part(good())],
        &options(&["foo"]),
        "there is no parameter foo",
    );
    says(Vec::new(), &all, "no recording");
    let r = good();
    let few = Recording::new(
        "few",
        r.time[..15].to_vec(),
        None,
        r.proof_mass[..15].to_vec(),
        None,
    );
    says(vec![part(few.unwrap())], &all, "too few");
    let mut none = good();
    none.voltage = None;
    says(vec![part(none)], &all, "no drive channel");
    let mut constant = good();
    constant.proof_mass.fill(1e-5);
    says(vec![part(constant)], &all, "constant");
    let mut saturated = good();
    saturated
        .proof_mass
        .iter_mut()
        .for_each(|x| *x = x.min(40e-6));
    says(vec![part(saturated)], &all, "saturated");
    let air = made(&model, "sine:50Hz:1V", 0.03, 1);
    says(vec![part(air)], &all, "no contact");
    let mut other = model.clone();
    other.set("dp", 35e-6).unwrap();
    other.set("gp", 47e-6).unwrap();
    let other = made(&other, "sine:50Hz:8V", 0.03, 2);
    says(vec![part(good()), part(other)], &all, "another device");
    let held = part(made(&model, "sine:50Hz:1V", 0.03, 1));
    assert!(run(&model, &[held], &options(&["eta", "zeta1"])).is_ok());
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
fn a_profile_is_the_parabola_that_the_errors_promise() {
    let truth = paper();
    // Little noise, so that even the film's valley is straight over three errors.
    let parts = vec![
        part(with_noise(&truth, "sine:50Hz:8V", 0.05, 1, 1e-9)),
        part(with_noise(&truth, "square:100Hz:8V", 0.03, 2, 1e-9)),
    ];
    let free = options(&["eta", "dp", "zeta1", "alpha", "Cs", "gp"]);
    let result = run(&truth, &parts, &free).unwrap();
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    for id in ["dp", "gp", "Cs", "alpha"] {
        let fitted = result.parameters.iter().find(|p| p.id == id).unwrap();
        let points =
            profile_of(&result, &parts, id, &[-3.0, 0.0, 1.0, 3.0], &free, &control).unwrap();
        let shift = |p: &ProfilePoint| (p.value - fitted.value) / fitted.std_error;
        let row: Vec<(f64, f64)> = points.iter().map(|p| (shift(p), p.rise)).collect();
        for ((at, rise), expected) in
            row.iter()
                .zip([(-3.0, 9.0), (0.0, 0.0), (1.0, 1.0), (3.0, 9.0)])
        {
            assert!((at - expected.0).abs() < 1e-6, "{id}: {row:?}");
            assert!(
                (rise - expected.1).abs() < 0.2 + 0.1 * expected.1,
                "{id}: {row:?}"
            );
        }
    }
    let error = profile_of(&result, &parts, "f1", &[1.0], &free, &control).unwrap_err();
    assert!(error.to_string().contains("f1 was not fitted"), "{error}");
}
