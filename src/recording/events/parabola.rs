//! Parabolas of the motion between impacts: how a mass under a steady force moves, and how any
//! motion does for some samples.
//!
//! The samples next to an impact may show it smoothed (exposure of a camera, a filter, a soft
//! ground). A side therefore begins at the nearest sample from which on it is a parabola to within
//! the noise, and reaches as far as it is one.

use std::ops::RangeInclusive;

use nalgebra::{Matrix3, Vector3};

use crate::recording::grid::TimeAxis;

/// Most samples next to an impact that a side leaves out.
const MAX_SKIPPED: usize = 2;
/// Most samples of a side.
const MAX_SAMPLES: usize = 64;
/// Distance of the samples from their parabola up to which the motion is one [standard deviations of
/// the noise], as a root mean square.
const MAX_MISFIT_SIGMAS: f64 = 2.0;

/// A parabola in time from an origin, by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parabola {
    /// Coefficients, constant first, of time over `unit`.
    coefficients: Vector3<f64>,
    /// Their covariance for a noise of 1.
    covariance: Matrix3<f64>,
    unit: f64,
    noise: f64,
}

impl Parabola {
    /// Fewest samples of a side: twice as many as it has coefficients.
    pub(super) const MIN_SAMPLES: usize = 6;

    /// Height at `t` \[m\].
    pub(super) fn value(&self, t: f64) -> f64 {
        self.at(t).dot(&self.coefficients)
    }

    /// Velocity at `t` [m/s].
    pub(super) fn slope(&self, t: f64) -> f64 {
        self.slope_at(t).dot(&self.coefficients)
    }

    /// Standard deviation of the velocity at `t` from the noise [m/s].
    pub(super) fn slope_error(&self, t: f64) -> f64 {
        let own = self.slope_at(t);
        self.noise * own.dot(&(self.covariance * own)).max(0.0).sqrt()
    }

    fn at(&self, t: f64) -> Vector3<f64> {
        let s = t / self.unit;
        Vector3::new(1.0, s, s * s)
    }

    fn slope_at(&self, t: f64) -> Vector3<f64> {
        Vector3::new(0.0, 1.0, 2.0 * t / self.unit) / self.unit
    }

    /// Through `points` (time from the origin, height), with their root mean square distance from it.
    fn fit(points: &[(f64, f64)], noise: f64) -> Option<(Self, f64)> {
        let unit = points.iter().fold(0.0, |m: f64, p| m.max(p.0.abs()));
        if points.len() <= 3 || unit <= 0.0 {
            return None;
        }
        let base = |t: f64| Vector3::new(1.0, t / unit, (t / unit).powi(2));
        let (mut products, mut moments) = (Matrix3::zeros(), Vector3::zeros());
        for &(t, x) in points {
            let own = base(t);
            products += own * own.transpose();
            moments += own * x;
        }
        let covariance = products.try_inverse()?;
        let coefficients = covariance * moments;
        let misses = points
            .iter()
            .map(|&(t, x)| (base(t).dot(&coefficients) - x).powi(2));
        let misfit = (misses.sum::<f64>() / (points.len() - 3) as f64).sqrt();
        let found = Self {
            coefficients,
            covariance,
            unit,
            noise,
        };
        misfit.is_finite().then_some((found, misfit))
    }

    /// The parabola of the samples at `indices`, which go away from an impact: it begins at the nearest
    /// of them from which on the motion is one, and is as long as that.
    fn side(
        time: TimeAxis,
        xp: &[f64],
        origin: f64,
        noise: f64,
        indices: impl Iterator<Item = usize>,
    ) -> Option<Self> {
        let points: Vec<(f64, f64)> = indices
            .take(MAX_SAMPLES + MAX_SKIPPED)
            .map(|i| (time.at(i) - origin, xp[i]))
            // A gap ends the side.
            .take_while(|(t, x)| t.is_finite() && x.is_finite())
            .collect();
        let is_parabola = |points: &[(f64, f64)]| {
            let found = Self::fit(points, noise);
            found.filter(|(_, misfit)| *misfit <= MAX_MISFIT_SIGMAS * noise)
        };
        (0..=MAX_SKIPPED).find_map(|skipped| {
            let own = points.get(skipped..)?;
            let longer = (Self::MIN_SAMPLES..=own.len()).map(|n| is_parabola(&own[..n]));
            let all = longer.map_while(|found| found);
            all.last().map(|(found, _)| found)
        })
    }
}

/// Where two parabolas meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    /// Time from the origin of both \[s\].
    pub(super) at: f64,
    /// The motion before.
    pub(super) before: Parabola,
    /// The motion after.
    pub(super) after: Parabola,
}

/// Where two parabolas of samples in `range`, which hold no other turn, meet near sample `i`, whose
/// time is their origin; the noise \[m\] and the time between samples \[s\] are given. `None` if the
/// motion is no parabola on one of the sides, or if they meet elsewhere.
pub(super) fn turn_between(
    time: TimeAxis,
    xp: &[f64],
    (noise, interval): (f64, f64),
    i: usize,
    range: RangeInclusive<usize>,
) -> Option<Meeting> {
    let (first, last) = (*range.start(), (*range.end()).min(xp.len().checked_sub(1)?));
    let origin = time.at(i);
    // The sample in the middle belongs to neither side: it may be in the midst of the impact.
    let before = Parabola::side(time, xp, origin, noise, (first..i).rev())?;
    let after = Parabola::side(time, xp, origin, noise, i + 1..last + 1)?;
    let mut at = 0.0;
    // Newton's steps on the distance of the two, which is nearly a line here.
    for _ in 0..5 {
        let distance = before.value(at) - after.value(at);
        let next = at + distance / (after.slope(at) - before.slope(at));
        if !next.is_finite() {
            return None;
        }
        at = next.clamp(-2.0 * interval, 2.0 * interval);
    }
    (at.abs() <= 1.5 * interval).then_some(Meeting { at, before, after })
}

#[cfg(test)]
mod tests {
    use super::super::parabola::*;

    #[test]
    fn a_parabola_is_followed_as_far_as_it_goes() {
        let time: Vec<f64> = (0..40).map(|i| 5e-3 * f64::from(i)).collect();
        // It falls until 0.1 s; what follows is another motion.
        let fall = |t: f64| 0.2 - 1.5 * t - 4.9 * t * t;
        let xp: Vec<f64> = time
            .iter()
            .map(|&t| if t < 0.1 { fall(t) } else { 0.3 * t })
            .collect();
        let axis = TimeAxis::Samples(&time);
        let side = Parabola::side(axis, &xp, 0.0, 1e-6, 0..40).unwrap();
        assert!((side.slope(0.05) + 1.5 + 0.49).abs() < 1e-9, "{side:?}");
        assert!((side.value(0.1) - fall(0.1)).abs() < 1e-9, "{side:?}");
        // From twenty samples, its slope in the middle is known far better than from two.
        assert!(side.slope_error(0.05) < 0.05 * 1e-6 / 5e-3, "{side:?}");
        assert!(Parabola::side(axis, &xp, 0.0, 1e-6, 16..20).is_none());
    }
}
