//! Why features are not given.

use thiserror::Error;

use crate::model::unit::format_quantity;

/// Why a feature is not given.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Missing {
    /// Lengths of time, voltage and position differ.
    #[error("time, voltage and position have different lengths")]
    BadInput,
    /// Too few samples.
    #[error("{samples} samples are too few")]
    TooShort {
        /// Usable samples.
        samples: usize,
    },
    /// The position hardly changes.
    #[error("the mass moves no more than the noise")]
    NoMotion,
    /// No voltage and no period.
    #[error("no voltage was recorded, so the period is unknown; give the period")]
    NoVoltage,
    /// The voltage does not alternate.
    #[error("the voltage does not alternate, so there is no period")]
    ConstantVoltage,
    /// The voltage is not periodic.
    #[error("the voltage is not periodic: its cycles differ by {spread_percent:.0} %")]
    NotPeriodic {
        /// Spread of the cycles' lengths in percent of the median.
        spread_percent: f64,
    },
    /// Too few whole periods.
    #[error(
        "{} of the drive in this span; at least 2 are needed: make it longer",
        periods(*found)
    )]
    TooFewPeriods {
        /// Whole periods.
        found: usize,
    },
    /// No low rest.
    #[error(
        "there is no low level at which the mass rests: a contact of a millisecond would show the ground"
    )]
    NoRest,
    /// The rest is not the floor.
    #[error("the mass rests at {} but also moves below it, so that is not the ground: a longer contact would show it", format_quantity(*level, "m", 4))]
    NotAFloor {
        /// The level in question \[m\].
        level: f64,
    },
    /// Nothing shows that the rest is a contact.
    #[error("the mass settles at {} without a sudden stop, so that may not be the ground: a drive that jumps or a longer contact would show it", format_quantity(*level, "m", 4))]
    NoArrival {
        /// The level in question \[m\].
        level: f64,
    },
    /// The motion does not repeat.
    #[error(
        "the motion does not become periodic: {unlike} of {periods} later periods are unlike the others"
    )]
    NotSteady {
        /// Periods unlike the median one.
        unlike: usize,
        /// Periods looked at.
        periods: usize,
    },
}

/// A number of whole periods in words.
fn periods(count: usize) -> String {
    match count {
        0 => "no whole period".to_owned(),
        1 => "one whole period".to_owned(),
        n => format!("{n} whole periods"),
    }
}
