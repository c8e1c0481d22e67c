//! What a diagnosis is asked to do, how it is watched, and why it may fail.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::fit::{Control, FitError, ParameterChoices};
use crate::sim::SimError;

/// What a diagnosis is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnoseOptions {
    /// Ids of effects that are compared; all of the catalogue if empty.
    pub candidates: Vec<String>,
    /// Ids of effects to add in place of a search: they are fitted and compared on held-out
    /// recordings, whatever they gain. Empty: the baseline alone.
    pub by_hand: Option<Vec<String>>,
    /// Most effects that are named.
    pub most: usize,
    /// Error that a step of the simulation may make, as a share of the noise of the quietest recording
    /// \[-\].
    pub tolerance: f64,
    /// Parameters that the re-tuning may move, holds, or moves against what is known of them. With none
    /// free the model is diagnosed as it is.
    pub choices: ParameterChoices,
    /// Time after which the diagnosis ends with the best answer so far; `None` for no limit.
    pub budget: Option<Duration>,
}

impl Default for DiagnoseOptions {
    fn default() -> Self {
        Self {
            candidates: Vec::new(),
            by_hand: None,
            most: 3,
            tolerance: 5e-4,
            choices: ParameterChoices::default(),
            budget: None,
        }
    }
}

impl DiagnoseOptions {
    /// Whether an effect is among the candidates.
    pub fn has_candidate(&self, id: &str) -> bool {
        self.candidates.is_empty() || self.candidates.iter().any(|c| c == id)
    }

    /// Whether an effect may be named, in a search or by hand.
    pub fn asks(&self, id: &str) -> bool {
        let by_hand = |all: &Vec<String>| all.iter().any(|c| c == id);
        self.by_hand
            .as_ref()
            .map_or_else(|| self.has_candidate(id), by_hand)
    }
}

/// How far a diagnosis has come.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnoseProgress {
    /// What is being done.
    pub stage: &'static str,
    /// More about it: the effect that is being fitted.
    pub detail: String,
    /// Share of the work that is done, 0 to 1, as far as one can tell.
    pub done: f64,
    /// Time left, as far as one can tell.
    pub remaining: Duration,
}

impl DiagnoseProgress {
    /// The stage in words.
    pub fn stage_text(&self) -> &'static str {
        match self.stage {
            "recordings" => "Reading the recordings",
            "baseline" => "Re-tuning the model",
            "ground" => "Reading the contact events",
            "naming" => "Comparing effects",
            "evidence" => "Measuring the missing force",
            "proof" => "Checking on held-out recordings",
            "done" => "Done",
            other => other,
        }
    }
}

/// Means to watch a diagnosis and to end it early.
#[derive(Clone, Copy)]
pub struct DiagnoseControl<'a> {
    /// Set to true, the diagnosis ends soon with what it has found.
    pub cancel: &'a AtomicBool,
    /// Called at each step.
    pub progress: &'a (dyn Fn(&DiagnoseProgress) + Sync),
}

impl DiagnoseControl<'_> {
    /// Whether to stop.
    pub fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// The same for a fit, whose progress is not reported.
    pub fn quiet(&self) -> Control<'_> {
        Control {
            cancel: self.cancel,
            progress: &|_| {},
        }
    }
}

/// Reports the stages of a diagnosis as they begin.
pub(crate) struct Stages<'a> {
    /// Who watches.
    pub control: &'a DiagnoseControl<'a>,
    begun: Instant,
}

impl<'a> Stages<'a> {
    /// From now on.
    pub fn begin(control: &'a DiagnoseControl<'a>) -> Self {
        Self {
            control,
            begun: Instant::now(),
        }
    }

    /// A stage begins, or a part of it, with so much of the whole done, 0 to 1.
    pub fn enter(&self, stage: &'static str, detail: &str, done: f64) {
        (self.control.progress)(&DiagnoseProgress {
            stage,
            detail: detail.to_owned(),
            done,
            remaining: remaining(done, self.begun.elapsed()),
        });
    }
}

/// Why there is no diagnosis.
#[derive(Debug, Error)]
pub enum DiagnoseError {
    /// A recording or the model cannot be used.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The model cannot be simulated.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// An id is not in the catalogue.
    #[error("there is no effect \"{id}\"; the catalogue has {known}")]
    UnknownEffect {
        /// The id.
        id: String,
        /// The ids there are.
        known: String,
    },
    /// There is nothing to diagnose.
    #[error("give at least one recording to diagnose")]
    NoRecording,
}

/// The result, or `None` where the model cannot be simulated.
///
/// # Errors
/// Any other [`DiagnoseError`].
pub fn simulated<T>(made: Result<T, DiagnoseError>) -> Result<Option<T>, DiagnoseError> {
    match made {
        Ok(made) => Ok(Some(made)),
        Err(DiagnoseError::Sim(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

/// An estimate of the time left from the share done and the time it took.
pub fn remaining(done: f64, elapsed: Duration) -> Duration {
    if done <= 0.0 {
        return Duration::ZERO;
    }
    elapsed.mul_f64(((1.0 - done) / done).clamp(0.0, 1e4))
}
