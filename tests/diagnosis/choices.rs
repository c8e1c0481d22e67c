//! What a person decides or knows beforehand: parameters that are held, known values, the effects that
//! are compared, and the time.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use impactscope::diagnose::findings::{CandidateRemark, FindingKind, Remark};
use impactscope::diagnose::{
    DiagnoseControl, DiagnoseError, DiagnoseOptions, Diagnosis, Verdict, diagnose,
};
use impactscope::fit::{FixedParameter, ParameterChoices, Part};
use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::model::effects::{ActiveEffect, find};
use impactscope::model::preset::Preset;
use impactscope::model::sensor::Sensor;
use impactscope::recording::Recording;
use impactscope::sim::{Options, simulate};

fn answer(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    options: &DiagnoseOptions,
) -> Result<Diagnosis, DiagnoseError> {
    let go_on = AtomicBool::new(false);
    let control = DiagnoseControl {
        cancel: &go_on,
        progress: &|_| {},
    };
    diagnose(model, train, held_out, options, &control)
}

/// A recording of the motion of a device without drive from a height \[m\], for so long \[s\], read
/// 100 times a second with a noise \[m\].
fn released(model: &Model, height: f64, duration: f64, (noise, seed): (f64, u64)) -> Part {
    let mut model = model.clone();
    model.set("x0", height).unwrap();
    let options = Options {
        rate: 100.0,
        ..Options::default()
    };
    let mut trace = simulate(&model, &Waveform::Rest, duration, &options).unwrap();
    let sensor = Sensor {
        noise,
        ..Sensor::default()
    };
    sensor.add_noise(&mut trace.proof_mass, seed);
    let (time, xp) = (trace.times(), trace.proof_mass.clone());
    let name = format!("from {height} m");
    Part::whole(Arc::new(
        Recording::new(&name, time, None, xp, None).unwrap(),
    ))
}

/// Recordings of a swinging mass to fit to, and one to hold out.
fn swinging(model: &Model) -> (Vec<Part>, Vec<Part>) {
    let from = |height, seed| released(model, height, 10.0, (1e-4, seed));
    (vec![from(0.1, 1), from(0.05, 2)], vec![from(0.07, 3)])
}

fn nothing_free() -> DiagnoseOptions {
    DiagnoseOptions {
        choices: ParameterChoices {
            free: Some(Vec::new()),
            ..ParameterChoices::default()
        },
        ..DiagnoseOptions::default()
    }
}

#[test]
fn a_model_with_nothing_free_is_diagnosed_as_it_is() {
    let model = Preset::embedded("oscillator").unwrap().model;
    let (train, held_out) = swinging(&model);
    let found = answer(&model, (&train, &held_out), &nothing_free()).unwrap();
    assert!(
        found.remarks.contains(&Remark::NothingRetuned),
        "{:?}",
        found.remarks
    );
    assert!(found.named.is_empty(), "{:?}", found.named);
    for id in ["f1", "zeta1"] {
        assert_eq!(found.baseline.get(id), model.get(id), "{id}");
    }
    assert!(found.train.before.rms < 1.5e-4, "{:?}", found.train);
    // With a frequency that is 2 % off nothing makes up for it.
    let mut off = model.clone();
    off.set("f1", 1.02 * model.get("f1").unwrap()).unwrap();
    let found = answer(&off, (&train, &held_out), &nothing_free()).unwrap();
    assert_eq!(found.baseline.get("f1"), off.get("f1"));
    assert!(found.train.before.rms > 3e-4, "{:?}", found.train);
    assert_ne!(found.verdict, Verdict::Adequate);
}

#[test]
fn a_device_without_any_parameter_to_re_tune_is_diagnosed() {
    // A free fall without gravity: the mass moves evenly, and nothing of the device is free.
    let mut model = Preset::embedded("faller").unwrap().model;
    model.effects.clear();
    let mut moving = model.clone();
    moving.set("v0", -3.0).unwrap();
    let of = |height, seed| released(&moving, height, 2.0, (1e-3, seed));
    let (train, held_out) = (vec![of(40.0, 1), of(30.0, 2)], vec![of(35.0, 3)]);
    let found = answer(&model, (&train, &held_out), &DiagnoseOptions::default()).unwrap();
    assert!(
        found.remarks.contains(&Remark::NothingRetuned),
        "{:?}",
        found.remarks
    );
    assert!(found.named.is_empty(), "{:?}", found.named);
}

#[test]
fn parameters_that_are_held_stay_and_those_of_effects_are_held_as_usual() {
    let truth = Preset::embedded("oscillator").unwrap().model;
    let mut model = truth.clone();
    model.effects.push(ActiveEffect {
        spec: find("quadratic_drag").unwrap(),
        values: vec![1e-2, 0.0],
    });
    let (train, held_out) = swinging(&truth);
    let options = DiagnoseOptions {
        choices: ParameterChoices {
            fixed: vec![FixedParameter {
                id: "zeta1".to_owned(),
                value: Some(0.002),
            }],
            ..ParameterChoices::default()
        },
        // The re-tuning alone.
        by_hand: Some(Vec::new()),
        ..DiagnoseOptions::default()
    };
    let found = answer(&model, (&train, &held_out), &options).unwrap();
    assert_eq!(found.baseline.get("zeta1"), Some(0.002));
    assert_eq!(found.baseline.get("quadratic_drag.cd"), Some(1e-2));
    let held = Remark::HeldAsGiven(vec![
        "quadratic_drag.cd".to_owned(),
        "quadratic_drag.c".to_owned(),
    ]);
    assert!(found.remarks.contains(&held), "{:?}", found.remarks);
    // The drag is not there, and with it held the recordings say so.
    let elsewhere = found.remarks.iter().find_map(|remark| match remark {
        Remark::HeldElsewhere(held) => Some(held),
        _ => None,
    });
    let elsewhere = elsewhere.expect("the drag is needed at another value");
    assert!(
        elsewhere.id == "quadratic_drag.cd" && elsewhere.needed < 5e-3,
        "{elsewhere:?}"
    );
    let drag = found
        .candidates
        .iter()
        .find(|c| c.id == "quadratic_drag")
        .unwrap();
    assert_eq!(drag.remarks, [CandidateRemark::InModel]);
    // Freed it goes to nothing, and the answer says that it was re-tuned.
    let options = DiagnoseOptions {
        choices: ParameterChoices {
            also_free: vec!["quadratic_drag.cd".to_owned()],
            ..ParameterChoices::default()
        },
        // The re-tuning alone.
        by_hand: Some(Vec::new()),
        ..DiagnoseOptions::default()
    };
    let found = answer(&model, (&train, &held_out), &options).unwrap();
    let moved = found.remarks.iter().find_map(|remark| match remark {
        Remark::Retuned(all) => all.iter().find(|p| p.id == "quadratic_drag.cd"),
        _ => None,
    });
    let moved = moved.expect("it is said");
    assert!(moved.from == 1e-2 && moved.to < 5e-3, "{moved:?}");
}

/// A fall with a constant acceleration `g`, diagnosed with gravity known.
fn fallen(g: f64) -> Diagnosis {
    let preset = Preset::embedded("faller").unwrap();
    let mut falling = preset.model.clone();
    falling.set("gravity.g", g).unwrap();
    let of = |height, seed| released(&falling, height, 2.0, (1e-3, seed));
    let (train, held_out) = (vec![of(47.0, 1), of(40.0, 2)], vec![of(35.0, 3)]);
    let options = DiagnoseOptions {
        choices: ParameterChoices::default().resolve(&preset).unwrap(),
        // Nothing that could slow a fall.
        candidates: vec!["piezo_creep".to_owned()],
        ..DiagnoseOptions::default()
    };
    answer(&preset.model, (&train, &held_out), &options).unwrap()
}

#[test]
fn a_known_value_that_the_recordings_contradict_is_a_finding() {
    let found = fallen(7.3);
    let needs = found
        .findings
        .iter()
        .find_map(|finding| match &finding.kind {
            FindingKind::KnownContradicted(needs) => Some(needs),
            _ => None,
        });
    let remark = found.remarks.iter().find_map(|remark| match remark {
        Remark::KnownContradicted(needs) => Some(needs),
        _ => None,
    });
    let needs = needs.or(remark).expect("g is contradicted");
    assert!((needs.needed - 7.3).abs() < 0.05, "{needs:?}");
    assert_eq!(needs.known.value, 9.80665);
    assert_ne!(found.verdict, Verdict::Adequate);
    // What is known well enough is not contradicted, and what was re-tuned is said.
    let found = fallen(9.80);
    let contradicted = |kind: &FindingKind| matches!(kind, FindingKind::KnownContradicted(_));
    assert!(!found.findings.iter().any(|f| contradicted(&f.kind)));
    let said = |r: &Remark| matches!(r, Remark::KnownContradicted(_));
    assert!(!found.remarks.iter().any(said), "{:?}", found.remarks);
    let moved = |r: &Remark| matches!(r, Remark::Retuned(all) if all[0].id == "gravity.g");
    assert!(found.remarks.iter().any(moved), "{:?}", found.remarks);
}

#[test]
fn with_its_time_used_up_it_still_answers_and_says_what_was_not_compared() {
    let paper = Preset::default().model;
    let options = Options {
        rate: 25e3,
        ..Options::default()
    };
    let made = |drive: &str, seed: u64| {
        let waveform = Waveform::parse(drive, 0.1).unwrap();
        let mut trace = simulate(&paper, &waveform, 0.1, &options).unwrap();
        let sensor = Sensor {
            noise: 20e-9,
            ..Sensor::default()
        };
        sensor.add_noise(&mut trace.proof_mass, seed);
        sensor.add_noise(&mut trace.cantilever, seed + 100);
        let (xp, xc) = (trace.proof_mass.clone(), Some(trace.cantilever.clone()));
        let (time, volts) = (trace.times(), Some(trace.voltage.clone()));
        Part::whole(Arc::new(
            Recording::new(drive, time, volts, xp, xc).unwrap(),
        ))
    };
    let train = [made("square:40Hz:8V", 1), made("sine:50Hz:8V", 2)];
    let held_out = [made("square:100Hz:6V", 3)];
    let options = DiagnoseOptions {
        budget: Some(Duration::from_millis(200)),
        ..DiagnoseOptions::default()
    };
    let begun = Instant::now();
    let found = answer(&paper, (&train, &held_out), &options).unwrap();
    let took = begun.elapsed();
    assert!(found.cancelled);
    let open = found.remarks.iter().find_map(|remark| match remark {
        Remark::OutOfTime {
            seconds,
            not_compared,
        } => Some((*seconds, not_compared)),
        _ => None,
    });
    let (seconds, not_compared) = open.expect("it says so");
    assert!((seconds - 0.2).abs() < 1e-9 && !not_compared.is_empty());
    let reached = |c: &&impactscope::diagnose::diagnosis::Candidate| {
        c.remarks.contains(&CandidateRemark::NotReached)
    };
    assert_eq!(
        found.candidates.iter().filter(reached).count(),
        not_compared.len()
    );
    // Without a limit this takes far longer, on any machine.
    let whole = DiagnoseOptions::default();
    let begun = Instant::now();
    let full = answer(&paper, (&train, &held_out), &whole).unwrap();
    assert!(!full.cancelled && took < begun.elapsed(), "{took:?}");
}

#[test]
fn effects_that_are_not_candidates_are_not_named() {
    let truth = Preset::embedded("oscillator").unwrap().model;
    let mut dragged = truth.clone();
    dragged.effects.push(ActiveEffect {
        spec: find("quadratic_drag").unwrap(),
        values: vec![5e-2, 0.0],
    });
    let (train, held_out) = swinging(&dragged);
    let options = DiagnoseOptions {
        candidates: vec!["zero_drift".to_owned()],
        ..DiagnoseOptions::default()
    };
    let found = answer(&truth, (&train, &held_out), &options).unwrap();
    let named: Vec<&str> = found.named.iter().map(|n| n.id.as_str()).collect();
    assert!(!named.contains(&"quadratic_drag"), "{named:?}");
}

#[test]
fn choices_that_make_no_sense_are_refused() {
    let model = Preset::embedded("oscillator").unwrap().model;
    let (train, held_out) = swinging(&model);
    for (id, value, part) in [
        ("f11", None, "no such parameter"),
        ("zeta1", Some(-1.0), "below"),
        ("gp", None, "no effect on the device"),
    ] {
        let options = DiagnoseOptions {
            choices: ParameterChoices {
                fixed: vec![FixedParameter {
                    id: id.to_owned(),
                    value,
                }],
                ..ParameterChoices::default()
            },
            ..DiagnoseOptions::default()
        };
        let error = answer(&model, (&train, &held_out), &options).err();
        let text = error.map(|e| e.to_string()).unwrap_or_default();
        assert!(text.contains(part) && text.contains(id), "{text}");
    }
}
