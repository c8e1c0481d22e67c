//! Contact events and missing forces as the report and the window draw them: measured points
//! without those of large errors, and the laws that they should follow.

use crate::diagnose::diagnosis::ForceCurve;
use crate::model::Model;
use crate::model::effects::{Action, ActiveEffect, Surroundings};
use crate::model::ground::Ground;

/// Points of a law's curve.
const CURVE_POINTS: usize = 80;
/// Errors above this many times the median are large.
const LARGE_ERROR_RATIO: f64 = 8.0;

/// A measured point, SI; the error is NaN or infinite where it is not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Where it is drawn.
    pub x: f64,
    /// What was measured.
    pub y: f64,
    /// Its standard error.
    pub error: f64,
}

/// Measured points without those of large errors, and how many these are: drawn, they would shrink
/// all others to a line.
pub fn without_large_errors(points: impl Iterator<Item = Seen>) -> (Vec<Seen>, usize) {
    let all: Vec<Seen> = points.collect();
    let mut errors: Vec<f64> = all.iter().map(|d| d.error).collect();
    errors.retain(|e| e.is_finite());
    errors.sort_by(f64::total_cmp);
    let most = errors
        .get(errors.len() / 2)
        .map_or(f64::INFINITY, |median| LARGE_ERROR_RATIO * median);
    let small = |d: &Seen| d.y.is_finite() && (d.error.is_nan() || d.error <= most);
    let shown: Vec<Seen> = all.iter().copied().filter(small).collect();
    let hidden = all.len() - shown.len();
    (shown, hidden)
}

/// The laws of one model's ground, its effects included.
pub struct GroundLaws {
    ground: Ground,
    actions: Vec<Box<dyn Action>>,
}

impl GroundLaws {
    /// Of a model.
    pub fn of(model: &Model) -> Self {
        let structure = model.structure();
        let around = Surroundings {
            structure: &structure,
            parameters: &model.parameters,
            piezo: model.piezo,
        };
        let build = |e: &ActiveEffect| (e.spec.build)(&e.values, &around);
        Self {
            ground: Ground::new(&model.parameters),
            actions: model.effects.iter().map(build).collect(),
        }
    }

    /// Speed after over speed before a bounce with `speed` \[m/s\].
    pub fn restitution(&self, speed: f64) -> f64 {
        let all = self.actions.iter();
        all.fold(self.ground.alpha, |alpha, a| a.restitution(alpha, speed))
    }

    /// Pull-off force after `contact` \[s\] on the ground \[N\].
    pub fn adhesion(&self, contact: f64) -> f64 {
        let start = self.ground.adhesion_start;
        let line = self.ground.adhesion(contact);
        let all = self.actions.iter();
        all.fold(line, |f, a| a.adhesion(f, start, contact))
    }
}

/// Places from the least to the greatest of `values` at which a law is drawn; none if
/// they span nothing.
pub fn grid(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
    if low >= high {
        return Vec::new();
    }
    let step = (high - low) / (CURVE_POINTS - 1) as f64;
    (0..CURVE_POINTS).map(|i| low + i as f64 * step).collect()
}

/// The law through a measured force curve \[N\], with a constant and a slope added to it: the
/// measured force is known except for these, since the re-tuned model has an offset, a stiffness, a
/// damping and a gain of the drive of its own, which absorb them. Empty where there is no law.
pub fn law_through(curve: &ForceCurve) -> Vec<f64> {
    let middle = curve.at.iter().sum::<f64>() / curve.at.len().max(1) as f64;
    let mut sums = [0.0; 5];
    for (i, (u, law)) in curve.at.iter().zip(&curve.law).enumerate() {
        let (Some(force), Some(error)) = (curve.force.get(i), curve.std_error.get(i)) else {
            continue;
        };
        let (miss, weight) = (force - law, error.powi(-2));
        if miss.is_finite() && weight.is_finite() && weight > 0.0 {
            let u = u - middle;
            let terms = [1.0, u, u * u, miss, u * miss];
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += weight * term;
            }
        }
    }
    let [w, wu, wuu, wf, wuf] = sums;
    let determinant = w * wuu - wu * wu;
    let (constant, slope) = if determinant > 1e-9 * w * wuu {
        (
            (wuu * wf - wu * wuf) / determinant,
            (w * wuf - wu * wf) / determinant,
        )
    } else if w > 0.0 {
        (wf / w, 0.0)
    } else {
        (0.0, 0.0)
    };
    let through = curve.at.iter().zip(&curve.law);
    through
        .map(|(u, law)| law + constant + slope * (u - middle))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::ground::*;

    #[test]
    fn a_law_is_drawn_up_to_what_re_tuning_absorbs() {
        let at: Vec<f64> = (-5..=5).map(|i| 0.1 * f64::from(i)).collect();
        let law: Vec<f64> = at.iter().map(|v| -1e-8 * v * v.abs()).collect();
        let mut curve = ForceCurve {
            against: "xp'",
            unit: "m/s",
            force: at
                .iter()
                .zip(&law)
                .map(|(v, f)| f + 2e-9 + 3e-9 * v)
                .collect(),
            std_error: vec![1e-10; at.len()],
            law,
            at,
        };
        curve.std_error[3] = f64::NAN;
        for (drawn, seen) in law_through(&curve).iter().zip(&curve.force) {
            assert!((drawn - seen).abs() < 1e-15, "{drawn:e} {seen:e}");
        }
        curve.std_error.fill(f64::NAN);
        assert_eq!(law_through(&curve), curve.law);
        curve.law.clear();
        assert!(law_through(&curve).is_empty());
    }
}
