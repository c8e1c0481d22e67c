//! The paper's identification (section 4), step by step. Each step is a function from
//! recordings to numbers with their uncertainty and the points of its figure.

pub mod drive;

use thiserror::Error;

/// Why a step cannot be taken with a recording.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StepError {
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
