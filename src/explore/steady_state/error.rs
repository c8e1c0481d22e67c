//! Why there is no answer.

use thiserror::Error;

use crate::sim::SimError;

/// Why a steady state was not computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SteadyError {
    /// An option makes no sense.
    #[error("{what}: {reason}")]
    Options {
        /// Which.
        what: &'static str,
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// The drive does not repeat.
    #[error(
        "the drive does not repeat, and so has no steady response; take sine, square, triangle, ramped or a repeating table"
    )]
    DriveNotPeriodic,
    /// Something else that acts on the device does not repeat with the drive.
    #[error(
        "{what} does not repeat with the drive's period of {period} s, and so there is no periodic response; switch it off, or make one frequency a multiple of the other"
    )]
    DeviceNotPeriodic {
        /// What.
        what: &'static str,
        /// The drive's period \[s\].
        period: f64,
    },
    /// The response cannot begin so.
    #[error("start: {0}")]
    Start(String),
    /// The simulation ended early: model or drive is invalid, or the motion cannot be followed.
    #[error(transparent)]
    Simulation(#[from] SimError),
    /// The caller ended it.
    #[error("cancelled")]
    Cancelled,
}
