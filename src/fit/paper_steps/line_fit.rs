//! A straight line through points with individual standard errors.

use crate::fit::thresholds::LINE_HUBER_THRESHOLD;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Mean of `min(z^2, LINE_HUBER_THRESHOLD^2)` for a standard normal `z`.
const HUBER_SECOND_MOMENT: f64 = 0.778_5;
/// Rounds of reweighting at most.
const MAX_REWEIGHT_ROUNDS: usize = 50;
/// Halvings in the search for the scatter.
const SCATTER_HALVINGS: usize = 60;
/// Variances below this share of the ordinates' square are rounding.
const MIN_VARIANCE_SHARE: f64 = 1e-16;

/// A straight line through weighted points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
    /// Scatter of the points about the line beyond their own errors.
    pub scatter: f64,
    center_error: f64,
    points: usize,
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

    /// Half the width of the 95 % confidence band at `x`, by Student's t of the points less
    /// the two numbers fitted.
    pub fn band_at(&self, x: f64) -> f64 {
        let freedom = self.points.saturating_sub(2).max(1) as f64;
        let factor = StudentsT::new(0.0, 1.0, freedom).map_or(1.96, |t| t.inverse_cdf(0.975));
        factor * self.error_at(x)
    }
}

/// The line through points `[x, y, weight]`, weights being one over the variance of `y`;
/// `None` if all have one abscissa.
pub(crate) fn line(points: &[[f64; 3]]) -> Option<Line> {
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
        scatter: 0.0,
        center_error: weight.recip().sqrt(),
        points: points.len(),
    };
    line.slope.is_finite().then_some(line)
}

/// The line through points `[x, y, standard error of y]` by Huber's estimate: an outlier has a
/// bounded influence. A common scatter beyond the stated errors is estimated so that the residuals
/// have their expected size (Huber's proposal 2, which without a bound is the estimate of Paule and
/// Mandel, J. Res. NBS 87 (1982) 377).
pub(crate) fn robust_line(points: &[[f64; 3]]) -> Option<Line> {
    let largest = points.iter().fold(0.0f64, |a, p| a.max(p[1].abs()));
    let least = (MIN_VARIANCE_SHARE * largest * largest).max(f64::MIN_POSITIVE);
    let at = |scatter: f64| -> Option<(Line, f64)> {
        let variance = |p: &[f64; 3]| (p[2] * p[2] + scatter * scatter).max(least);
        let mut factors = vec![1.0; points.len()];
        let mut found: Option<Line> = None;
        for _ in 0..MAX_REWEIGHT_ROUNDS {
            let weighted: Vec<[f64; 3]> = points
                .iter()
                .zip(&factors)
                .map(|(p, factor)| [p[0], p[1], factor / variance(p)])
                .collect();
            let next = line(&weighted)?;
            let settled = found.is_some_and(|old| {
                let moved = |x: f64| (next.at(x) - old.at(x)).abs() < 1e-4 * next.error_at(x);
                points.iter().all(|p| moved(p[0]))
            });
            found = Some(next);
            if settled {
                break;
            }
            for (factor, p) in factors.iter_mut().zip(points) {
                let away = (p[1] - next.at(p[0])).abs() / variance(p).sqrt();
                *factor = (LINE_HUBER_THRESHOLD / away.max(1e-300)).min(1.0);
            }
        }
        let found = found?;
        let size = |p: &[f64; 3]| {
            let away2 = (p[1] - found.at(p[0])).powi(2) / variance(p);
            away2.min(LINE_HUBER_THRESHOLD * LINE_HUBER_THRESHOLD)
        };
        Some((found, points.iter().map(size).sum()))
    };
    let expected = HUBER_SECOND_MOMENT * points.len().saturating_sub(2) as f64;
    let (plain, size) = at(0.0)?;
    if size <= expected {
        return Some(plain);
    }
    let (mut low, mut high) = (0.0, largest);
    for _ in 0..SCATTER_HALVINGS {
        let middle = 0.5 * (low + high);
        if at(middle)?.1 > expected {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (line, _) = at(high)?;
    Some(Line {
        scatter: high,
        ..line
    })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::super::line_fit::*;
    use crate::model::sensor::gaussian;

    /// Errors from 0.1 to 3, a scatter of their own of 0.5, and one in ten far off to one
    /// side, which drags the ends a little: the stated errors must still hold.
    #[test]
    fn stated_errors_hold_with_uneven_errors_and_some_points_far_off() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (mut slope, mut inside, mut wild) = (0.0, 0, 0.0f64);
        let runs = 400;
        for _ in 0..runs {
            let points: Vec<[f64; 3]> = (0..20)
                .map(|i| {
                    let x = f64::from(i);
                    let error: f64 = if i % 4 == 0 { 3.0 } else { 0.1 };
                    let far = if i == 11 || i == 13 { -8.0 } else { 0.0 };
                    let y = 5.0 + 2.0 * x + error.hypot(0.5) * gaussian(&mut rng) + far;
                    [x, y, error]
                })
                .collect();
            let found = robust_line(&points).unwrap();
            let off = found.slope - 2.0;
            slope += off / f64::from(runs);
            wild = wild.max(off.abs());
            inside += i32::from(off.abs() < 2.0 * found.slope_error);
        }
        println!("{slope} {inside} {wild}");
        assert!(slope.abs() < 0.02, "{slope}");
        assert!(inside > 360, "{inside} of {runs}");
        assert!(wild < 0.3, "{wild}");
    }

    #[test]
    fn an_imprecise_point_does_not_widen_the_rest() {
        let mut points: Vec<[f64; 3]> = (1..9)
            .map(|i| [f64::from(i), 3.0 * f64::from(i) + 1.0, 0.01])
            .collect();
        points.push([0.5, 7.0, 5.0]);
        let found = robust_line(&points).unwrap();
        assert_eq!(found.scatter, 0.0);
        assert!((found.slope - 3.0).abs() < 1e-3, "{found:?}");
        assert!(found.slope_error < 2e-3);
        // The band is wider than the standard errors by Student's t.
        let ratio = found.band_at(4.0) / found.error_at(4.0);
        assert!((ratio - 2.365).abs() < 0.01, "{ratio}");
        assert!(robust_line(&[[1.0, 2.0, 0.1]; 3]).is_none());
    }
}
