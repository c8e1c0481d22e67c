//! Drift of an integral: what a person has taken out of it, and how much that was.
//!
//! An integral adds up every error of its integrand: an offset of 1 um/s is 1 um after a second. What is
//! drift and what is motion only the person knows, so that nothing is taken out without a word.

use serde::{Deserialize, Serialize};

use crate::model::unit::format_quantity;

/// Periods of the corner in a recording, where the corner is not given: fewer are a part of the motion.
const CORNER_PERIODS: f64 = 4.0;
/// Length of what is added at both ends before the filter, in its time constants: what it then still
/// remembers of its own beginning is below 1 %.
const END_TIME_CONSTANTS: f64 = 5.0;

/// What is taken out of a displacement that was integrated.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriftRemoval {
    /// Nothing.
    #[default]
    None,
    /// The mean of the velocity: the displacement ends where it begins.
    Mean,
    /// The line of least squares through the displacement.
    Line,
    /// What is slower than a corner frequency, by a filter without phase that halves a sine at the corner.
    HighPass {
        /// The corner \[Hz\]; `None` puts four of its periods into the recording.
        corner: Option<f64>,
    },
}

impl DriftRemoval {
    /// All ways, for a chooser.
    pub const ALL: [DriftRemoval; 4] = [
        DriftRemoval::None,
        DriftRemoval::Mean,
        DriftRemoval::Line,
        DriftRemoval::HighPass { corner: None },
    ];

    /// The name on the command line.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            DriftRemoval::None => "none",
            DriftRemoval::Mean => "mean",
            DriftRemoval::Line => "line",
            DriftRemoval::HighPass { .. } => "high-pass",
        }
    }

    /// A sentence for a chooser.
    #[must_use]
    pub fn help(self) -> &'static str {
        match self {
            DriftRemoval::None => "The integral as it is",
            DriftRemoval::Mean => {
                "The mean of the readings is taken out first; the integral ends where it begins"
            }
            DriftRemoval::Line => "The line of least squares is taken out of the integral",
            DriftRemoval::HighPass { .. } => {
                "What is slower than the corner is taken out of the integral"
            }
        }
    }

    /// Whether nothing is taken out.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == DriftRemoval::None
    }

    /// The corner for a recording of this duration \[s\]; `None` where no filter is meant.
    #[must_use]
    pub fn corner_in(self, duration: f64) -> Option<f64> {
        match self {
            DriftRemoval::HighPass { corner } => Some(corner.unwrap_or(CORNER_PERIODS / duration)),
            _ => None,
        }
    }
}

/// Takes the drift out of `values`, an integral over `time` \[s\] that begins at 0, in `unit`; says what
/// that was.
pub fn remove_drift(drift: DriftRemoval, time: &[f64], values: &mut [f64], unit: &str) -> String {
    let seen = || {
        time.iter()
            .zip(values.iter())
            .filter(|(_, x)| x.is_finite())
    };
    let (Some((start, first)), Some((end, last))) = (seen().next(), seen().next_back()) else {
        return "no drift is taken out".to_owned();
    };
    let (start, span, net) = (*start, end - start, last - first);
    let take_line = |rate: f64, values: &mut [f64]| {
        let line = values.iter_mut().zip(time);
        line.for_each(|(x, t)| *x -= rate * (t - start));
    };
    let per_second = format!("{unit}/s");
    match drift {
        DriftRemoval::None => "no drift is taken out".to_owned(),
        DriftRemoval::Mean => {
            let rate = if span > 0.0 { net / span } else { 0.0 };
            take_line(rate, values);
            format!(
                "the mean rate of {} is taken out, {} over the recording",
                format_quantity(rate, &per_second, 3),
                format_quantity(rate * span, unit, 3)
            )
        }
        DriftRemoval::Line => {
            let rate = slope(time, values);
            take_line(rate, values);
            format!(
                "a drift of {} (the line of least squares) is taken out, {} over the recording",
                format_quantity(rate, &per_second, 3),
                format_quantity(rate * span, unit, 3)
            )
        }
        DriftRemoval::HighPass { .. } => {
            let corner = drift.corner_in(span).unwrap_or(f64::NAN);
            // A line is slow whatever the corner; without it the filter's beginning leaves less behind.
            let rate = slope(time, values);
            let line = |t: &f64| rate * (t - start);
            let bent: Vec<f64> = values.iter().zip(time).map(|(x, t)| x - line(t)).collect();
            let mut slow = low_pass(time, &bent, 1.0 / (std::f64::consts::TAU * corner));
            slow.iter_mut().zip(time).for_each(|(s, t)| *s += line(t));
            values.iter_mut().zip(&slow).for_each(|(x, s)| *x -= s);
            let (low, high) = crate::recording::extremes(&slow);
            let squares = slow.iter().filter(|s| s.is_finite()).map(|s| s * s);
            let (sum, count) = squares.fold((0.0, 0usize), |(sum, n), s| (sum + s, n + 1));
            format!(
                "what is slower than {} is taken out (half of it at the corner, without phase): {} rms, from {} to {}",
                format_quantity(corner, "Hz", 4),
                format_quantity((sum / count.max(1) as f64).sqrt(), unit, 3),
                format_quantity(low, unit, 3),
                format_quantity(high, unit, 3)
            )
        }
    }
}

/// Slope of the line of least squares through the finite values.
fn slope(time: &[f64], values: &[f64]) -> f64 {
    let seen = || time.iter().zip(values).filter(|(_, x)| x.is_finite());
    let count = seen().count().max(1) as f64;
    let (t_mean, x_mean) = (
        seen().map(|(t, _)| t).sum::<f64>() / count,
        seen().map(|(_, x)| x).sum::<f64>() / count,
    );
    let (mut tt, mut tx) = (0.0, 0.0);
    for (t, x) in seen() {
        tt += (t - t_mean).powi(2);
        tx += (t - t_mean) * (x - x_mean);
    }
    if tt > 0.0 { tx / tt } else { 0.0 }
}

/// A first-order lag of `tau` \[s\] forward and then backward, exact for readings that are straight between
/// their instants. Both ends go on as their mirror image through the end point, so that a line stays a
/// line. NaN where `values` is.
fn low_pass(time: &[f64], values: &[f64], tau: f64) -> Vec<f64> {
    let seen: Vec<(f64, f64)> = time
        .iter()
        .zip(values)
        .filter(|(_, x)| x.is_finite())
        .map(|(t, x)| (*t, *x))
        .collect();
    let (Some(first), Some(last)) = (seen.first().copied(), seen.last().copied()) else {
        return values.to_vec();
    };
    let reach = END_TIME_CONSTANTS * tau;
    let mirrored =
        |(t, x): (f64, f64), (t_end, x_end): (f64, f64)| (2.0 * t_end - t, 2.0 * x_end - x);
    let before = seen
        .iter()
        .skip(1)
        .take_while(|(t, _)| t - first.0 <= reach);
    let after = seen
        .iter()
        .rev()
        .skip(1)
        .take_while(|(t, _)| last.0 - t <= reach);
    let mut all: Vec<(f64, f64)> = before.map(|p| mirrored(*p, first)).collect();
    let begin = all.len();
    all.reverse();
    all.extend_from_slice(&seen);
    all.extend(after.map(|p| mirrored(*p, last)));
    let forward = lag(all.iter().copied(), tau);
    let backward = all.iter().zip(&forward).rev().map(|((t, _), y)| (-t, *y));
    let mut smooth = lag(backward, tau);
    smooth.reverse();
    let mut own = smooth.into_iter().skip(begin);
    let one = |x: &f64| {
        if x.is_finite() {
            own.next().unwrap_or(f64::NAN)
        } else {
            f64::NAN
        }
    };
    values.iter().map(one).collect()
}

/// `tau y' = x - y` from rest at the first point, x straight between points.
fn lag(points: impl Iterator<Item = (f64, f64)>, tau: f64) -> Vec<f64> {
    let mut before: Option<(f64, f64, f64)> = None;
    let one = |(t, x): (f64, f64)| {
        let y = match before {
            None => x,
            Some((t_before, x_before, y_before)) => {
                let h = (t - t_before) / tau;
                // 1 - e^-h, which is small for most samples.
                let gone = -(-h).exp_m1();
                let ramp = if h > 0.0 { 1.0 - gone / h } else { 0.0 };
                y_before + gone * (x_before - y_before) + (x - x_before) * ramp
            }
        };
        before = Some((t, x, y));
        y
    };
    points.map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::super::drift::*;

    fn times(rows: usize) -> Vec<f64> {
        (0..rows)
            .map(|i| i as f64 * 1e-3 + 2e-4 * (i as f64).sin())
            .collect()
    }

    #[test]
    fn lines_are_taken_out_exactly() {
        let time = times(2000);
        let line: Vec<f64> = time.iter().map(|t| 3.0 * (t - time[0])).collect();
        for drift in DriftRemoval::ALL.into_iter().skip(1) {
            let mut values = line.clone();
            values[700] = f64::NAN;
            let said = remove_drift(drift, &time, &mut values, "m");
            for (i, x) in values.iter().enumerate().filter(|(i, _)| *i != 700) {
                assert!(x.abs() < 1e-9, "{drift:?} {i}: {x}");
            }
            assert!(values[700].is_nan());
            assert!(
                said.contains("taken out") && !said.contains("no drift"),
                "{said}"
            );
        }
        let mut values = line.clone();
        let said = remove_drift(DriftRemoval::Line, &time, &mut values, "m");
        assert!(said.contains("3 m/s") && said.contains("6 m"), "{said}");
        let mut values = line.clone();
        assert_eq!(
            remove_drift(DriftRemoval::None, &time, &mut values, "m"),
            "no drift is taken out"
        );
        assert_eq!(values, line);
    }

    #[test]
    fn a_high_pass_halves_a_sine_at_its_corner() {
        let time = times(20_000);
        let corner = 2.0;
        for (frequency, gain) in [(2.0, 0.5), (20.0, 1.0 / 1.01), (0.2, 0.01 / 1.01)] {
            let wave = |t: f64| (std::f64::consts::TAU * frequency * t).sin();
            let mut values: Vec<f64> = time.iter().map(|t| wave(*t)).collect();
            let drift = DriftRemoval::HighPass {
                corner: Some(corner),
            };
            remove_drift(drift, &time, &mut values, "m");
            // No phase: away from the ends it is the same sine, smaller.
            for (t, x) in time.iter().zip(&values).skip(4000).take(12_000) {
                assert!(
                    (x - gain * wave(*t)).abs() < 5e-3,
                    "{frequency} Hz at {t}: {x}"
                );
            }
        }
        assert_eq!(
            DriftRemoval::HighPass { corner: None }.corner_in(2.0),
            Some(2.0)
        );
    }
}
