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
#[cfg(test)]
mod tests;

use thiserror::Error;

use super::error::FitError;

/// Why a step cannot be taken with a recording.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StepError {
    /// The fit within a step does not begin, or has no result.
    #[error(transparent)]
    Fit(#[from] FitError),
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

/// A number with what it counts, singular or plural.
fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Distances of the model from stretches, in units of the noise, from which what is read at
/// the ground in them leans on a model that is not right.
const MAX_READING_NOISE_RATIO: f64 = 1.3;

/// A warning where the model is `off` by so many times the noise in what was read.
pub fn far_off(off: f64) -> Option<String> {
    (off > MAX_READING_NOISE_RATIO).then(|| {
        format!(
            "The model is {off:.1} times the noise off in the stretches that were read: speeds and forces at the ground lean on its film and drive, and may be wrong by more than the errors say. Fit the whole device first, or its film."
        )
    })
}
