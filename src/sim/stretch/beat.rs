//! Readings that come at even intervals.

use crate::sim::device::Device;
use crate::sim::linear::Oscillator;

/// The interval at which readings come, and what modes do over it.
pub(super) struct Beat {
    interval: f64,
    flight: Vec<[f64; 4]>,
    held: Vec<[f64; 4]>,
}

impl Beat {
    /// Share of the interval that is rounding.
    const EVEN: f64 = 1e-9;

    /// Of readings at the increasing `times` \[s\].
    pub fn new(device: &Device, times: &[f64]) -> Self {
        let interval = match times {
            [first, second, ..] => second - first,
            _ => f64::INFINITY,
        };
        let over = |modes: &[Oscillator]| -> Vec<[f64; 4]> {
            let even = if interval.is_finite() { modes } else { &[] };
            even.iter().map(|mode| mode.free_motion(interval)).collect()
        };
        Self {
            interval,
            flight: over(&device.flight),
            held: over(&device.held_modes),
        }
    }

    /// Free motion of each mode over the interval, the mass held or in flight.
    pub fn motions(&self, held: bool) -> &[[f64; 4]] {
        if held { &self.held } else { &self.flight }
    }

    /// Whether readings so far apart are one interval apart.
    pub fn is_one(&self, apart: f64) -> bool {
        (apart - self.interval).abs() < Self::EVEN * self.interval
    }
}
