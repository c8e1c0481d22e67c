//! Step 5, sensitivity (Table 2): everything identified again as if the zero position were
//! 20 um higher above the ground, compared with the original.
//!
//! As in the paper, the drive's gain function is shifted by the same displacement: the recorded
//! motion is the same, only its zero is another. Without that shift no values of the parameters
//! would follow the recording to better than micrometres. The second identification goes on from
//! the first, moved to the new zero; it searches from the beginning only if it then fits worse.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use crate::fit::error::FitError;
use crate::fit::options::{FitOptions, Part};
use crate::fit::pipeline::{Fitted, fit, fit_from, fitted};
use crate::fit::problem::Nuisance;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::prepare::Prepared;
use crate::fit::solve::levenberg_marquardt::{Control, Progress};
use crate::fit::solve::point::{Point, settle};
use crate::fit::thresholds::{
    INSENSITIVE_CHANGE_SHARE, RESTART_MISFIT_RATIO, SENSITIVE_CHANGE_SIGMAS,
};
use crate::fit::uncertainty::fit_result::{FitResult, Misfit};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::SimError;

/// By how much `dp` is shifted \[m\].
pub const ZERO_SHIFT: f64 = 20e-6;
/// Loss while the moved point settles: hardly robust.
const START_LOSS: Huber = Huber(1e3);
/// Rounds in which each segment's own unknowns are found at first.
const START_SETTLE_ROUNDS: usize = 6;

/// The rows of Table 2.
pub const TABLE_2_ROWS: [ParameterId; 5] = [
    ParameterId::Alpha,
    ParameterId::Ca,
    ParameterId::Ca0,
    ParameterId::Cs,
    ParameterId::Gp,
];

/// Both identifications.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Sensitivity {
    /// With the model's `dp`.
    pub original: FitResult,
    /// With `dp` shifted; if cancelled, as far as it had come.
    pub altered: FitResult,
}

impl Sensitivity {
    /// Whether the fitted coefficients depend on the zero, in one sentence; `None` if the second
    /// identification does not fit as well as the first.
    #[must_use]
    pub fn verdict(&self) -> Option<String> {
        let (a, b) = (&self.original, &self.altered);
        if b.cancelled || b.train.0.rms > RESTART_MISFIT_RATIO * a.train.0.rms {
            return None;
        }
        if a.train.1.iter().any(Misfit::is_bad) {
            return Some("The device does not fit these recordings, so the comparison says nothing about the zero. Fit the whole device first.".to_owned());
        }
        let row = |id: &ParameterId| {
            let of = |fit: &FitResult| {
                let fitted = fit.parameters.iter().find(|p| p.id == id.spec().id);
                fitted.map(|p| (p.value, p.std_error))
            };
            Some((id.spec().id, of(a)?, of(b)?))
        };
        // The gap is counted from the zero and has to move.
        let others = TABLE_2_ROWS.iter().filter(|id| **id != ParameterId::Gp);
        let is_determined = |fitted: (f64, f64)| fitted.1.is_finite();
        let rows: Vec<_> = others
            .filter_map(row)
            .filter(|(_, a, b)| is_determined(*a) && is_determined(*b))
            .collect();
        if rows.is_empty() {
            return Some("None of the coefficients is determined by these recordings, so the comparison says nothing about the zero.".to_owned());
        }
        let moved: Vec<String> = rows
            .into_iter()
            .filter(|(_, a, b)| {
                let by = (a.0 - b.0).abs();
                let significant = by > SENSITIVE_CHANGE_SIGMAS * a.1.hypot(b.1);
                significant && by > INSENSITIVE_CHANGE_SHARE * a.0.abs().max(b.0.abs())
            })
            .map(|(id, a, b)| format!("{id} by {:+.1} %", 100.0 * (b.0 / a.0 - 1.0)))
            .collect();
        Some(if moved.is_empty() {
            "No coefficient changes by more than its error: they do not depend on the zero position.".to_owned()
        } else {
            format!("These change with the zero position: {}.", moved.join(", "))
        })
    }
}

/// Identifies twice. `dp` is kept fixed, the film is as thick at contact at the start, and
/// each reading's zero is free. Progress counts both together.
///
/// # Errors
/// [`FitError`] if the recordings do not allow it, or the first was cancelled.
pub fn sensitivity(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Sensitivity, FitError> {
    let mut options = options.clone();
    options.free.retain(|id| id != "dp");
    let most = AtomicUsize::new(0);
    let report = |p: &Progress| {
        most.fetch_max(p.expected, Ordering::Relaxed);
        (control.progress)(&Progress {
            stage: "1 of 2: dp as it is",
            expected: p.expected + options.iterations,
            ..p.clone()
        });
    };
    let first = Control {
        progress: &report,
        ..*control
    };
    let original = fitted(model, parts, &[], &options, &first)?;
    if original.result.cancelled {
        return Err(FitError::Cancelled);
    }
    let before = most.load(Ordering::Relaxed);
    let report = |p: &Progress| {
        (control.progress)(&Progress {
            stage: "2 of 2: dp shifted",
            iteration: before + p.iteration,
            expected: before + p.expected,
            ..p.clone()
        });
    };
    let second = Control {
        progress: &report,
        ..*control
    };
    let there = recordings_with_shifted_zero(&original.result.model);
    let begin = |prepared: &Prepared| point_with_shifted_zero(&original, prepared, &there);
    let mut altered = fit_from(&there, parts, begin, &options, &second)?;
    if altered.train.0.rms > RESTART_MISFIT_RATIO * original.result.train.0.rms
        && !altered.cancelled
    {
        let restarted = fit(&there, parts, &[], &options, &second)?;
        if restarted.train.0.rms < altered.train.0.rms {
            altered = restarted;
        }
    }
    Ok(Sensitivity {
        original: original.result,
        altered,
    })
}

/// The device seen from a zero that is higher by [`ZERO_SHIFT`]: ground and film are farther away
/// by as much, and the gain moves the mass lower by as much at each voltage.
fn recordings_with_shifted_zero(model: &Model) -> Model {
    let mut there = model.clone();
    for id in [ParameterId::Dp, ParameterId::Gp] {
        let value = there.parameters[id];
        there.parameters.set(id, value + ZERO_SHIFT);
    }
    let per_force = model.structure().static_gain().filter(|g| *g != 0.0);
    let eta = model.parameters[ParameterId::Eta];
    if let (Some(piezo), Some(per_force)) = (&mut there.piezo, per_force)
        && eta != 0.0
    {
        let gain = ZERO_SHIFT / (eta * per_force);
        piezo.rising[0] -= gain;
        piezo.falling[0] -= gain;
    }
    there
}

/// The end point of a fit, moved to the new zero: the readings' zeros and the initial states by the
/// shift of the static state.
fn point_with_shifted_zero(
    from: &Fitted,
    prepared: &Prepared,
    there: &Model,
) -> Result<Point, SimError> {
    let problem = &prepared.problem;
    let own = problem.space.coordinates(there);
    let mut x = from.point.x.clone();
    x[..own.len()].copy_from_slice(&own);
    let old = from.prepared.problem.simulator(&from.point.x)?;
    let new = problem.simulator(&x)?;
    let structure = there.structure();
    let modes = || structure.modes.iter().filter(|m| m.frequency > 0.0);
    let at = |shape: fn(&crate::model::structure::Mode) -> f64| -> f64 {
        modes()
            .map(|m| m.phi_drive * shape(m) / m.omega().powi(2))
            .sum()
    };
    let (p, c) = (at(|m| m.phi_p), at(|m| m.phi_c));
    for (value, free) in x[own.len()..].iter_mut().zip(&problem.nuisances) {
        let share = match free.what {
            Nuisance::OffsetP => 1.0,
            Nuisance::OffsetC if p != 0.0 => c / p,
            _ => 0.0,
        };
        if there.piezo.is_some() {
            *value += share * ZERO_SHIFT / free.unit;
        }
    }
    let mut segments = from.point.segments.clone();
    for segment in &mut segments {
        let data = &problem.data[segment.recording];
        let start = data.recording.time[segment.samples.start];
        let rest = |sim: &crate::sim::StretchSimulator| {
            let level = segment.starts_held.then(|| sim.ground_level(start));
            sim.rest_state(&segment.pieces, start, level).q
        };
        let (before, after) = (rest(&old), rest(&new));
        for (i, (before, after)) in before.iter().zip(&after).enumerate() {
            segment.locals[i] += (after - before) / segment.units[i];
        }
    }
    settle(
        problem,
        &x,
        &segments,
        &from.point.used,
        START_LOSS,
        START_SETTLE_ROUNDS,
    )
}
