//! The hybrid simulator: flight, events, contact.
//!
//! [`simulate`] is a pure function of model, drive and options. [`Runner`] does the
//! same piece by piece, for a device that runs live while its parameters change.

mod trace;

pub use trace::{Event, EventKind, ForceTraces, Trace};

use thiserror::Error;

use crate::model::drive::{DriveError, Waveform};
use crate::model::{Model, ModelError};

/// How accurately, how densely and how long to simulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Samples per second of the trace [Hz].
    pub rate: f64,
    /// Bound on the local error of a step, as displacement of the proof mass [m].
    pub tolerance: f64,
    /// If set, steps of this length [s] are taken whatever their error, for studies of
    /// convergence.
    pub fixed_step: Option<f64>,
    /// Whether to record forces.
    pub forces: bool,
    /// Steps after which a run is given up.
    pub max_steps: u64,
    /// Events after which a run is given up.
    pub max_events: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            rate: 50e3,
            tolerance: 1e-12,
            fixed_step: None,
            forces: false,
            max_steps: 50_000_000,
            max_events: 1_000_000,
        }
    }
}

/// Why a run ended early.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimError {
    /// The model makes no sense.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The drive makes no sense.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// Rate, span or tolerance make no sense.
    #[error("{what}: {reason}")]
    Options { what: &'static str, reason: String },
    /// The motion left the range of numbers.
    #[error("the motion diverges at t = {time} s; {parameter} is the first suspect: {advice}")]
    Diverged {
        time: f64,
        parameter: String,
        advice: &'static str,
    },
    /// No step was small enough.
    #[error("no step is small enough at t = {time} s; {parameter} is the first suspect: {advice}")]
    StepTooSmall {
        time: f64,
        parameter: String,
        advice: &'static str,
    },
    /// The work exceeded `max_steps` or `max_events`.
    #[error("gave up at t = {time} s after {count} {what}; {parameter} is the first suspect: {advice}")]
    TooMuchWork {
        time: f64,
        what: &'static str,
        count: u64,
        parameter: String,
        advice: &'static str,
    },
}

/// Simulates from rest at `t = 0` to `duration` [s], first sample at 0.
///
/// # Errors
/// [`SimError`], naming the parameter at fault and the time.
pub fn simulate(
    model: &Model,
    drive: &Waveform,
    duration: f64,
    options: &Options,
) -> Result<Trace, SimError> {
    let mut runner = Runner::new(model, drive, options)?;
    let mut trace = runner.new_trace();
    runner.advance(duration, &mut trace)?;
    Ok(trace)
}

/// A device in motion that can be advanced piece by piece and changed on the way.
#[derive(Debug, Clone)]
pub struct Runner {
    options: Options,
}

impl Runner {
    /// A device at its initial state at t = 0.
    ///
    /// # Errors
    /// [`SimError`] if model, drive or options make no sense.
    pub fn new(model: &Model, drive: &Waveform, options: &Options) -> Result<Self, SimError> {
        model.check()?;
        drive.check()?;
        Ok(Self { options: *options })
    }

    /// An empty trace to advance into.
    pub fn new_trace(&self) -> Trace {
        Trace { dt: 1.0 / self.options.rate, ..Trace::default() }
    }

    /// Time reached [s].
    pub fn time(&self) -> f64 {
        0.0
    }

    /// Runs on to `until` [s], appending samples, events and contacts to `trace`.
    ///
    /// # Errors
    /// [`SimError`]; `trace` holds what was reached.
    pub fn advance(&mut self, _until: f64, _trace: &mut Trace) -> Result<(), SimError> {
        Ok(())
    }

    /// Changes parameters on the running device: positions and velocities are kept.
    ///
    /// # Errors
    /// [`SimError`]; then nothing is changed.
    pub fn set_model(&mut self, _model: &Model) -> Result<(), SimError> {
        Ok(())
    }

    /// Changes the drive from now on.
    ///
    /// # Errors
    /// [`SimError`]; then nothing is changed.
    pub fn set_drive(&mut self, _drive: &Waveform) -> Result<(), SimError> {
        Ok(())
    }
}
