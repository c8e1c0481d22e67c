//! Whether the motion continues from one segment to the next where nothing happens to the mass.
//! Every segment starts from a state of its own, which absorbs a kick or a burst of force before
//! it; it shows only where two segments are fitted as one. Near the ground the mass may have
//! touched it unnoticed, so joins there are not tested.

use rayon::prelude::*;

use super::residual_map::near_ground_heights;
use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::shooting::fitted::{Fitted, first_reading_correction};
use crate::fit::problem::Data;
use crate::fit::segment::Segment;
use crate::sim::SimError;

/// Iterations of the fit of two segments as one.
const JOINED_FIT_STEPS: usize = 6;
/// Fewest joins for a result.
const MIN_JOINS: usize = 8;
/// Largest contribution of a single join, in units of its expectation by chance.
const MAX_RISE_PER_JOIN: f64 = 12.0;
/// Share of the joins, the worst ones, that are trimmed from the sum: in one or two of them the
/// mass may have touched something.
const TRIMMED_SHARE: f64 = 0.05;

/// Rise of chi2 where neighbouring flight segments are fitted as one.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JoinBreaks {
    /// Of all joins, each capped, in standard deviations of its scatter by chance.
    pub sigmas: f64,
    /// Of all but the worst joins, beyond chance.
    pub rise: f64,
}

/// Rise of chi2 where neighbouring flight segments away from the ground are fitted as one; 0 where
/// there are few, or where the readings do not show all that moves.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn join_breaks(fitted: &Fitted) -> Result<JoinBreaks, SimError> {
    let (problem, point) = (&fitted.problem, &fitted.point);
    let simulator = problem.simulator(&point.x)?;
    // From the proof mass alone, single segments hardly determine how the drive is shared
    // among the modes, but joins at corners of the drive do: what they show is an error of the
    // baseline.
    let unseen = |d: &Data| d.recording.cantilever.is_none();
    if simulator.modes() > 1 && problem.data.iter().any(unseen) {
        return Ok(JoinBreaks::default());
    }
    let states = problem.states(&point.x, &simulator, &point.segments);
    let near = near_ground_heights(problem);
    let flies_free = |i: usize| {
        let s = &point.segments[i];
        let xp = &problem.data[s.recording].recording.proof_mass[s.samples.clone()];
        let high = !fitted.model.has_ground || xp.iter().all(|x| *x > near[s.recording]);
        point.used[i] && !s.starts_held && s.joints.is_empty() && high
    };
    let cost = |i: usize, segment: &Segment, rounds| {
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        let start = segment.locals.clone();
        let refined = problem.refine(
            segment,
            &states[i],
            &simulator,
            &nuisances,
            start,
            ROBUST_LOSS,
            rounds,
        );
        refined.cost
    };
    // The state at the later one's start is no longer free.
    let unknowns = 2.0 * simulator.modes() as f64;
    let mut rises: Vec<f64> = (1..point.segments.len())
        .into_par_iter()
        .filter(|&i| {
            let (a, b) = (&point.segments[i - 1], &point.segments[i]);
            a.recording == b.recording
                && a.samples.end == b.samples.start
                && flies_free(i - 1)
                && flies_free(i)
        })
        .map(|i| {
            let (a, b) = (&point.segments[i - 1], &point.segments[i]);
            // The later segment no longer starts from its first readings.
            let taken = first_reading_correction(problem, &simulator, b);
            let apart = cost(i - 1, a, 2) + cost(i, b, 2) + taken;
            (cost(i - 1, &joined(a, b), JOINED_FIT_STEPS) - apart) / unknowns
        })
        .filter(|rise| rise.is_finite())
        .collect();
    if rises.len() < MIN_JOINS {
        return Ok(JoinBreaks::default());
    }
    let n = rises.len() as f64;
    let capped: f64 = rises.iter().map(|rise| rise.min(MAX_RISE_PER_JOIN)).sum();
    let sigmas = (capped - n) / (2.0 * n / unknowns).sqrt();
    rises.sort_by(f64::total_cmp);
    let worst = rises.last().copied().unwrap_or(0.0);
    rises.truncate(rises.len() - (TRIMMED_SHARE * n).ceil() as usize);
    // A fall means that the separate fits had not converged.
    let beyond: f64 = rises.iter().map(|rise| rise.max(0.0) - 1.0).sum();
    let rise = unknowns * beyond;
    log::debug!("{n} joins: {sigmas:.1}, worst {worst:.1}, all {rise:.0}");
    Ok(JoinBreaks { sigmas, rise })
}

/// Two consecutive segments as one, from the state at the start of the first.
pub(super) fn joined(a: &Segment, b: &Segment) -> Segment {
    let mut both = a.clone();
    both.samples = a.samples.start..b.samples.end;
    let covered = a.pieces.last().map_or(f64::NEG_INFINITY, |p| p.start);
    let later = b.pieces.iter().filter(|p| p.start > covered);
    both.pieces.extend(later.cloned());
    both
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::segment_joins::*;
    use crate::diagnose::options::DiagnoseOptions;
    use crate::diagnose::shooting::workspace::Workspace;
    use crate::diagnose::test_support::QUIET;
    use crate::fit::Part;
    use crate::model::parameter::ParameterId;
    use crate::model::preset::Preset;
    use crate::recording::Recording;

    /// Breaks of a ring-down by its closed form, with a kick to the velocity every 10 s.
    fn of_a_ring_down(kick: f64) -> JoinBreaks {
        let mut dice = ChaCha8Rng::seed_from_u64(5);
        let mut normal = || -> f64 { (0..12).map(|_| dice.random_range(-0.5..0.5)).sum() };
        let (omega, zeta): (f64, f64) = (8.6, 2e-3);
        let ring = |t: f64| (-zeta * omega * t).exp() * (omega * t).cos();
        let after = |t: f64| (-zeta * omega * t).exp() * (omega * t).sin() / omega;
        let time: Vec<f64> = (0..12_000).map(|i| 0.01 * f64::from(i)).collect();
        let x = time.iter().map(|&t| {
            let before = (1..12).map(|k| 10.0 * f64::from(k)).filter(|at| t > *at);
            let kicked: f64 = before.map(|at| kick * after(t - at)).sum();
            0.1 * ring(t) + kicked + 1e-4 * normal()
        });
        let x: Vec<f64> = x.collect();
        let part = Part::whole(Arc::new(
            Recording::new("ring-down", time, None, x, None).unwrap(),
        ));
        let mut model = Preset::embedded("oscillator").unwrap().model;
        // Without a ground a recording is one segment.
        model.has_ground = true;
        model.parameters.set(ParameterId::Dp, 10.0);
        model.parameters.set(ParameterId::Gp, 20.0);
        model.parameters.set(ParameterId::Cs, 1e-24);
        let workspace = Workspace::new(&model, &[part], &[], &DiagnoseOptions::default()).unwrap();
        join_breaks(&workspace.baseline(&model, &QUIET).unwrap()).unwrap()
    }

    #[test]
    fn a_kick_absorbed_by_initial_states_shows_at_the_joins() {
        let undisturbed = of_a_ring_down(0.0);
        assert!(undisturbed.sigmas.abs() < 4.0, "{undisturbed:?}");
        assert!(undisturbed.sigmas != 0.0, "there are joins");
        // A four hundredth of the ring's speed, which the initial states absorb.
        let kicked = of_a_ring_down(2e-3);
        assert!(kicked.sigmas > 10.0, "{kicked:?}");
        // Breaks beyond the cap show in the rise.
        let hard = of_a_ring_down(2e-2);
        assert!(hard.rise > 20.0 * kicked.rise, "{hard:?} {kicked:?}");
        assert!(kicked.rise > 100.0, "{kicked:?}");
    }
}
