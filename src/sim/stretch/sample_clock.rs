//! The clock of evenly spaced readings: free motion over its interval is computed once.

use crate::sim::device::Device;
use crate::sim::output::FastModes;

/// The interval between readings, and the free motion of the modes over it.
pub(super) struct SampleClock {
    interval: f64,
    flight: Vec<[f64; 4]>,
    held: Vec<[f64; 4]>,
}

impl SampleClock {
    /// Intervals that differ by less than this share are equal.
    const ROUNDING: f64 = 1e-9;

    /// Of readings at the increasing `times` \[s\].
    pub fn new(device: &Device, times: &[f64]) -> Self {
        let interval = match times {
            [first, second, ..] => second - first,
            // Nothing is an interval apart.
            _ => f64::NAN,
        };
        Self {
            interval,
            flight: FastModes::sampling(&device.flight, interval),
            held: FastModes::sampling(&device.held_modes, interval),
        }
    }

    /// Free motion of each mode over the interval, the mass held or in flight.
    pub fn motions(&self, held: bool) -> &[[f64; 4]] {
        if held { &self.held } else { &self.flight }
    }

    /// Whether readings so far apart are one interval apart.
    pub fn is_one(&self, apart: f64) -> bool {
        (apart - self.interval).abs() < Self::ROUNDING * self.interval
    }
}
