//! Sinusoids as curves.

use std::f64::consts::TAU;

use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{LIKELY_REACHES, MAX_SEARCH_SAMPLES};

/// `amplitude sin(2 pi (phase + from t + rate t^2 / 2))`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoid {
    /// \[V\]
    pub amplitude: f64,
    /// Phase at t = 0 in turns.
    pub phase: f64,
    /// Frequency at t = 0 \[Hz\].
    pub from: f64,
    /// Its change [Hz/s].
    pub rate: f64,
    /// Standard deviation of the instants of equal phase \[s\].
    pub time_sigma: f64,
}

impl Sinusoid {
    /// Turns since phase zero at `t` \[s\].
    pub fn turns(&self, t: f64) -> f64 {
        self.phase + t * (self.from + 0.5 * self.rate * t)
    }

    /// Voltage \[V\] at `t` \[s\].
    pub fn voltage(&self, t: f64) -> f64 {
        // Whole turns are taken away first: the sine of a large number is slow.
        let turns = self.turns(t);
        self.amplitude * (TAU * (turns - turns.floor())).sin()
    }

    /// Slope [V/s] at `t` \[s\].
    pub fn slope(&self, t: f64) -> f64 {
        let frequency = self.from + self.rate * t;
        self.amplitude * TAU * frequency * (TAU * self.turns(t)).cos()
    }
}

/// Sinusoids on an offset.
#[derive(Debug, Clone, PartialEq)]
pub struct Sinusoids {
    /// \[V\]
    pub offset: f64,
    /// Largest first.
    pub parts: Vec<Sinusoid>,
}

impl Sinusoids {
    /// Voltage \[V\] at `t` \[s\].
    pub fn voltage(&self, t: f64) -> f64 {
        self.offset + self.parts.iter().map(|s| s.voltage(t)).sum::<f64>()
    }

    /// Slope [V/s] at `t` \[s\].
    pub fn slope(&self, t: f64) -> f64 {
        self.parts.iter().map(|s| s.slope(t)).sum()
    }
}

/// Whether few samples do not deny a curve; the test of all decides after a fit to all.
pub fn is_likely(samples: &Samples<'_>, curve: impl Fn(f64) -> f64) -> bool {
    let reach = LIKELY_REACHES * samples.reach();
    let near = |i: usize| (samples.volts[i] - curve(samples.time[i])).abs() <= reach;
    samples.thinned(MAX_SEARCH_SAMPLES).all(near)
}

/// The zero that rises nearest to t = 0 \[s\].
pub fn begin(part: &Sinusoid) -> f64 {
    let phase = part.phase - part.phase.round();
    let sign = part.amplitude.signum();
    let phase = if sign < 0.0 { phase - 0.5 } else { phase };
    -phase / part.from
}
