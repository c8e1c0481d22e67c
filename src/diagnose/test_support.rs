//! Recordings of known devices, for tests.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::options::{DiagnoseControl, DiagnoseOptions};
use super::shooting::fitted::Fitted;
use super::shooting::workspace::Workspace;
use crate::fit::Part;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, find};
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::model::{Model, with_effect};
use crate::recording::Recording;
use crate::sim::{Options, SimError, simulate};

static GO_ON: AtomicBool = AtomicBool::new(false);
/// Goes on to the end and tells nothing.
pub const QUIET: DiagnoseControl<'static> = DiagnoseControl {
    cancel: &GO_ON,
    progress: &|_| {},
};

/// The paper's device on a ground that steps by `height` \[m\] at `time` \[s\].
pub fn stepping(height: f64, time: f64) -> Model {
    let effect = ActiveEffect {
        spec: find("gap_step").unwrap(),
        values: vec![height, time],
    };
    with_effect(&Preset::embedded("paper").unwrap().model, effect)
}

/// Recordings of the paper's device with what is `concealed`, one for each drive and duration
/// \[s\], at `rate` \[1/s\] and with a `noise` \[m\], made ready.
pub fn workspace_of(concealed: &Model, drives: &[(&str, f64)], rate: f64, noise: f64) -> Workspace {
    workspace(&parts_of(concealed, drives, rate, noise))
}

/// What `gain` says that a probe would bring together with `start`, of which `free` are fitted to recordings
/// of the paper's device with `concealed`, as a share of what that fit brings.
pub fn gain_share(
    concealed: ActiveEffect,
    drives: &[(&str, f64)],
    (start, free): (ActiveEffect, &[String]),
    gain: fn(&Fitted) -> Result<f64, SimError>,
) -> f64 {
    let paper = Preset::embedded("paper").unwrap().model;
    let workspace = workspace_of(&with_effect(&paper, concealed), drives, 25e3, 20e-9);
    let base = workspace.baseline(&paper, &QUIET).unwrap();
    let start = with_effect(&base.model, start);
    let fitted = workspace.fit(&start, free, &[], &base, 12, &QUIET).unwrap();
    let fall = base.cost - fitted.cost;
    assert!(fall > 1e3, "{fall}");
    gain(&fitted).unwrap() / fall
}

/// Those recordings made ready for the paper's device.
pub fn workspace(parts: &[Part]) -> Workspace {
    let model = Preset::embedded("paper").unwrap().model;
    Workspace::new(&model, parts, &[], &DiagnoseOptions::default()).unwrap()
}

/// Those recordings as they are.
pub fn parts_of(concealed: &Model, drives: &[(&str, f64)], rate: f64, noise: f64) -> Vec<Part> {
    let options = Options {
        rate,
        ..Options::default()
    };
    let made = drives.iter().map(|(drive, duration)| {
        let waveform = Waveform::parse(drive, *duration).unwrap();
        let mut trace = simulate(concealed, &waveform, *duration, &options).unwrap();
        let sensor = Sensor {
            noise,
            ..Sensor::default()
        };
        sensor.add_noise(&mut trace.proof_mass, 1);
        sensor.add_noise(&mut trace.cantilever, 2);
        let (xp, xc) = (trace.proof_mass.clone(), trace.cantilever.clone());
        let (time, volts) = (trace.times(), trace.voltage.clone());
        let made = Recording::new(*drive, time, Some(volts), xp, Some(xc)).unwrap();
        Part::whole(Arc::new(made))
    });
    made.collect()
}
