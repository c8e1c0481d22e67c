//! Sampled signals by their instants: listed, or on an even grid.

use super::statistics::median_interval;

/// The instants of a sampled signal: even, or listed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeAxis<'a> {
    /// Sample `i` is at `t0 + i dt` \[s\].
    Uniform {
        /// Time of the first sample \[s\].
        t0: f64,
        /// Sample interval \[s\], positive.
        dt: f64,
    },
    /// The time of each sample \[s\], strictly increasing.
    Samples(&'a [f64]),
}

impl TimeAxis<'_> {
    /// Time of sample `i` \[s\]; NaN past the end of a listed axis.
    #[must_use]
    pub fn at(&self, i: usize) -> f64 {
        match self {
            TimeAxis::Uniform { t0, dt } => t0 + i as f64 * dt,
            TimeAxis::Samples(times) => times.get(i).copied().unwrap_or(f64::NAN),
        }
    }

    /// Whether the axis can name `n` samples.
    #[must_use]
    pub fn covers(&self, n: usize) -> bool {
        match self {
            TimeAxis::Uniform { t0, dt } => t0.is_finite() && dt.is_finite() && *dt > 0.0,
            TimeAxis::Samples(times) => times.len() >= n,
        }
    }

    /// Median sample interval of the first `n` samples \[s\]; NaN below two samples.
    #[must_use]
    pub fn interval(&self, n: usize) -> f64 {
        match self {
            TimeAxis::Uniform { dt, .. } => *dt,
            TimeAxis::Samples(times) => median_interval(&times[..n.min(times.len())]),
        }
    }
}

/// A simulated (or any) signal on an even grid: `values[i]` at `t0 + i dt`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid<'a> {
    /// Time of the first value \[s\].
    pub t0: f64,
    /// Interval \[s\], positive.
    pub dt: f64,
    /// The values, in the SI unit of their channel.
    pub values: &'a [f64],
    /// Their rates of change per second, if known: then a cubic runs between values,
    /// where straight lines would cut the crests of a fast ring.
    pub slopes: Option<&'a [f64]>,
}

impl Grid<'_> {
    /// Value at time `t` \[s\] by straight lines, or by cubics where the slopes are
    /// known; `None` outside the grid or next to
    /// a value that is not a number.
    #[must_use]
    pub fn value_at(&self, t: f64) -> Option<f64> {
        let position = (t - self.t0) / self.dt;
        let last = self.values.len().checked_sub(1)?;
        // A hair of tolerance: t0 + n dt is rarely exact in binary.
        if position.is_nan() || position < -1e-6 || position > last as f64 + 1e-6 {
            return None;
        }
        let position = position.clamp(0.0, last as f64);
        let i = (position.floor() as usize).min(last.saturating_sub(1));
        let w = position - i as f64;
        let a = self.values[i];
        let b = self.values[(i + 1).min(last)];
        // A weight of zero must not let a missing neighbour in.
        let value = if w == 0.0 {
            a
        } else if w == 1.0 {
            b
        } else if let Some((da, db)) = self.slopes_at(i) {
            let (u, v) = (1.0 - w, w);
            let (da, db) = (da * self.dt, db * self.dt);
            u * u * ((1.0 + 2.0 * v) * a + v * da) + v * v * ((1.0 + 2.0 * u) * b - u * db)
        } else {
            a + (b - a) * w
        };
        value.is_finite().then_some(value)
    }

    /// Slopes at value `i` and the next, if known.
    fn slopes_at(&self, i: usize) -> Option<(f64, f64)> {
        let slopes = self.slopes?;
        Some((*slopes.get(i)?, *slopes.get(i + 1)?))
    }

    /// Time of the last value \[s\]; `t0` for an empty grid.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.t0 + self.values.len().saturating_sub(1) as f64 * self.dt
    }
}
