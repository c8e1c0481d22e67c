//! Why no shift between a recording and a simulation can be given.

use thiserror::Error;

/// Least correlation of a clear match: half of what moves is then explained.
pub(super) const MIN_CORRELATION: f64 = 0.7;

/// Why no shift could be found.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AlignError {
    /// The channel was not recorded.
    #[error("channel {0} was not recorded; align another channel")]
    NotRecorded(&'static str),
    /// One of the two does not move.
    #[error("the {which} is constant; there is nothing to align")]
    Constant {
        /// `recording` or `simulation`.
        which: &'static str,
    },
    /// Too few samples at every shift.
    #[error(
        "recording and simulation have too few samples in common at any shift; simulate as long as the recording, or record longer"
    )]
    NoOverlap,
    /// Nowhere do the two move alike.
    #[error(
        "no clear match: the best correlation at any shift is {correlation:.2} (at {shift:.4} s), {MIN_CORRELATION} is needed; the motions differ too much, often in frequency. Tune the model first, or shift by hand"
    )]
    NoMatch {
        /// Best correlation found.
        correlation: f64,
        /// Where it is \[s\].
        shift: f64,
    },
    /// The amplitudes have nothing to do with each other.
    #[error(
        "no clear match: the recording moves {ratio:.3} times as much as the simulation; set its scale or its unit first, then align again"
    )]
    Amplitude {
        /// Spread of the recording over that of the simulation.
        ratio: f64,
    },
    /// The grid is empty or its interval is not positive.
    #[error("the simulated trace is empty or has no positive interval; simulate first")]
    BadGrid,
}
