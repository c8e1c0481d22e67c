//! What the window asks the simulator for.

use std::sync::Arc;

use crate::app::setup::drive_choice::Mode;
use crate::app::setup::overlay::{Overlay, have_same_numbers};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::Options;

/// Everything a result depends on. A request equal to the last one is not sent.
#[derive(Debug, Clone)]
pub struct SimulationRequest {
    /// The device.
    pub model: Arc<Model>,
    /// Its drive, resolved.
    pub drive: Waveform,
    /// Span of the whole-span mode, and of the view in live mode \[s\].
    pub duration: f64,
    /// Whether forces are recorded.
    pub forces: bool,
    /// Recordings to compare with.
    pub overlays: Vec<Overlay>,
    /// Whole span or live.
    pub mode: Mode,
    /// Whether the whole span begins in the steady response instead of at rest.
    pub from_steady: bool,
    /// Live: simulated seconds per wall second.
    pub slow_down: f64,
    /// Live: whether it is paused.
    pub paused: bool,
    /// Live: time looked at while scrubbing \[s\].
    pub scrub: Option<f64>,
    /// How many restarts were requested; a new count starts again at t = 0.
    pub restarts: u64,
    /// How many single steps were requested.
    pub steps: u64,
}

impl PartialEq for SimulationRequest {
    fn eq(&self, other: &Self) -> bool {
        self.same_run(other)
            && have_same_numbers(&self.overlays, &other.overlays)
            && self.mode == other.mode
            && self.slow_down == other.slow_down
            && self.paused == other.paused
            && self.scrub == other.scrub
            && self.restarts == other.restarts
            && self.steps == other.steps
    }
}

impl SimulationRequest {
    /// Samples per second that show this device's motion: 50 kHz on the ground, fewer
    /// for slow devices and very long spans.
    pub fn rate(&self) -> f64 {
        /// Bounds memory and drawing time of very long spans.
        const MAX_SAMPLES: f64 = 4e6;
        let fastest = self
            .model
            .structure()
            .modes
            .iter()
            .fold(0.0f64, |f, mode| f.max(mode.frequency));
        let rate = if self.model.has_ground {
            50e3
        } else {
            (64.0 * fastest).clamp(200.0, 50e3)
        };
        rate.min(MAX_SAMPLES / self.duration)
    }

    /// Options of the simulator for this request.
    pub fn options(&self) -> Options {
        Options {
            rate: self.rate(),
            forces: self.forces,
            // A run that takes longer than a few seconds is of no use while tuning.
            max_steps: 20_000_000,
            ..Options::default()
        }
    }

    /// Whether the simulated run is the same.
    pub(crate) fn same_run(&self, other: &SimulationRequest) -> bool {
        self.model == other.model
            && self.drive == other.drive
            && self.duration == other.duration
            && self.forces == other.forces
            && self.from_steady == other.from_steady
    }
}
