//! The steps on made-up recordings of the `paper` device.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::adhesion::adhesion;
use super::restitution::restitution;
use crate::fit::readings::{Readings, readings};
use crate::fit::{Control, FitOptions, Part};
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::recording::Recording;
use crate::sim::{Options, simulate};

/// Both points under `drive`, 50 kHz, 20 nm of noise.
pub(super) fn recording(drive: &str, duration: f64) -> Arc<Recording> {
    let mut model = Preset::default().model;
    model.parameters.set(ParameterId::Noise, 20e-9);
    let waveform = Waveform::parse(drive, duration).unwrap();
    let trace = simulate(&model, &waveform, duration, &Options::default()).unwrap();
    let (mut xp, mut xc) = (trace.proof_mass.clone(), trace.cantilever.clone());
    let sensor = Sensor::new(&model.parameters);
    sensor.add_noise(&mut xp, 7);
    sensor.add_noise(&mut xc, 8);
    let (times, volts) = (trace.times(), trace.voltage.clone());
    Arc::new(Recording::new(drive, times, Some(volts), xp, Some(xc)).unwrap())
}

fn read(recordings: &[Arc<Recording>]) -> Readings {
    let model = Preset::default().model;
    let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    readings(&model, &parts, &FitOptions::for_model(&model), &control).unwrap()
}

#[test]
fn restitution_is_read_from_the_bounces_alone() {
    let found = restitution("taps", &read(&[recording("square:300Hz:6V", 0.05)])).unwrap();
    println!("{} +- {}, {:?}", found.mean, found.error, found.exponent);
    assert!(found.bounces.len() >= 8);
    assert!((found.mean - 0.378).abs() < 5.0 * found.error, "{found:?}");
    assert!(found.error < 0.003);
    assert!(found.constant > 1e-3, "{found:?}");
    // What does not bounce tells nothing.
    let none = restitution("rest", &Readings::default()).unwrap_err();
    assert!(none.to_string().contains("300 Hz"), "{none}");
}

#[test]
fn adhesion_is_read_from_the_releases_alone() {
    let ramps = [0.1, 0.2, 0.3].map(|l| recording(&format!("ramped:5Hz:8V:{l}"), 0.4));
    let found = adhesion("ramps", &read(&ramps)).unwrap();
    println!("{:?} {:?}", found.rate, found.start);
    assert!((found.rate.0 / 1.7e-6 - 1.0).abs() < 0.02, "{found:?}");
    assert!((found.start.0 / 27.43e-9 - 1.0).abs() < 0.05, "{found:?}");
    let (at, half) = found.band(0.08);
    assert!((at - (27.43e-9 + 0.08 * 1.7e-6)).abs() < 3.0 * half.max(0.2e-9));
    // Contacts of one length give no slope.
    let mut alike = read(&ramps[..1]);
    alike.releases.retain(|r| r.contact > 0.05);
    alike.releases.extend(alike.releases.clone());
    let error = adhesion("one", &alike).unwrap_err();
    assert!(error.to_string().contains("several lambda"), "{error}");
}
