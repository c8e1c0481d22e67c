//! Why there is no map.

use thiserror::Error;

/// What is wrong with a request, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MapError {
    /// An axis of an id that neither drive nor model has.
    #[error(
        "there is no \"{id}\" to vary; the drive {drive} has {of_drive}; the device has {of_model}"
    )]
    UnknownAxis {
        id: String,
        drive: String,
        of_drive: String,
        of_model: String,
    },
    /// An axis with a range or a number of points that makes no sense.
    #[error("axis {id}: {reason}")]
    Axis { id: String, reason: String },
    /// Not one or two axes, or twice the same.
    #[error("{0}")]
    Axes(String),
    /// No measure, or one twice.
    #[error("{0}")]
    Measures(String),
    /// Measures of contact on a device that has none.
    #[error(
        "the device {model} has no ground, and so {measures} cannot be mapped; take a device with a ground, or ask for {others}"
    )]
    NoGround {
        model: String,
        measures: String,
        others: String,
    },
    /// More points than memory is allowed for.
    #[error(
        "{points} points need {needed} MB of memory, more than the {allowed} MB allowed; take fewer points or measures, or compute the map in parts"
    )]
    TooLarge {
        points: u128,
        needed: u128,
        allowed: u128,
    },
    /// Drive, start or options that serve no point of the map.
    #[error("{0}")]
    Setup(String),
}
