//! The paper's identification (section 4), step by step. Each step is a function from
//! recordings to numbers with their uncertainty and the points of its figure.

pub mod adhesion;
mod break_off;
pub mod drive;
pub mod film;
pub mod guide;
pub mod line_fit;
pub mod outcome;
pub mod restitution;
pub mod sensitivity;
pub mod summary;
#[cfg(test)]
mod tests;

use thiserror::Error;

use super::error::FitError;
use super::modal::ModalError;
use super::thresholds::MAX_READING_NOISE_RATIO;

/// Why a step cannot be taken with a recording.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StepError {
    /// The fit within a step does not begin, or has no result.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The modes cannot be identified.
    #[error(transparent)]
    Modal(#[from] ModalError),
    /// The device lacks what the step is about.
    #[error("the device {device} has no {what}: {step} cannot be identified")]
    Device {
        /// Name of the device.
        device: String,
        /// What it lacks.
        what: &'static str,
        /// The step.
        step: &'static str,
    },
    /// A channel is missing.
    #[error(
        "{recording} has no {channel}: {step} needs it; record it, or name its column on import"
    )]
    Channel {
        /// Name of the recording.
        recording: String,
        /// Symbol of the channel.
        channel: &'static str,
        /// The step.
        step: &'static str,
    },
    /// The recording does not show what the step needs.
    #[error("{recording}: {reason}; {remedy}")]
    Unsuited {
        /// Name of the recording.
        recording: String,
        /// What it lacks.
        reason: String,
        /// What to record instead.
        remedy: &'static str,
    },
}

/// That the model is `off` by too many times the noise in the segments that were read, if it is.
pub(super) fn model_distance(off: f64) -> Option<String> {
    (off > MAX_READING_NOISE_RATIO).then(|| {
        format!(
            "Where bounces and releases were read, the model is off by {off:.1} times the noise. Their speeds and forces depend on its film and drive, and may be wrong by more than their errors say."
        )
    })
}

/// The same with what to do.
pub fn model_distance_warning(off: f64) -> Option<String> {
    let warning = model_distance(off)?;
    Some(format!(
        "{warning} Fit the whole device first, or take the film step."
    ))
}
