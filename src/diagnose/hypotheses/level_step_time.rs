//! The time of a step of the ground, refined to a sample: a scan finds it to a segment, and a
//! segment in which the mass rests lasts milliseconds.

use rayon::prelude::*;

use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::CandidateFit;
use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::STEP_TIME_MIN_GAIN;
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::model::Model;
use crate::model::effects::EffectSpec;
use crate::sim::{SimError, StretchSimulator};

/// Times tried in each round. In the first, they are so close that readings on either side show
/// whether the mass followed; in the last, as close as samples.
const SEARCH_TIMES: [usize; 3] = [48, 8, 8];
/// Most times that the search is centred anew.
const MAX_RECENTRINGS: usize = 4;
/// Half width of the search around the known time \[s\]: a segment with both points lasts no
/// longer.
const SEARCH_HALF_WIDTH: f64 = 5e-3;
/// Share of the half width beyond which the search is centred anew.
const RECENTRE_SHARE: f64 = 0.8;
/// Iterations of each segment's own fit.
const LOCAL_FIT_STEPS: usize = 1;

/// Index of the step's time among its parameters.
const TIME_INDEX: usize = 1;

/// The hypothesis of `trial`, a step of the ground, at a time that fits the segments around it
/// better; `None` if none is much better.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn refine_step_time(trial: &CandidateFit) -> Result<Option<Hypothesis>, SimError> {
    let spec = trial.hypothesis.start.spec;
    let sides: Vec<&Fitted> = std::iter::once(&trial.train)
        .chain(&trial.held_out)
        .collect();
    let time = better_time(&sides, spec)?;
    Ok(time.map(|time| {
        let mut finer = trial.hypothesis.clone();
        finer.start.values[TIME_INDEX] = time;
        finer
    }))
}

/// A time of the step `spec` \[s\] that fits the segments of all `sides` around it better than
/// that in their model, if there is one.
fn better_time(sides: &[&Fitted], spec: &EffectSpec) -> Result<Option<f64>, SimError> {
    let own = |side: &&Fitted| {
        let mut effects = side.model.effects.iter();
        effects
            .find(|e| e.spec == spec)
            .map(|e| e.values[TIME_INDEX])
    };
    let Some(known) = sides.first().and_then(own) else {
        return Ok(None);
    };
    let mut found = None;
    for _ in 0..MAX_RECENTRINGS {
        let time = found.unwrap_or(known);
        let window = (time - SEARCH_HALF_WIDTH, time + SEARCH_HALF_WIDTH);
        let cost = |time: f64| -> Result<f64, SimError> {
            let mut sum = 0.0;
            for side in sides {
                sum += cost_in_window(side, &with_step_time(&side.model, spec, time), window)?;
            }
            Ok(sum)
        };
        let now = cost(time)?;
        let (least, when) = minimise_in_window(window, (now, time), &cost)?;
        log::debug!("the ground steps at {when:.6} rather than {time:.6}: {now:.1} to {least:.1}");
        if least > now - STEP_TIME_MIN_GAIN {
            break;
        }
        found = Some(when);
        if (when - time).abs() < RECENTRE_SHARE * SEARCH_HALF_WIDTH {
            break;
        }
    }
    Ok(found)
}

/// The least `cost` in a window, among `best` and times that close in on it.
fn minimise_in_window(
    (mut low, mut high): (f64, f64),
    mut best: (f64, f64),
    cost: &dyn Fn(f64) -> Result<f64, SimError>,
) -> Result<(f64, f64), SimError> {
    for times in SEARCH_TIMES {
        let step = (high - low) / (times + 1) as f64;
        for k in 1..=times {
            let time = low + step * k as f64;
            let cost = cost(time)?;
            if cost < best.0 {
                best = (cost, time);
            }
        }
        (low, high) = (best.1 - step, best.1 + step);
    }
    Ok(best)
}

/// `model` with its step `spec` at `time`.
fn with_step_time(model: &Model, spec: &EffectSpec, time: f64) -> Model {
    let mut at = model.clone();
    for effect in at.effects.iter_mut().filter(|e| e.spec == spec) {
        effect.values[TIME_INDEX] = time;
    }
    at
}

/// Cost of the segments of `side` that have samples in the window \[s\] and contact with the
/// ground, for `model`, which has the same modes.
fn cost_in_window(side: &Fitted, model: &Model, (from, to): (f64, f64)) -> Result<f64, SimError> {
    let (problem, point) = (&side.problem, &side.point);
    let simulator = StretchSimulator::new(model, &problem.options)?;
    let meets = |s: &Segment| {
        let event = |j: &Joint| matches!(j.what, JointKind::Event(_));
        s.starts_held || s.joints.iter().any(event)
    };
    let near = |s: &Segment| {
        let data = &problem.data[s.recording];
        let at = |i: usize| data.recording.time[i] + data.epoch;
        at(s.samples.start) < to && at(s.samples.end - 1) > from
    };
    let all = point.segments.iter().zip(&point.used);
    let own: Vec<Segment> = all
        .filter(|(s, used)| **used && meets(s) && near(s))
        .map(|(s, _)| s.clone())
        .collect();
    let states = problem.states(&point.x, &simulator, &own);
    let costs = own.par_iter().zip(&states).map(|(segment, states)| {
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        let start = segment.locals.clone();
        let refined = problem.refine(
            segment,
            states,
            &simulator,
            &nuisances,
            start,
            ROBUST_LOSS,
            LOCAL_FIT_STEPS,
        );
        refined.cost
    });
    Ok(costs.sum())
}

#[cfg(test)]
mod tests {
    use super::super::level_step_time::*;
    use crate::diagnose::test_support::{QUIET, stepping, workspace_of};
    use crate::model::effects::find;

    #[test]
    fn the_time_of_a_step_under_a_resting_mass_is_found_to_a_sample() {
        const STEP_RISE: f64 = 0.4e-6;
        // No more than the noise of a few samples: what moves by more seems to fly.
        let workspace_on = |time: f64| {
            let drives = [("square:15Hz:8V", 0.1), ("ramped:10Hz:8V:0.15", 0.1)];
            workspace_of(&stepping(STEP_RISE, time), &drives, 50e3, 100e-9)
        };
        let lies = 20e-3;
        let workspace = workspace_on(lies);
        let spec = find("gap_step").unwrap();
        for off in [-3e-3, 1.5e-3, 3.5e-3] {
            let fit = workspace.fit_cold_start(&stepping(STEP_RISE, lies + off), &[], &[], &QUIET);
            let time = better_time(&[&fit.unwrap()], spec).unwrap();
            let time = time.expect("a better time");
            assert!((time - lies).abs() < 4e-5, "{off}: {time}");
        }
        let right = workspace.fit_cold_start(&stepping(STEP_RISE, lies), &[], &[], &QUIET);
        let time = better_time(&[&right.unwrap()], spec).unwrap();
        assert!(time.is_none_or(|t| (t - lies).abs() < 2e-5), "{time:?}");
    }
}
