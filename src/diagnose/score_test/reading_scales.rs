//! Scales of readings that differ from recording to recording: a spot of the laser that was set anew,
//! a decoder that was calibrated again.
//!
//! Each reading of each recording has a scale of its own with a prior around 1. The prior is so narrow
//! at first that nothing moves it, because scales left free imitate weak forces. It is widened only
//! where that explains more than any effect of the catalogue would.

use super::linearized::Linearized;
use super::scan::{NuisanceProjector, ScoreScan};
use crate::diagnose::shooting::fitted::Fitted;
use crate::fit::problem::{FreeNuisance, Nuisance, Problem};
use crate::sim::SimError;

/// Standard deviation of a scale while all are taken as one.
pub(crate) const EQUAL_SCALE_SIGMA: f64 = 1e-5;
/// Standard deviation of a scale that differs from recording to recording.
pub(crate) const OWN_SCALE_SIGMA: f64 = 0.01;

fn is_scale(nuisance: &FreeNuisance) -> bool {
    matches!(nuisance.what, Nuisance::ScaleP | Nuisance::ScaleC)
}

/// Whether the scales of a problem's readings are taken as one.
pub(crate) fn are_equal(problem: &Problem) -> bool {
    let mut scales = problem.nuisances.iter().filter(|n| is_scale(n));
    scales.any(|n| n.sigma == EQUAL_SCALE_SIGMA)
}

/// Whether each reading of each recording of a problem has a scale of its own.
pub(crate) fn has_own_scales(problem: &Problem) -> bool {
    let mut scales = problem.nuisances.iter().filter(|n| is_scale(n));
    scales.any(|n| n.sigma == OWN_SCALE_SIGMA)
}

/// Lets the readings of each recording of a problem have a scale of their own.
pub(crate) fn set_free(problem: &mut Problem) {
    let scales = problem.nuisances.iter_mut().filter(|n| is_scale(n));
    scales.for_each(|n| n.sigma = OWN_SCALE_SIGMA);
}

/// By how much the scale farthest from 1 differs from it in a fit; 0 without scales.
pub(crate) fn largest_difference(fitted: &Fitted) -> f64 {
    let own = &fitted.point.x[fitted.problem.space.len()..];
    let all = fitted.problem.nuisances.iter().zip(own);
    let scales = all.filter(|(n, _)| is_scale(n));
    scales.fold(0.0, |most, (n, x)| f64::max(most, (n.unit * x).abs()))
}

/// Predicted fall of chi2 by scales of their own, the first `locked` unknowns held; 0 where it cannot
/// be computed.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub(crate) fn gain_by_own_scales(fitted: &Fitted, locked: usize) -> Result<f64, SimError> {
    let linear = Linearized::new(fitted)?;
    let products = linear.segment_grams(&fitted.model, &[])?;
    let mut scan = ScoreScan::assemble(&linear, &products, 0);
    let first = fitted.problem.space.len();
    let gain = |scan: &ScoreScan| {
        let base = scan.projector_with_locked(locked);
        base.as_ref().map(NuisanceProjector::gain)
    };
    let before = gain(&scan);
    for (i, n) in fitted.problem.nuisances.iter().enumerate() {
        if is_scale(n) {
            let weight = |sigma: f64| (n.unit / sigma).powi(2);
            let value = fitted.point.x[first + i];
            scan.add_prior(first + i, value, weight(OWN_SCALE_SIGMA) - weight(n.sigma));
        }
    }
    let after = gain(&scan);
    Ok(after
        .zip(before)
        .map_or(0.0, |(after, before)| after - before))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::reading_scales::*;
    use crate::diagnose::force_balance::guide;
    use crate::diagnose::test_support::{QUIET, parts_of, workspace};
    use crate::fit::Part;
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::preset::Preset;
    use crate::model::{Model, with_effect};
    use crate::recording::Recording;

    const DRIVES: [(&str, f64); 3] = [
        ("square:40Hz:8V", 0.06),
        ("sine:50Hz:7V", 0.06),
        ("ramped:15Hz:8V:0.3", 0.1),
    ];

    /// Recordings of a device, each read with a scale of its own.
    fn read_with(scales: [f64; 3], device: &Model) -> Vec<Part> {
        let parts = parts_of(device, &DRIVES, 25e3, 20e-9);
        let scaled = parts.iter().zip(scales).map(|(part, scale)| {
            let r = &part.recording;
            let times = |x: &Vec<f64>| -> Vec<f64> { x.iter().map(|x| scale * x).collect() };
            let (xp, xc) = (times(&r.proof_mass), r.cantilever.as_ref().map(times));
            let made = Recording::new(r.name.clone(), r.time.clone(), r.voltage.clone(), xp, xc);
            Part::whole(Arc::new(made.unwrap()))
        });
        scaled.collect()
    }

    fn paper() -> Model {
        Preset::embedded("paper").unwrap().model
    }

    #[test]
    fn scales_that_differ_are_seen_by_the_balance_and_by_the_score() {
        let parts = read_with([1.0, 1.006, 0.995], &paper());
        let workspace = workspace(&parts);
        let found = guide(&workspace, &paper(), &|_| true, 2.0).unwrap();
        assert!(found.scales_differ && found.rivals.is_empty(), "{found:?}");
        let equal = workspace.baseline(&paper(), &QUIET).unwrap();
        let gain = gain_by_own_scales(&equal, 0).unwrap();
        assert!(are_equal(&equal.problem) && gain > 1e3, "{gain}");
        let freed = workspace.with_own_scales();
        let own = freed
            .fit(&equal.model, &[], &[], &equal, 12, &QUIET)
            .unwrap();
        assert!(has_own_scales(&own.problem) && !are_equal(&own.problem));
        assert!(own.per_value() < 1.05, "{}", own.per_value());
        let most = largest_difference(&own);
        assert!((0.004..0.008).contains(&most), "{most}");
    }

    #[test]
    fn equal_scales_stay_equal_whether_or_not_a_force_is_missing() {
        let drag = ActiveEffect {
            spec: find("quadratic_drag").unwrap(),
            values: vec![1e-7, 0.0],
        };
        for device in [paper(), with_effect(&paper(), drag)] {
            let workspace = workspace(&read_with([1.0; 3], &device));
            let found = guide(&workspace, &paper(), &|_| true, 2.0).unwrap();
            assert!(!found.scales_differ);
        }
    }
}
