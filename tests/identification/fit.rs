//! The fit on recordings made by the reference integrator, from bad starts: the figures
//! that the identification must reach.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use crate::oracle::{Device, Drive, Tolerance, run};
use impactscope::fit::{Control, FitOptions, FitResult, Part, fit};
use impactscope::model::Model;
use impactscope::model::preset::Preset;
use impactscope::model::sensor::Sensor;
use impactscope::recording::Recording;

const RATE: f64 = 50e3;
const NOISE: f64 = 20e-9;

/// The five excitations: drive, span [s].
const TRAIN: [(Drive, f64); 5] = [
    (
        Drive::Ramped {
            hz: 5.0,
            volt: 8.0,
            lambda: 0.25,
        },
        0.4,
    ),
    (
        Drive::Square {
            hz: 15.0,
            volt: 8.0,
        },
        0.2,
    ),
    (
        Drive::Sine {
            hz: 50.0,
            volt: 8.0,
        },
        0.12,
    ),
    (
        Drive::Square {
            hz: 50.0,
            volt: 6.0,
        },
        0.12,
    ),
    (
        Drive::Square {
            hz: 300.0,
            volt: 6.0,
        },
        0.05,
    ),
];

/// A drive that is not among them.
const HELD_OUT: (Drive, f64) = (
    Drive::Sine {
        hz: 30.0,
        volt: 7.0,
    },
    0.1,
);

/// Factors on the true values: 30 to 60 % off in each.
const START: [(&str, f64); 9] = [
    ("eta", 0.6),
    ("dp", 1.4),
    ("zeta1", 1.55),
    ("zeta2", 0.5),
    ("Cs", 1.5),
    ("gp", 0.65),
    ("Ca", 0.55),
    ("Ca0", 1.45),
    ("alpha", 1.35),
];

fn recording(device: &Device, (drive, span): (Drive, f64), seed: u64, both: bool) -> Part {
    let outcome = run(device, &drive, span, RATE, &Tolerance::relative(1e-9));
    let time: Vec<f64> = (0..outcome.samples.len())
        .map(|i| i as f64 / RATE)
        .collect();
    let pieces = drive.pieces(span * 1e3 + 1.0);
    let volts = time.iter().map(|t| {
        let ms = t * 1e3;
        let piece = pieces[pieces.partition_point(|p| p.start <= ms).saturating_sub(1)];
        piece.voltage(ms - piece.start).0
    });
    let sensor = Sensor {
        noise: NOISE,
        ..Sensor::default()
    };
    let channel = |k: usize, seed| {
        let mut values: Vec<f64> = outcome.samples.iter().map(|s| s[k]).collect();
        sensor.add_noise(&mut values, seed);
        values
    };
    let (volts, xp) = (volts.collect(), channel(1, 2 * seed));
    let xc = both.then(|| channel(0, 2 * seed + 1));
    let name = format!("{drive:?}");
    Part::whole(Arc::new(
        Recording::new(name, time, Some(volts), xp, xc).unwrap(),
    ))
}

fn film(model: &Model) -> f64 {
    let get = |id| model.get(id).unwrap();
    get("Cs") / (get("gp") - get("dp")).powi(3)
}

fn fitted(both: bool) -> (Model, FitResult) {
    let device = Device::paper();
    let truth = Preset::embedded("paper").unwrap().model;
    let train: Vec<Part> = TRAIN
        .iter()
        .enumerate()
        .map(|(i, case)| recording(&device, *case, i as u64, both))
        .collect();
    let held_out = [recording(&device, HELD_OUT, 77, both)];
    let mut start = truth.clone();
    for (id, factor) in START {
        start.set(id, truth.get(id).unwrap() * factor).unwrap();
    }
    // A film that would be singular before contact is no model that one can start from.
    if start.get("gp").unwrap() <= start.get("dp").unwrap() {
        start.set("gp", start.get("dp").unwrap() * 1.05).unwrap();
    }
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    let began = Instant::now();
    let options = FitOptions::for_model(&start);
    let result = fit(&start, &train, &held_out, &options, &control).unwrap();
    println!("{:.1} s", began.elapsed().as_secs_f64());
    (truth, result)
}

/// Checks values against the truth, `slack` times the tolerances for both channels.
fn check(truth: &Model, result: &FitResult, slack: f64) {
    for (id, tolerance) in [
        ("eta", 0.01),
        ("dp", 0.01),
        ("zeta1", 0.01),
        ("alpha", 0.03),
        ("Ca", 0.05),
        ("Ca0", 0.05),
    ] {
        let error = result.model.get(id).unwrap() / truth.get(id).unwrap() - 1.0;
        println!("{id}: {:+.3} %", 100.0 * error);
        assert!(
            error.abs() < slack * tolerance,
            "{id}: {:+.2} %",
            100.0 * error
        );
    }
    let error = film(&result.model) / film(truth) - 1.0;
    println!("film at contact: {:+.3} %", 100.0 * error);
    assert!(error.abs() < slack * 0.1, "film: {:+.2} %", 100.0 * error);
    let (held_out, _) = result.held_out.as_ref().unwrap();
    println!("held out: rms {:.1} nm", 1e9 * held_out.rms);
    assert!(held_out.rms < 2.0 * NOISE, "{held_out:?}");
}

#[test]
fn both_channels_from_a_bad_start() {
    let (truth, result) = fitted(true);
    check(&truth, &result, 1.0);
    // What is stated of the errors holds.
    for p in &result.parameters {
        let miss = (p.value - truth.get(&p.id).unwrap()) / p.std_error;
        assert!(miss.abs() < 5.0, "{}: {miss:.1} standard errors", p.id);
    }
}

#[test]
fn the_proof_mass_alone() {
    let (truth, result) = fitted(false);
    check(&truth, &result, 3.0);
}
