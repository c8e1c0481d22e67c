//! A sine or a sweep with an offset, and sums of sines.

mod curve;
mod single;
mod sum;

pub use self::curve::{Sinusoids, begin};
use self::single::find_single;
use self::sum::find_sum;
use super::samples::Samples;

/// The sinusoids that the samples follow; `None` if they are none.
pub fn find_sinusoids(samples: &Samples<'_>) -> Option<Sinusoids> {
    find_single(samples).or_else(|| find_sum(samples))
}
