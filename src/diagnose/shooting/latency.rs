//! Late readings: the latency that the clocks of the recordings agree on, and a delay of the
//! readings that the clocks have absorbed.

use std::sync::LazyLock;

use super::clock_skew::{
    LOCAL_FIT_STEPS, SAME_SKEW, SkewTrials, fitted_skews, shift_skews, skew_indices,
    skew_prior_cost,
};
use super::fitted::Fitted;
use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::thresholds::{
    MAX_SKEW_SPREAD, RECUT_MIN_LAG, SKEW_MAX_Z, SKEW_MIN_COST_DROP, SKEWS_ASKED_CHI2,
};
use crate::fit::problem::{FreeNuisance, Problem};
use crate::fit::solve::point::{Point, settle};
use crate::model::Model;
use crate::model::effects::{self, own_ids};
use crate::recording::extremes;
use crate::sim::{SimError, StretchSimulator};

/// Skews that differ by less than this were copied from one another \[s\].
const COPIED_SKEW: f64 = 1e-9;

/// Id of the delay of the readings, as `effect.parameter`.
static DELAY: LazyLock<String> = LazyLock::new(|| {
    let own = effects::reading_delay().map(|(effect, which)| own_ids(effect, &[which]));
    own.into_iter().flatten().next().unwrap_or_default()
});
/// Iterations of the reweighted mean that returns a delay from the clocks.
const SHARING_ITERATIONS: usize = 30;

/// Latency of the readings against the voltage beyond that they were cut for, where it exceeds
/// what segments tolerate \[s\]. It is what most recordings agree on, because a recording cut for
/// another clock may have settled on a wrong one.
pub fn common_latency(fitted: &Fitted) -> Option<f64> {
    let data = fitted.problem.data.iter();
    let longest = data.map(|d| d.recording.interval()).fold(0.0, f64::max);
    let all = fitted_skews(&fitted.problem, &fitted.point);
    // A copied skew does not count as independent.
    let own = |k: usize| all[..k].iter().all(|b| (all[k] - b).abs() > COPIED_SKEW);
    let voices: Vec<f64> = (0..all.len()).filter(|k| own(*k)).map(|k| all[k]).collect();
    let agreed = |a: f64| -> f64 {
        let with = voices.iter().map(|b| (-(a - b).abs() / SAME_SKEW).exp());
        with.sum()
    };
    let most = all
        .iter()
        .max_by(|a, b| agreed(**a).total_cmp(&agreed(**b)))?;
    (most.abs() > RECUT_MIN_LAG * longest).then_some(-most)
}

/// Difference in latency between two recordings \[s\], where clocks of one setup cannot differ by
/// as much and something is missing. A lagging amplifier delays the jumps of a voltage, and hardly
/// a slow voltage.
pub fn clock_disagreement(fitted: &Fitted) -> Option<f64> {
    let all = fitted_skews(&fitted.problem, &fitted.point);
    let (low, high) = extremes(&all);
    let apart = high - low;
    (apart > MAX_SKEW_SPREAD && fitted.per_value() > SKEWS_ASKED_CHI2).then_some(apart)
}

/// The delay of the readings that the clocks may have absorbed \[s\]: its growth if all of them
/// give up the same part of their offset from the prior, and the resulting fall of chi2. Both
/// descriptions fit alike; only the prior on the clocks distinguishes them. The shift is a
/// Huber-weighted mean of the offsets.
pub fn delay_absorbed_by_clocks(problem: &Problem, x: &[f64]) -> (f64, f64) {
    let first = problem.space.len();
    // Offset of each clock from its prior, and the prior's standard deviation.
    let offsets: Vec<(f64, f64)> = skew_indices(problem)
        .into_iter()
        .map(|i| {
            let nuisance = &problem.nuisances[i - first];
            (nuisance.mean - x[i] * nuisance.unit, nuisance.sigma)
        })
        .collect();
    let mut shift = 0.0;
    for _ in 0..SHARING_ITERATIONS {
        let weighted = offsets.iter().map(|(offset, sigma)| {
            let weight = (ROBUST_LOSS.root_weight((offset - shift) / sigma) / sigma).powi(2);
            (weight * offset, weight)
        });
        let (sum, weight) = weighted.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        if weight > 0.0 {
            shift = sum / weight;
        }
    }
    let cost = |by: f64| -> f64 {
        let all = offsets.iter();
        all.map(|(offset, sigma)| ROBUST_LOSS.cost((offset - by) / sigma))
            .sum()
    };
    (shift, cost(0.0) - cost(shift))
}

/// Gives a free delay of the readings what the clocks have absorbed of it, see
/// [`delay_absorbed_by_clocks`]. Linearised steps hardly lead there.
pub fn return_delay_from_clocks(problem: &Problem, x: &mut [f64]) {
    let Some(at) = problem.space.position(&DELAY) else {
        return;
    };
    let (shift, _) = delay_absorbed_by_clocks(problem, x);
    let mut model = problem.space.model(x);
    let Some(delay) = model.get(&DELAY) else {
        return;
    };
    if model.set(&DELAY, (delay + shift).max(0.0)).is_err() {
        return;
    }
    let entry = &problem.space.entries[at];
    x[at] = problem.space.coordinates(&model)[at].clamp(entry.low, entry.high);
    let now = problem.space.model(x).get(&DELAY).unwrap_or(delay);
    shift_skews(problem, x, now - delay);
}

/// A clock of one recording.
struct Clock<'a> {
    /// Number of the unknown.
    at: usize,
    prior: &'a FreeNuisance,
    /// Its skew \[s\].
    skew: f64,
    /// Stretches that are used.
    own: Vec<usize>,
}

impl Clock<'_> {
    /// By how much the prior mean exceeds its skew \[s\].
    fn prior_offset(&self) -> f64 {
        self.prior.mean - self.skew
    }

    fn is_far_from_prior(&self) -> bool {
        self.prior_offset().abs() > SKEW_MAX_Z * self.prior.sigma
    }
}

fn clocks_of<'a>(problem: &'a Problem, point: &Point) -> Vec<Clock<'a>> {
    let one = |(at, skew): (usize, f64)| {
        let prior = &problem.nuisances[at - problem.space.len()];
        let all = point.segments.iter().enumerate();
        let used = all.filter(|(k, s)| point.used[*k] && s.recording == prior.recording);
        let own = used.map(|(k, _)| k).collect();
        Clock {
            at,
            prior,
            skew,
            own,
        }
    };
    let all = skew_indices(problem)
        .into_iter()
        .zip(fitted_skews(problem, point));
    all.map(one).collect()
}

/// Unknowns of the segments of a recording.
type Unknowns = Vec<Vec<f64>>;

fn set_locals(point: &mut Point, own: &[usize], unknowns: Unknowns) {
    for (&k, locals) in own.iter().zip(unknowns) {
        point.segments[k].locals = locals;
    }
}

/// Resets each clock that is far from its prior to the prior mean where that costs less: a delay
/// of the readings that was added or removed has moved all of them. Returns whether any was reset.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn reset_clocks(problem: &Problem, point: &mut Point) -> Result<bool, DiagnoseError> {
    let trials = SkewTrials::new(problem, point)?;
    let mut changed = false;
    for clock in clocks_of(problem, point)
        .iter()
        .filter(|c| c.is_far_from_prior())
    {
        let cost_at = |skew: f64| {
            let start = |k: usize| &point.segments[k].locals[..];
            let (cost, unknowns) =
                trials.cost_at(&clock.own, &start, (clock.at, skew), LOCAL_FIT_STEPS);
            (cost + skew_prior_cost(clock.prior, skew), unknowns)
        };
        let (now, (there, unknowns)) = (cost_at(clock.skew).0, cost_at(clock.prior.mean));
        if there < now - SKEW_MIN_COST_DROP {
            log::debug!(
                "recording {} back: {now:.0} to {there:.0}",
                clock.prior.recording
            );
            point.x[clock.at] = clock.prior.mean / clock.prior.unit;
            set_locals(point, &clock.own, unknowns);
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

/// Redistributes a free delay of the readings between it and the clocks, where these differ by
/// more than their prior allows. A recording of jumps hardly determines its clock and may have
/// kept its prior at the expense of its jumps. Returns whether anything was moved.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn redistribute_delay(problem: &Problem, point: &mut Point) -> Result<bool, DiagnoseError> {
    let Some(entry) = problem.space.position(&DELAY) else {
        return Ok(false);
    };
    let clocks = clocks_of(problem, point);
    if !clocks.iter().any(Clock::is_far_from_prior) {
        return Ok(false);
    }
    let trials = SkewTrials::new(problem, point)?;
    let start = |k: usize| &point.segments[k].locals[..];
    let cost_at = |clock: &Clock<'_>, skew: f64| {
        trials.cost_at(&clock.own, &start, (clock.at, skew), LOCAL_FIT_STEPS)
    };
    let now: Vec<f64> = clocks.iter().map(|c| cost_at(c, c.skew).0).collect();
    let of_now = clocks.iter().zip(&now);
    let of_now: f64 = of_now
        .map(|(c, cost)| cost + skew_prior_cost(c.prior, c.skew))
        .sum();
    // Each clock either gives its offset to the delay or keeps it, whichever costs less.
    let shared = |by: f64| -> (f64, Vec<Option<Unknowns>>) {
        let mut sum = 0.0;
        let one = |(clock, now): (&Clock<'_>, &f64)| {
            let given = now + skew_prior_cost(clock.prior, clock.skew + by);
            // A clock that keeps it reads later by as much.
            let (cost, unknowns) = cost_at(clock, clock.skew - by);
            let kept = cost + skew_prior_cost(clock.prior, clock.skew);
            sum += given.min(kept);
            (kept < given).then_some(unknowns)
        };
        let kept = clocks.iter().zip(&now).map(one).collect();
        (sum, kept)
    };
    let mut asked: Vec<f64> = Vec::new();
    for by in clocks.iter().map(Clock::prior_offset) {
        if by.abs() > SAME_SKEW && asked.iter().all(|other| (other - by).abs() > SAME_SKEW) {
            asked.push(by);
        }
    }
    let tried = asked.into_iter().map(|by| (by, shared(by)));
    let best = tried.min_by(|a, b| a.1.0.total_cmp(&b.1.0));
    let Some((by, (cost, kept))) = best.filter(|b| b.1.0 < of_now - SKEW_MIN_COST_DROP) else {
        return Ok(false);
    };
    let mut model = problem.space.model(&point.x);
    let delay = model.get(&DELAY).unwrap_or(0.0) + by;
    let bound = &problem.space.entries[entry];
    if delay < 0.0 || model.set(&DELAY, delay).is_err() {
        return Ok(false);
    }
    let wanted = problem.space.coordinates(&model)[entry];
    if wanted < bound.low || wanted > bound.high {
        return Ok(false);
    }
    log::debug!("delay {:+.1} us: {of_now:.0} to {cost:.0}", 1e6 * by);
    point.x[entry] = wanted;
    for (clock, kept) in clocks.iter().zip(kept) {
        match kept {
            None => point.x[clock.at] = (clock.skew + by) / clock.prior.unit,
            Some(unknowns) => set_locals(point, &clock.own, unknowns),
        }
    }
    *point = settle(
        problem,
        &point.x,
        &point.segments,
        &point.used,
        ROBUST_LOSS,
        1,
    )?;
    Ok(true)
}

/// Time by which the effects delay the readings \[s\].
pub fn reading_delay(model: &Model) -> Result<f64, SimError> {
    let options = crate::sim::Options::default();
    Ok(StretchSimulator::new(model, &options)?.reading_delay())
}

#[cfg(test)]
mod tests {
    use super::super::latency::*;
    use crate::diagnose::test_support;
    use crate::diagnose::test_support::QUIET;
    use crate::model::preset::Preset;

    #[test]
    fn clocks_return_the_delay_that_they_share() {
        let paper = Preset::embedded("paper").unwrap().model;
        let drives = [
            ("square:40Hz:8V", 0.05),
            ("sine:50Hz:8V", 0.06),
            ("square:300Hz:8V", 0.02),
        ];
        let fit = test_support::workspace_of(&paper, &drives, 25e3, 50e-9);
        let fit = fit.baseline(&paper, &QUIET).unwrap();
        let problem = &fit.problem;
        let clocks = skew_indices(problem);
        let set = |all: [f64; 3]| {
            let mut x = fit.point.x.clone();
            for (&i, skew) in clocks.iter().zip(all) {
                let nuisance = &problem.nuisances[i - problem.space.len()];
                x[i] = (nuisance.mean + skew) / nuisance.unit;
            }
            delay_absorbed_by_clocks(problem, &x)
        };
        let sigma = problem.nuisances[clocks[0] - problem.space.len()].sigma;
        let cost = |away: f64| ROBUST_LOSS.cost(away / sigma);
        let (none, nothing) = set([0.0; 3]);
        assert!(
            none.abs() < 1e-12 && nothing.abs() < 1e-9,
            "{none} {nothing}"
        );
        // All alike: the whole offset and its whole cost.
        let (shift, fall) = set([-100e-6; 3]);
        assert!((shift - 100e-6).abs() < 1e-9, "{shift}");
        assert!((fall - 3.0 * cost(100e-6)).abs() < 1e-6, "{fall}");
        // An outlier pulls by at most the loss's bound: the value that two agree on prevails.
        let (shift, fall) = set([-100e-6, 40e-6, -100e-6]);
        let pull = 6.0 * sigma / 2.0;
        assert!((shift - (100e-6 - pull)).abs() < 1e-8, "{shift}");
        let left = 2.0 * cost(pull) + cost(140e-6 - pull);
        let before = 2.0 * cost(100e-6) + cost(40e-6);
        assert!((fall - (before - left)).abs() < 1e-2, "{fall}");
    }
}
