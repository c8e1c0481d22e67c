//! Clocks of the recordings: readings that are late by several samples spoil every stretch
//! with a jump of the voltage, and those are what the clocks are told by.

use rayon::prelude::*;

use super::{FORSAKEN, Fitted, LOSS, WIDE};
use crate::diagnose::options::DiagnoseError;
use crate::fit::problem::{Nuisance, Problem};
use crate::fit::segment::Segment;
use crate::fit::solve::{Point, settle};
use crate::model::Model;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, StretchSimulator};

/// Skews that every recording is tried with \[s\].
const TRIED: [f64; 9] = [-2e-4, -1e-4, -5e-5, -2e-5, 0.0, 2e-5, 5e-5, 1e-4, 2e-4];
/// Samples by which readings are late from which they are cut by a voltage as late.
const LATE: f64 = 0.8;
/// Skews nearer than this agree \[s\].
const NEAR: f64 = 5e-6;
/// Fall of a recording's cost from which it takes another skew.
pub const BETTER: f64 = 40.0;
/// Cost per value up to which a recording is told well as it is.
const WELL: f64 = 1.1;
/// A delay of the readings.
const DELAY: &str = "sensor_lag.delay";
/// Steps in which it takes its share of the clocks.
const SHARED: usize = 30;
/// Steps of each stretch's own fit, by either loss.
const ROUNDS: usize = 3;

/// Sets the clocks of recordings that another skew tells far better, be it one of some or
/// that of another recording, and gives their stretches among `eligible` their say back,
/// from their `first` guess. Whether any was set.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn set_clocks(
    problem: &Problem,
    point: &mut Point,
    first: &[Segment],
    eligible: &[bool],
) -> Result<bool, DiagnoseError> {
    let space = problem.space.len();
    let clocks: Vec<usize> = skews(problem);
    let unit = |i: usize| problem.nuisances[i - space].unit;
    let mut tried: Vec<f64> = clocks.iter().map(|&i| point.x[i] * unit(i)).collect();
    for &skew in &TRIED {
        if tried.iter().all(|t| (t - skew).abs() > NEAR) {
            tried.push(skew);
        }
    }
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let mut changed = false;
    for &at in &clocks {
        let nuisance = &problem.nuisances[at - space];
        let own: Vec<usize> = (0..point.segments.len())
            .filter(|&i| eligible[i] && point.segments[i].recording == nuisance.recording)
            .collect();
        // What each stretch comes to, as it stands or from its first guess.
        let told = |skew: f64| -> (f64, Vec<Vec<f64>>) {
            let mut x = point.x.clone();
            x[at] = skew / nuisance.unit;
            let nuisances = problem.nuisances_of(&x, nuisance.recording);
            let fits: Vec<(Vec<f64>, f64)> = own
                .par_iter()
                .map(|&i| {
                    let segment = &point.segments[i];
                    let start = if point.used[i] { segment } else { &first[i] };
                    let fit = |locals, loss| {
                        let nuisances = &nuisances;
                        problem.refine(
                            segment, &states[i], &simulator, nuisances, locals, loss, ROUNDS,
                        )
                    };
                    let (near, _) = fit(start.locals.clone(), WIDE);
                    let (locals, cost) = fit(near, LOSS);
                    // What was misread must not decide.
                    let most = FORSAKEN * problem.rows(segment).len() as f64;
                    (locals, cost.min(most))
                })
                .collect();
            let prior = LOSS.cost((skew - nuisance.mean) / nuisance.sigma);
            let cost = fits.iter().map(|(_, cost)| cost).sum::<f64>() + prior;
            (cost, fits.into_iter().map(|(locals, _)| locals).collect())
        };
        let present = point.x[at] * nuisance.unit;
        let now = told(present).0;
        let rows: usize = own
            .iter()
            .map(|&i| problem.rows(&point.segments[i]).len())
            .sum();
        if now < WELL * rows as f64 {
            continue;
        }
        let best = tried
            .iter()
            .filter(|skew| (**skew - present).abs() > NEAR)
            .map(|&skew| (skew, told(skew)))
            .min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        if let Some((skew, (cost, locals))) = best
            && cost < now - BETTER
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
        *point = settle(problem, &point.x, &point.segments, &point.used, LOSS, 1)?;
    }
    Ok(changed)
}

/// Time by which readings are later against the voltage than they were cut for, where that is
/// more than stretches bear \[s\]: what most recordings agree about, for one cut for another
/// clock may be told by a wrong one.
pub fn late(fitted: &Fitted) -> Option<f64> {
    let data = fitted.problem.data.iter();
    let longest = data.map(|d| d.recording.interval()).fold(0.0, f64::max);
    let all = skews_of(&fitted.problem, &fitted.point);
    let agreed = |a: f64| -> f64 { all.iter().map(|b| (-(a - b).abs() / NEAR).exp()).sum() };
    let most = all
        .iter()
        .max_by(|a, b| agreed(**a).total_cmp(&agreed(**b)))?;
    (most.abs() > LATE * longest).then_some(-most)
}

/// Which unknowns are skews.
pub fn skews(problem: &Problem) -> Vec<usize> {
    let all = problem.nuisances.iter().enumerate();
    all.filter(|(_, n)| n.what == Nuisance::Skew)
        .map(|(i, _)| problem.space.len() + i)
        .collect()
}

/// Skews of all recordings of a fit against what they were cut for \[s\].
pub fn skews_of(problem: &Problem, point: &Point) -> Vec<f64> {
    let first = problem.space.len();
    let value = |i: usize| point.x[i] * problem.nuisances[i - first].unit;
    skews(problem).into_iter().map(value).collect()
}

/// Skew of the clocks in most recordings of a fit \[s\].
pub fn usual_skew(problem: &Problem, point: &Point) -> f64 {
    let skew = quantile_in_place(&mut skews_of(problem, point), 0.5);
    if skew.is_finite() { skew } else { 0.0 }
}

/// Moves all skews by `by` \[s\]: a delay of the readings that comes or goes is taken out
/// of them, or left to them.
pub fn shift_skews(problem: &Problem, x: &mut [f64], by: f64) {
    let first = problem.space.len();
    for i in skews(problem) {
        x[i] += by / problem.nuisances[i - first].unit;
    }
}

/// Gives a delay of the readings that is free what the clocks have taken of it: the two fit
/// alike, only what is known of the clocks tells them apart, and steps of a fit that foresee
/// how the readings change hardly lead that way.
pub fn share_delay(problem: &Problem, x: &mut [f64]) {
    let Some(at) = problem.space.position(DELAY) else {
        return;
    };
    let first = problem.space.len();
    // What each clock lacks to be as known, and how well it is known.
    let lacks: Vec<(f64, f64)> = skews(problem)
        .into_iter()
        .map(|i| {
            let nuisance = &problem.nuisances[i - first];
            (nuisance.mean - x[i] * nuisance.unit, nuisance.sigma)
        })
        .collect();
    let mut shift = 0.0;
    for _ in 0..SHARED {
        let weighed = lacks.iter().map(|(lack, sigma)| {
            let weight = (LOSS.root_weight((lack - shift) / sigma) / sigma).powi(2);
            (weight * lack, weight)
        });
        let (sum, weight) = weighed.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        if weight > 0.0 {
            shift = sum / weight;
        }
    }
    let mut model = problem.space.model(x);
    let Some(delay) = model.get(DELAY) else {
        return;
    };
    if model.set(DELAY, (delay + shift).max(0.0)).is_err() {
        return;
    }
    let entry = &problem.space.entries[at];
    x[at] = problem.space.coordinates(&model)[at].clamp(entry.low, entry.high);
    let now = problem.space.model(x).get(DELAY).unwrap_or(delay);
    shift_skews(problem, x, now - delay);
}

/// Time by which the effects make readings late \[s\].
pub fn delay(model: &Model) -> Result<f64, SimError> {
    let options = crate::sim::Options::default();
    Ok(StretchSimulator::new(model, &options)?.reading_delay())
}
