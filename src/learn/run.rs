//! A scene of a lesson, and its run.

use std::sync::Arc;

use super::energy::{EnergyTrace, run_with_energies};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::sim::{Options, Runner, SimError, Trace};

/// Most samples of a run: more show nothing in a picture and take long.
const MAX_RUN_SAMPLES: f64 = 400_000.0;
/// Samples per second over a ground, where contacts and bounces are short \[Hz\].
const GROUND_RATE: f64 = 50e3;
/// Samples in a period of the fastest mode of a device without ground.
const SAMPLES_PER_PERIOD: f64 = 64.0;
/// Fewest samples of a run, so that a slow motion is a smooth line.
const MIN_RUN_SAMPLES: f64 = 1000.0;
/// Largest step of a scene's work \[steps\]: some seconds. A lesson is watched, not waited for.
const MAX_STEPS: u64 = 5_000_000;

/// A device, its drive and a span: all that a run depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The device with its slider ranges.
    pub preset: Preset,
    /// Its drive.
    pub drive: Waveform,
    /// How long \[s\].
    pub duration: f64,
}

/// A simulated scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The device.
    pub model: Arc<Model>,
    /// Its motion, with forces.
    pub trace: Arc<Trace>,
    /// Where its energy is.
    pub energies: EnergyTrace,
    /// Period of the drive, if it repeats \[s\].
    pub period: Option<f64>,
    /// How long it is \[s\].
    pub duration: f64,
    /// Its drive.
    pub drive: Waveform,
}

impl Scene {
    /// The scene of a preset with its usual drive.
    pub fn of_preset(preset: Preset) -> Self {
        // The drive was checked when the preset was read.
        let drive = Waveform::parse(&preset.drive, preset.duration).unwrap_or_default();
        Self {
            duration: preset.duration,
            drive,
            preset,
        }
    }

    /// Samples per second that show its motion.
    pub fn rate(&self) -> f64 {
        let model = &self.preset.model;
        let modes = model.structure().modes;
        let fastest = modes.iter().fold(0.0f64, |f, mode| f.max(mode.frequency));
        let wanted = if model.has_ground {
            GROUND_RATE
        } else {
            (SAMPLES_PER_PERIOD * fastest).min(GROUND_RATE)
        };
        wanted
            .max(MIN_RUN_SAMPLES / self.duration)
            .min(MAX_RUN_SAMPLES / self.duration)
    }

    /// Simulates it; `None` if `go_on` said no.
    ///
    /// # Errors
    /// [`SimError`], naming the parameter at fault.
    pub fn run(&self, go_on: &dyn Fn() -> bool) -> Result<Option<Run>, SimError> {
        let options = Options {
            rate: self.rate(),
            forces: true,
            max_steps: MAX_STEPS,
            ..Options::default()
        };
        let mut runner = Runner::new(&self.preset.model, &self.drive, &options)?;
        let mut trace = runner.new_trace();
        let energies = run_with_energies(&mut runner, &mut trace, self.duration, go_on)?;
        Ok(energies.map(|energies| Run {
            model: Arc::new(self.preset.model.clone()),
            trace: Arc::new(trace),
            energies,
            period: self.drive.period(),
            duration: self.duration,
            drive: self.drive.clone(),
        }))
    }
}
