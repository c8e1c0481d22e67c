//! Options of a run and the ways it can end early.

use thiserror::Error;

use crate::model::ModelError;
use crate::model::drive::DriveError;

/// How accurately, how densely and how long to simulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Samples per second of the trace \[Hz\].
    pub rate: f64,
    /// Bound on the local error of a step, as displacement of the proof mass \[m\].
    pub tolerance: f64,
    /// If set, steps of this length \[s\] are taken whatever their error, for studies of
    /// convergence.
    pub fixed_step: Option<f64>,
    /// If set, no step is longer than this \[s\]: a run that is watched shows what it has
    /// reached between steps.
    pub longest_step: Option<f64>,
    /// Whether to record forces.
    pub forces: bool,
    /// Steps after which a run is given up.
    pub max_steps: u64,
    /// Steps that a run may take however little it advances; more are given with each second of
    /// device time and each piece of the drive. They end a motion too fast or too stiff to follow.
    /// Not for a `fixed_step`.
    pub max_steps_at_once: u64,
    /// Events after which a run is given up.
    pub max_events: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            rate: 50e3,
            tolerance: 1e-12,
            fixed_step: None,
            longest_step: None,
            forces: false,
            max_steps: 20_000_000,
            // Some 4 s of work.
            max_steps_at_once: 1_000_000,
            max_events: 1_000_000,
        }
    }
}

impl Options {
    /// Checks the values.
    ///
    /// # Errors
    /// [`SimError::Options`].
    pub fn check(&self) -> Result<(), SimError> {
        let within = |what, value: f64, low: f64, high: f64| {
            if value >= low && value <= high {
                Ok(())
            } else {
                Err(SimError::Options {
                    what,
                    reason: format!("{value:e} is outside {low:e} .. {high:e}"),
                })
            }
        };
        within("sample rate [Hz]", self.rate, 1e-6, 1e10)?;
        within("tolerance [m]", self.tolerance, 1e-18, 1.0)?;
        if let Some(step) = self.fixed_step {
            within("fixed step [s]", step, 1e-12, 1e3)?;
        }
        Ok(())
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
    #[error("the motion diverges at t = {time:.6} s; first suspect is {parameter}: {advice}")]
    Diverged {
        time: f64,
        parameter: &'static str,
        advice: &'static str,
    },
    /// No step was small enough.
    #[error("no step is small enough at t = {time:.6} s; first suspect is {parameter}: {advice}")]
    StepTooSmall {
        time: f64,
        parameter: &'static str,
        advice: &'static str,
    },
    /// The work exceeded `max_steps` or `max_events`.
    #[error(
        "gave up at t = {time:.6} s after {count} {what}; first suspect is {parameter}: {advice}"
    )]
    TooMuchWork {
        time: f64,
        what: &'static str,
        count: u64,
        parameter: &'static str,
        advice: &'static str,
    },
}

/// What a run that is given up has spent its work on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Burden {
    /// Impacts and releases.
    Contacts,
    /// Corners of the drive.
    Drive,
    /// Steps of the usual length, too many of them.
    Span,
    /// Short steps that an effect of this id, or "effects", may need.
    Effect(&'static str),
    /// Short steps over the ground.
    Film,
    /// Short steps elsewhere.
    Motion,
}

impl SimError {
    pub(super) fn diverged(time: f64) -> Self {
        SimError::Diverged {
            time,
            parameter: "eta",
            advice: "a force grows without bound; lower the drive gain, or the strength of an effect that was switched on",
        }
    }

    pub(super) fn step_too_small(time: f64) -> Self {
        SimError::StepTooSmall {
            time,
            parameter: "gp",
            advice: "the film is all but singular at contact; make gp - dp larger or Cs smaller",
        }
    }

    pub(super) fn too_much(time: f64, what: &'static str, count: u64, why: Burden) -> Self {
        let (parameter, advice) = match why {
            Burden::Contacts => (
                "alpha",
                "the mass chatters on the ground; lower alpha or raise Ca0",
            ),
            Burden::Drive => (
                "drive",
                "it turns far more often than the device can follow; lower its frequency or thin its table, or make the span shorter",
            ),
            Burden::Span => (
                "duration",
                "the steps are as long as the fastest mode allows; make the span shorter",
            ),
            Burden::Effect(id) => (
                id,
                "the motion is too fast or too stiff to be followed with it; make it weaker, slower or softer, or the span shorter",
            ),
            Burden::Film => (
                "gp",
                "the film needs very small steps; make gp - dp larger, or the span shorter",
            ),
            Burden::Motion => (
                "f1",
                "the motion needs very small steps; check frequencies, dampings and effects, or make the span shorter",
            ),
        };
        SimError::TooMuchWork {
            time,
            what,
            count,
            parameter,
            advice,
        }
    }

    /// Id of the parameter to look at first, if the error names one.
    pub fn parameter(&self) -> Option<&str> {
        match self {
            SimError::Model(error) => Some(&error.parameter),
            SimError::Drive(_) => Some("drive"),
            SimError::Options { .. } => None,
            SimError::Diverged { parameter, .. }
            | SimError::StepTooSmall { parameter, .. }
            | SimError::TooMuchWork { parameter, .. } => Some(parameter),
        }
    }
}
