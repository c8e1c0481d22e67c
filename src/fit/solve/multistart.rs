//! From a bad start to the best fit.
//!
//! First come values that follow directly from the recordings: `dp` from the height of the ground,
//! `alpha` from the speeds at bounces. Then everything that acts almost linearly (gain of the
//! drive, offsets, dampings) is fitted with the rest locked, and last everything. This is done
//! from several thicknesses of the film, because its strength and thickness compensate each other
//! along a curved valley of the cost.

use std::sync::{Mutex, PoisonError};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::event_revision::{is_beyond_revision, revise, set_suspects_aside};
use super::levenberg_marquardt::{Clock, Control, Plan, Progress, improve};
use super::point::{Point, settle, threshold};
use super::start_film::{START_GAP_SHARES, weak_film};
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::Nuisance;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::{Prepared, prepare};
use crate::fit::thresholds::{GOOD_START_SCORE, MIN_BOUNCE_RATIO, MIN_USED_SHARE};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::recording::events::Impact;
use crate::recording::quantile_in_place;
use crate::sim::SimError;

/// Stages of as many iterations as are allowed that an attempt may take.
const MAX_STAGES: usize = 3;
/// Iterations that an attempt takes as a rule once it has begun, for the time left.
const EXPECTED_ATTEMPT_ITERATIONS: usize = 30;
/// Factor on the standard deviations of the laws of the ground at the start.
const START_LAW_RELAXATION: f64 = 30.0;
/// Most rounds in which events are revised.
const MAX_EVENT_REVISIONS: usize = 2;
/// Loss at the start: hardly robust, because everything is far off.
const START_LOSS: Huber = Huber(1e4);

/// Loss at the start where only initial states, events and nuisances are fitted again.
const RECOVERY_LOSS: Huber = Huber(1e3);
/// Rounds in which segments settle before they are fitted again.
const RECOVERY_SETTLE_ROUNDS: usize = 6;
/// Most iterations of fitting initial states, events and nuisances again.
const MAX_RECOVERY_ITERATIONS: usize = 10;

/// The best fit of `parts`, the problem, and its first guess.
///
/// # Errors
/// [`FitError`] if the start makes no sense or nothing can be used.
pub fn search(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
    options: &FitOptions,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<(Prepared, Point), FitError> {
    let mut start = model.clone();
    let space = Space::new(model, &options.free)?;
    if space.position("dp").is_some() {
        let mut levels: Vec<f64> = summaries
            .iter()
            .filter_map(|f| f.level.clone().ok())
            .collect();
        let level = quantile_in_place(&mut levels, 0.5);
        if level < 0.0 {
            start.parameters.set(ParameterId::Dp, -level);
        }
    }
    if space.position("alpha").is_some()
        && let Some(alpha) = restitution_of_impacts(parts, summaries)
    {
        start.parameters.set(ParameterId::Alpha, alpha);
    }
    let film = start.has_ground && space.position("gp").is_some();
    let thicknesses = if film {
        &START_GAP_SHARES[..]
    } else {
        &START_GAP_SHARES[..1]
    };
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let tries = thicknesses.len() + options.starts;
    let mut starts = Vec::with_capacity(tries);
    for k in 0..tries {
        let mut first = start.clone();
        if k >= thicknesses.len() {
            draw_start(&mut first, &space, &mut rng);
        }
        set_start_film(&mut first, &space, thicknesses[k % thicknesses.len()]);
        match first.check() {
            Err(error) if k < thicknesses.len() => return Err(error.into()),
            // A random start may make no sense.
            Err(_) => {}
            Ok(()) => starts.push(first),
        }
    }
    let try_one = |first: &Model, control: &Control<'_>, clock: &mut Clock| {
        let (prepared, point) = attempt(first, &space, parts, summaries, options, control, clock)?;
        let aside = point.used.iter().filter(|u| !**u).count() as f64;
        let share = aside / point.used.len().max(1) as f64;
        // Segments that are set aside must not make a bad fit look good.
        let score = point.cost / point.rows.max(1) as f64 + share;
        Ok::<_, FitError>((prepared, point, score))
    };
    let most = MAX_STAGES * options.iterations;
    // The first start is as a rule the last, unless further ones were asked for.
    let later = if options.starts == 0 { 0 } else { tries - 1 };
    clock.expected = clock.done() + most + EXPECTED_ATTEMPT_ITERATIONS * later;
    let first = try_one(&starts[0], control, clock)?;
    // Starts that were asked for are made, however good the fit is already.
    if starts.len() == 1
        || control.cancelled()
        || (first.2 < GOOD_START_SCORE && options.starts == 0)
    {
        return Ok((first.0, first.1));
    }
    let usual = clock.done().max(1);
    // Of starts that run at once the best is shown.
    let shown: Mutex<Option<Progress>> = Mutex::new(None);
    let tell = |progress: &Progress| {
        let mut best = shown.lock().unwrap_or_else(PoisonError::into_inner);
        let mut now = progress.clone();
        // Misfits of different stages cannot be compared.
        let ahead = |b: &&Progress| b.stage == now.stage && b.misfit < now.misfit;
        if let Some(other) = best.as_ref().filter(ahead) {
            now.misfit = other.misfit;
            now.values.clone_from(&other.values);
        }
        (control.progress)(&now);
        *best = Some(now);
    };
    let watched = Control {
        cancel: control.cancel,
        progress: &tell,
    };
    // One that cannot be simulated does not affect the first.
    let others: Vec<_> = starts[1..]
        .par_iter()
        .filter_map(|first| {
            let mut clock = clock.clone();
            clock.expected = usual * tries + most.saturating_sub(EXPECTED_ATTEMPT_ITERATIONS);
            try_one(first, &watched, &mut clock).ok()
        })
        .collect();
    let better = others.into_iter().filter(|other| other.2 < first.2);
    let best = better.min_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or(first);
    Ok((best.0, best.1))
}

/// Median ratio of the speeds at the clear bounces; `None` below three of them.
fn restitution_of_impacts(parts: &[Part], summaries: &[RecordingSummary]) -> Option<f64> {
    let mut ratios = Vec::new();
    for (part, summary) in parts.iter().zip(summaries) {
        let impacts = summary.events(&part.recording).impacts;
        let ratio = |i: &Impact| -i.v_after / i.v_before;
        ratios.extend(
            impacts
                .iter()
                .map(ratio)
                .filter(|r| *r > MIN_BOUNCE_RATIO && *r < 1.0),
        );
    }
    (ratios.len() >= 3).then(|| quantile_in_place(&mut ratios, 0.5))
}

/// The best fit from one start.
fn attempt(
    start: &Model,
    space: &Space,
    parts: &[Part],
    summaries: &[RecordingSummary],
    options: &FitOptions,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<(Prepared, Point), FitError> {
    let mut prepared = prepare(start, space, parts, summaries, options)?;
    relax_ground_laws(&mut prepared, START_LAW_RELAXATION);
    let problem = &prepared.problem;
    let mut x = space.coordinates(start);
    x.extend_from_slice(&prepared.nuisances);
    let used = vec![true; prepared.segments.len()];
    let point = settle(problem, &x, &prepared.segments, &used, START_LOSS, 3)?;
    let ground = ["gp", "Cs", "Ca", "Ca0", "alpha"];
    let mut later: Vec<usize> = ground.iter().filter_map(|id| space.position(id)).collect();
    if later.len() == space.len() {
        later.clear();
    }
    let skews = problem.nuisances.iter().enumerate();
    later.extend(
        skews
            .filter(|(_, n)| n.what == Nuisance::Skew)
            .map(|(i, _)| space.len() + i),
    );
    let first = Plan {
        stage: "drive and structure",
        iterations: 6,
        locked: &later,
        enough: 1e-6,
    };
    let point = improve(problem, point, &first, control, clock)?;
    clock.expected -= (MAX_STAGES * options.iterations).saturating_sub(EXPECTED_ATTEMPT_ITERATIONS);
    let all = joint_plan(options);
    let mut best = improve(problem, point, &all, control, clock)?;
    best = revise_events(&prepared, best, &all, control, clock)?;
    relax_ground_laws(&mut prepared, 1.0 / START_LAW_RELAXATION);
    best = improve(&prepared.problem, best, &all, control, clock)?;
    best = revise_events(&prepared, best, &all, control, clock)?;
    Ok((prepared, best))
}

/// The plan in which all parameters are free.
pub(crate) fn joint_plan(options: &FitOptions) -> Plan<'static> {
    Plan {
        stage: "all parameters",
        iterations: options.iterations,
        locked: &[],
        enough: 1e-6,
    }
}

/// Sets segments aside that do not fit, fits the others, and revises the events of the former,
/// as long as that makes some fit.
pub(crate) fn revise_events(
    prepared: &Prepared,
    mut best: Point,
    plan: &Plan<'_>,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Point, FitError> {
    let problem = &prepared.problem;
    for _ in 0..MAX_EVENT_REVISIONS {
        if is_beyond_revision(&best) {
            break;
        }
        let huber = threshold(problem, &best)?;
        if control.cancelled() || set_suspects_aside(problem, &mut best, huber, control)? == 0 {
            break;
        }
        best = improve(problem, best, plan, control, clock)?;
        recover_nuisances(prepared, &mut best, control, clock)?;
        let huber = threshold(problem, &best)?;
        let watch = (control, &*clock);
        if revise(problem, &mut best, &prepared.segments, huber, watch)? == 0 {
            break;
        }
        best = improve(problem, best, plan, control, clock)?;
    }
    Ok(best)
}

/// The plan in which only unknowns of the recordings are estimated, with `locked` held.
pub(crate) fn states_plan(locked: &[usize], iterations: usize) -> Plan<'_> {
    Plan {
        stage: "initial states and events",
        iterations: iterations.min(MAX_RECOVERY_ITERATIONS),
        locked,
        enough: 1e-6,
    }
}

/// The point that `plan` leads to at unknowns `x`, the segments that are `used` being as
/// first guessed.
///
/// # Errors
/// [`SimError`] if the model makes no sense at `x`.
pub(crate) fn fit_states(
    prepared: &Prepared,
    x: &[f64],
    used: &[bool],
    plan: &Plan<'_>,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Point, SimError> {
    let problem = &prepared.problem;
    let point = settle(
        problem,
        x,
        &prepared.segments,
        used,
        RECOVERY_LOSS,
        RECOVERY_SETTLE_ROUNDS,
    )?;
    improve(problem, point, plan, control, clock)
}

/// Estimates the nuisances of each recording again of which hardly any segment is used, with the
/// device held: with a wrong zero its segments would never fit again.
fn recover_nuisances(
    prepared: &Prepared,
    best: &mut Point,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<(), FitError> {
    let problem = &prepared.problem;
    let parameters = problem.space.len();
    for recording in 0..problem.data.len() {
        let own: Vec<bool> = best
            .segments
            .iter()
            .map(|s| s.recording == recording)
            .collect();
        let samples = |has_say: bool| -> usize {
            let segments = best.segments.iter().zip(&best.used);
            let own = segments
                .zip(&own)
                .filter(|((_, used), own)| **own && (**used || !has_say));
            own.map(|((s, _), _)| s.samples.len()).sum()
        };
        if samples(true) as f64 >= MIN_USED_SHARE * samples(false) as f64 || control.cancelled() {
            continue;
        }
        let mut x = best.x.clone();
        let mut locked: Vec<usize> = (0..parameters).collect();
        for (i, nuisance) in problem.nuisances.iter().enumerate() {
            if nuisance.recording == recording {
                x[parameters + i] = prepared.nuisances[i];
            } else {
                locked.push(parameters + i);
            }
        }
        let point = fit_states(
            prepared,
            &x,
            &own,
            &states_plan(&locked, MAX_RECOVERY_ITERATIONS),
            control,
            clock,
        )?;
        best.x[parameters..].copy_from_slice(&point.x[parameters..]);
        for (i, _) in own.iter().enumerate().filter(|(_, own)| **own) {
            best.segments[i] = point.segments[i].clone();
        }
    }
    Ok(())
}

/// Relaxes the laws of bounce and release by a factor. While some events are misread, only the
/// samples should determine how fast and when the mass leaves the ground; otherwise the misread
/// events distort the laws, and the correct ones no longer fit.
fn relax_ground_laws(prepared: &mut Prepared, factor: f64) {
    for data in &mut prepared.problem.data {
        data.sigmas.velocity *= factor;
        data.sigmas.force *= factor;
    }
}

/// Draws a start around the given one, each parameter up to a factor of two off.
fn draw_start(model: &mut Model, space: &Space, rng: &mut ChaCha8Rng) {
    for entry in &space.entries {
        let factor = 2f64.powf(2.0 * rng.random::<f64>() - 1.0);
        if let Some(value) = model.get(&entry.id)
            && entry.id != "dp"
            && entry.spec.refusal(value * factor).is_none()
        {
            // The id comes from the model itself.
            let _ = model.set(&entry.id, value * factor);
        }
    }
}

/// Sets a weak film of a given thickness at contact where film parameters are free, one
/// as thick as asked for otherwise.
fn set_start_film(model: &mut Model, space: &Space, share: f64) {
    let p = &mut model.parameters;
    let dp = p[ParameterId::Dp];
    if model.has_ground && space.position("gp").is_some() {
        p.set(ParameterId::Gp, dp * (1.0 + share));
    }
    let thickness = p[ParameterId::Gp] - dp;
    if model.has_ground && space.position("Cs").is_some() {
        let weak = weak_film(model) * thickness.powi(3);
        let p = &mut model.parameters;
        let cs = p[ParameterId::Cs];
        p.set(ParameterId::Cs, if cs > 0.0 { cs.min(weak) } else { weak });
    }
}
