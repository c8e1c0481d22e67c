//! Why feet make no gait.

use thiserror::Error;

use crate::model::drive::DriveError;

/// What is wrong, with which foot, and what to do.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GaitError {
    /// Too few or too many feet.
    #[error("{found} feet; a gait has {} to {}", super::FOOT_COUNTS.0, super::FOOT_COUNTS.1)]
    Count { found: usize },
    /// The drive does not repeat.
    #[error("the drive's period of {0} s is no period; feet need a drive that repeats")]
    Period(f64),
    /// A value of a foot.
    #[error("foot \"{foot}\": {reason}")]
    Foot { foot: String, reason: String },
    /// Feet whose common cycle is too long.
    #[error(
        "the feet repeat together only after {periods} periods of the drive, and no more than {most} are drawn; choose feet with cycles of fewer periods"
    )]
    CommonCycle { periods: u64, most: u64 },
    /// A drive that cannot be delayed.
    #[error(
        "{0} has no period by a share of which it could be delayed; choose a periodic waveform"
    )]
    Delay(String),
    /// The delayed drive is out of range.
    #[error(transparent)]
    Drive(#[from] DriveError),
}
