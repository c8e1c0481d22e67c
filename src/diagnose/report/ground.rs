//! The events at the ground as the report and the window draw them: measured points that
//! tell something, and the laws that they should follow.

use crate::model::Model;
use crate::model::effects::{Action, ActiveEffect, Surroundings};
use crate::model::ground::Ground;

/// Points of a law's curve.
const CURVE: usize = 80;
/// Errors above this many times the usual one are large.
const LARGE: f64 = 8.0;

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

/// Measured points without those that tell next to nothing, and how many these are:
/// their errors would shrink all others to a line.
pub fn told(points: impl Iterator<Item = Seen>) -> (Vec<Seen>, usize) {
    let all: Vec<Seen> = points.collect();
    let mut errors: Vec<f64> = all.iter().map(|d| d.error).collect();
    errors.retain(|e| e.is_finite());
    errors.sort_by(f64::total_cmp);
    let most = errors
        .get(errors.len() / 2)
        .map_or(f64::INFINITY, |median| LARGE * median);
    let keep = |d: &Seen| d.y.is_finite() && (d.error.is_nan() || d.error <= most);
    let kept: Vec<Seen> = all.iter().copied().filter(keep).collect();
    let left = all.len() - kept.len();
    (kept, left)
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
    let step = (high - low) / (CURVE - 1) as f64;
    (0..CURVE).map(|i| low + i as f64 * step).collect()
}
