//! The paper's identification (section 4), step by step. Each step is a function from
//! recordings to numbers with their uncertainty and the points of its figure.

pub mod adhesion;
mod break_off;
pub mod drive;
pub mod film;
pub mod guide;
pub mod restitution;
pub mod sensitivity;

use thiserror::Error;

use crate::fit::FitError;

/// Why a step cannot be taken with a recording.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StepError {
    /// The fit within a step does not begin, or has no result.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The device lacks what the step is about.
    #[error("the device {device} has no {what}: {step} cannot be identified")]
    Device {
        /// Name of the device.
        device: String,
        /// What it lacks.
        what: &'static str,
        /// The step.
        step: &'static str,
    },
    /// A channel is missing.
    #[error(
        "{recording} has no {channel}: {step} needs it; record it, or name its column on import"
    )]
    Channel {
        /// Name of the recording.
        recording: String,
        /// Symbol of the channel.
        channel: &'static str,
        /// The step.
        step: &'static str,
    },
    /// The recording does not show what the step needs.
    #[error("{recording}: {reason}; {remedy}")]
    Unsuited {
        /// Name of the recording.
        recording: String,
        /// What it lacks.
        reason: String,
        /// What to record instead.
        remedy: &'static str,
    },
}

/// A number with what it counts, singular or plural.
fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// A straight line through weighted points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Value at zero, and its standard error.
    pub intercept: f64,
    /// See [`Self::intercept`].
    pub intercept_error: f64,
    /// Change per unit, and its standard error.
    pub slope: f64,
    /// See [`Self::slope`].
    pub slope_error: f64,
    /// Weighted mean of the abscissas, where the line is known best.
    pub center: f64,
    center_error: f64,
}

impl Line {
    /// Value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }

    /// Standard error of the value at `x`.
    pub fn error_at(&self, x: f64) -> f64 {
        self.center_error
            .hypot(self.slope_error * (x - self.center))
    }
}

/// The line through points `[x, y, weight]`, weights being one over the variance of `y`;
/// `None` if all have one abscissa.
fn line(points: &[[f64; 3]]) -> Option<Line> {
    let sum = |f: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(f).sum::<f64>();
    let weight = sum(&|p| p[2]);
    let center = sum(&|p| p[2] * p[0]) / weight;
    let mean = sum(&|p| p[2] * p[1]) / weight;
    let spread = sum(&|p| p[2] * (p[0] - center).powi(2));
    if !(spread > 0.0 && spread.is_finite()) {
        return None;
    }
    let slope = sum(&|p| p[2] * (p[0] - center) * (p[1] - mean)) / spread;
    let line = Line {
        intercept: mean - slope * center,
        intercept_error: (1.0 / weight + center * center / spread).sqrt(),
        slope,
        slope_error: spread.recip().sqrt(),
        center,
        center_error: weight.recip().sqrt(),
    };
    line.slope.is_finite().then_some(line)
}

#[cfg(test)]
mod tests;
