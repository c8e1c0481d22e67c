//! Clock skews of the recordings. Readings that are late by several samples spoil every segment
//! with a jump of the voltage, and those segments determine the clocks.

use rayon::prelude::*;

use crate::diagnose::data::robust_loss::{LEAST_SQUARES, MISREAD_CHI2, ROBUST_LOSS};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::thresholds::{
    SKEW_MIN_COST_DROP, SKEW_PROMISING_COST_RATIO, SKEW_WELL_EXPLAINED_CHI2,
};
use crate::fit::problem::{FreeNuisance, Nuisance, Problem};
use crate::fit::segment::Segment;
use crate::fit::solve::point::{Point, settle};
use crate::recording::quantile_in_place;
use crate::sim::{SimError, StretchSimulator};

/// Skews that every recording is tried with \[s\].
const SKEW_GRID: [f64; 9] = [-2e-4, -1e-4, -5e-5, -2e-5, 0.0, 2e-5, 5e-5, 1e-4, 2e-4];
/// Skews that differ by less than this agree \[s\].
pub(crate) const SAME_SKEW: f64 = 5e-6;

/// Iterations of each segment's own fit, by least squares and then by the robust loss.
pub(crate) const LOCAL_FIT_STEPS: [usize; 2] = [3, 3];
/// The same for a first look at another skew.
const SCREENING_STEPS: [usize; 2] = [1, 0];
/// No iterations: the segments as they are.
const NO_STEPS: [usize; 2] = [0, 0];

/// The segments of a fit, to be tried under other clock skews.
pub(crate) struct SkewTrials<'a> {
    problem: &'a Problem,
    x: Vec<f64>,
    segments: Vec<Segment>,
    simulator: StretchSimulator,
    states: Vec<Vec<f64>>,
}

impl<'a> SkewTrials<'a> {
    /// The segments of the fit at `point`.
    pub(crate) fn new(problem: &'a Problem, point: &Point) -> Result<Self, SimError> {
        let simulator = problem.simulator(&point.x)?;
        Ok(Self {
            states: problem.states(&point.x, &simulator, &point.segments),
            segments: point.segments.clone(),
            x: point.x.clone(),
            simulator,
            problem,
        })
    }

    /// Cost of the segments `own` of one recording if its skew, unknown number `at`, is `skew`
    /// \[s\], and their unknowns, refined from `start` in so many `rounds` under either loss.
    pub(crate) fn cost_at<'s>(
        &self,
        own: &[usize],
        start: &(dyn Fn(usize) -> &'s [f64] + Sync),
        (at, skew): (usize, f64),
        rounds: [usize; 2],
    ) -> (f64, Vec<Vec<f64>>) {
        let problem = self.problem;
        let nuisance = &problem.nuisances[at - problem.space.len()];
        let mut x = self.x.clone();
        x[at] = skew / nuisance.unit;
        let nuisances = problem.nuisances_of(&x, nuisance.recording);
        let fits: Vec<(Vec<f64>, f64)> = own
            .par_iter()
            .map(|&i| {
                let segment = &self.segments[i];
                let fit = |locals, loss, rounds| {
                    let (states, simulator) = (&self.states[i], &self.simulator);
                    problem.refine(segment, states, simulator, &nuisances, locals, loss, rounds)
                };
                let near = fit(start(i).to_vec(), LEAST_SQUARES, rounds[0]);
                let refined = fit(near.locals, ROBUST_LOSS, rounds[1]);
                // A misread segment must not decide.
                let most = MISREAD_CHI2 * problem.rows(segment).len() as f64;
                (refined.locals, refined.cost.min(most))
            })
            .collect();
        let cost = fits.iter().map(|(_, cost)| cost).sum();
        (cost, fits.into_iter().map(|(locals, _)| locals).collect())
    }
}

/// Cost of a skew \[s\] under what is known of the clock beforehand.
pub(crate) fn skew_prior_cost(nuisance: &FreeNuisance, skew: f64) -> f64 {
    ROBUST_LOSS.cost((skew - nuisance.mean) / nuisance.sigma)
}

/// Resets the clocks of recordings that another skew describes far better: one of a grid, or that
/// of another recording. Their segments among `eligible` are taken in again from their `first`
/// guess. Returns whether any clock was reset.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn set_clocks(
    problem: &Problem,
    point: &mut Point,
    (first, eligible): (&[Segment], &[bool]),
    control: &DiagnoseControl<'_>,
) -> Result<bool, DiagnoseError> {
    if control.cancelled() {
        return Ok(false);
    }
    let space = problem.space.len();
    let clocks: Vec<usize> = skew_indices(problem);
    let unit = |i: usize| problem.nuisances[i - space].unit;
    let mut tried: Vec<f64> = clocks.iter().map(|&i| point.x[i] * unit(i)).collect();
    for &skew in &SKEW_GRID {
        if tried.iter().all(|t| (t - skew).abs() > SAME_SKEW) {
            tried.push(skew);
        }
    }
    let trials = SkewTrials::new(problem, point)?;
    let mut changed = false;
    for &at in &clocks {
        let nuisance = &problem.nuisances[at - space];
        let own: Vec<usize> = (0..point.segments.len())
            .filter(|&i| eligible[i] && point.segments[i].recording == nuisance.recording)
            .collect();
        let cost_at = |skew: f64, rounds| {
            let start = |i: usize| {
                let own = if point.used[i] {
                    &point.segments[i]
                } else {
                    &first[i]
                };
                &own.locals[..]
            };
            let (cost, locals) = trials.cost_at(&own, &start, (at, skew), rounds);
            (cost + skew_prior_cost(nuisance, skew), locals)
        };
        let present = point.x[at] * nuisance.unit;
        let rows: usize = own
            .iter()
            .map(|&i| problem.rows(&point.segments[i]).len())
            .sum();
        let well = |cost: f64| cost < SKEW_WELL_EXPLAINED_CHI2 * rows as f64;
        if control.cancelled() {
            break;
        }
        // A recording that fits well as it is needs no refinement.
        if well(cost_at(present, NO_STEPS).0) {
            continue;
        }
        let now = cost_at(present, LOCAL_FIT_STEPS).0;
        if well(now) {
            continue;
        }
        let looked = cost_at(present, SCREENING_STEPS).0.max(now);
        let best = tried
            .iter()
            .filter(|skew| (**skew - present).abs() > SAME_SKEW)
            .filter(|skew| cost_at(**skew, SCREENING_STEPS).0 < SKEW_PROMISING_COST_RATIO * looked)
            .map(|&skew| (skew, cost_at(skew, LOCAL_FIT_STEPS)))
            .min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        if let Some((skew, (cost, locals))) = best
            && cost < now - SKEW_MIN_COST_DROP
        {
            log::debug!(
                "recording {}: skew {:.1} us in place of {:.1} us, chi2 {now:.0} to {cost:.0}",
                nuisance.recording,
                1e6 * skew,
                1e6 * present
            );
            point.x[at] = skew / nuisance.unit;
            for (&i, locals) in own.iter().zip(locals) {
                point.segments[i].locals = locals;
                point.used[i] = true;
            }
            changed = true;
        }
    }
    if changed {
        *point = settle(
            problem,
            &point.x,
            &point.segments,
            &point.used,
            ROBUST_LOSS,
            1,
        )?;
    }
    Ok(changed)
}

/// Indices of the unknowns that are skews.
pub fn skew_indices(problem: &Problem) -> Vec<usize> {
    let all = problem.nuisances.iter().enumerate();
    all.filter(|(_, n)| n.what == Nuisance::Skew)
        .map(|(i, _)| problem.space.len() + i)
        .collect()
}

/// Skews of all recordings in a fit, relative to those they were cut for \[s\].
pub fn fitted_skews(problem: &Problem, point: &Point) -> Vec<f64> {
    let first = problem.space.len();
    let value = |i: usize| point.x[i] * problem.nuisances[i - first].unit;
    skew_indices(problem).into_iter().map(value).collect()
}

/// Median skew of the recordings in a fit \[s\].
pub fn median_skew(problem: &Problem, point: &Point) -> f64 {
    let skew = quantile_in_place(&mut fitted_skews(problem, point), 0.5);
    if skew.is_finite() { skew } else { 0.0 }
}

/// Moves all skews by `by` \[s\], so that a delay of the readings can be added or removed
/// elsewhere.
pub fn shift_skews(problem: &Problem, x: &mut [f64], by: f64) {
    let first = problem.space.len();
    for i in skew_indices(problem) {
        x[i] += by / problem.nuisances[i - first].unit;
    }
}
