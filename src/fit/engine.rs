//! A fit from beginning to end: look, check, search, judge.

use super::check::check;
use super::error::FitError;
use super::global::{all_parameters, read_again, search};
use super::options::FitOptions;
use super::prepare::{Part, Prepared, look, prepare};
use super::profile::{ProfilePoint, profile};
use super::result::{FitResult, Misfit, misfits, uncertainty};
use super::revise::{revise, set_suspects_aside};
use super::robust::Huber;
use super::solve::{Clock, Control, Plan, Point, improve, normal_equations, settle, threshold};
use super::space::Space;
use crate::model::Model;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::ParameterId;
use crate::recording::Recording;
use crate::sim::{Options, SimError, simulate};

/// A fit with the problem and the point that it ended at, for one that goes on from there.
pub(super) struct Fitted {
    /// What was found.
    pub result: FitResult,
    /// The problem.
    pub prepared: Prepared,
    /// Where it ended.
    pub point: Point,
}

/// Fits the free parameters of `model` to the parts `train`, and measures what is left
/// on them and on `held_out`, where only initial states and the rig's nuisances are
/// estimated anew. Cancelled, it gives the best so far.
///
/// # Errors
/// [`FitError`] with one clear sentence if the input makes no sense, before any long
/// computation.
pub fn fit(
    model: &Model,
    train: &[Part],
    held_out: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<FitResult, FitError> {
    Ok(fitted(model, train, held_out, options, control)?.result)
}

/// [`fit`] with the point that it ended at.
///
/// # Errors
/// Those of [`fit`].
pub(super) fn fitted(
    model: &Model,
    train: &[Part],
    held_out: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Fitted, FitError> {
    let mut sound = model.clone();
    let p = &mut sound.parameters;
    // The film's thickness is found anew, so that a bad one does not matter.
    if options.free.iter().any(|id| id.eq_ignore_ascii_case("gp"))
        && p[ParameterId::Gp] <= p[ParameterId::Dp]
    {
        p.set(ParameterId::Gp, 1.2 * p[ParameterId::Dp]);
    }
    let start = model;
    let model = &sound;
    model.check()?;
    let findings = look(model, train);
    check(model, train, &findings, options)?;
    for part in held_out {
        let bare = FitOptions {
            free: options.free.clone(),
            ..options.clone()
        };
        // A held-out part need not touch the ground.
        match check(
            model,
            std::slice::from_ref(part),
            &look(model, std::slice::from_ref(part)),
            &bare,
        ) {
            Err(FitError::NoContact { .. }) | Ok(()) => {}
            Err(error) => return Err(error),
        }
    }
    let (prepared, mut best) = search(model, train, &findings, options, control)?;
    forget_untold(model, &prepared, &mut best)?;
    let mut result = judged(start, &prepared, &best, control)?;
    if !held_out.is_empty() {
        result.held_out = Some(judge(&result.model, held_out, options, control)?);
    }
    Ok(Fitted {
        result,
        prepared,
        point: best,
    })
}

/// Fits from where another fit ended: `begin` is that point, brought over to `model`.
/// Neither a film is searched for nor are events read anew that fit.
///
/// # Errors
/// [`FitError`] if a part cannot be used with `model`.
pub(super) fn go_on(
    model: &Model,
    train: &[Part],
    begin: impl FnOnce(&Prepared) -> Result<Point, SimError>,
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<FitResult, FitError> {
    model.check()?;
    let space = Space::new(model, &options.free)?;
    let findings = look(model, train);
    let prepared = prepare(model, &space, train, &findings, options)?;
    let plan = all_parameters(options);
    let mut clock = Clock::new(options.iterations);
    let begin = begin(&prepared)?;
    let point = improve(&prepared.problem, begin, &plan, control, &mut clock)?;
    let best = read_again(&prepared, point, &plan, control, &mut clock)?;
    judged(model, &prepared, &best, control)
}

/// What was found at a point: values with their errors, and what is left.
fn judged(
    start: &Model,
    prepared: &Prepared,
    point: &Point,
    control: &Control<'_>,
) -> Result<FitResult, FitError> {
    let train = misfits(prepared, point)?;
    let mut result = uncertainty(start, prepared, point, train.0.chi2)?;
    result.train = train;
    result.cancelled = control.cancelled();
    Ok(result)
}

/// Parameters on which nothing that was read depends go back to where they began: on the
/// way to the fit they may have wandered.
fn forget_untold(model: &Model, prepared: &Prepared, best: &mut Point) -> Result<(), FitError> {
    let problem = &prepared.problem;
    let space = &problem.space;
    let huber = threshold(problem, best)?;
    let reduced = problem.linearise(&best.x, &best.segments, &best.used, huber)?;
    let (normal, _) = normal_equations(problem, &best.x, &reduced, huber);
    let start = space.coordinates(model);
    for (i, entry) in space.entries.iter().enumerate() {
        let range = entry.high - entry.low;
        if normal[(i, i)] * range * range < 1.0 {
            best.x[i] = start[i];
        }
    }
    Ok(())
}

/// Distance between `model` and `parts`, its parameters frozen: initial states of the
/// segments, instants of the events and the rig's nuisances are estimated.
///
/// # Errors
/// [`FitError`] if a part cannot be used.
pub fn judge(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<(Misfit, Vec<Misfit>), FitError> {
    let space = Space::new(model, &options.free)?;
    let findings = look(model, parts);
    let prepared = prepare(model, &space, parts, &findings, options)?;
    let point = estimate_states(&prepared, model, options, control)?;
    Ok(misfits(&prepared, &point)?)
}

/// The point at a model's own values, all else estimated.
pub(super) fn estimate_states(
    prepared: &Prepared,
    model: &Model,
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Point, FitError> {
    let problem = &prepared.problem;
    let mut x = problem.space.coordinates(model);
    let locked: Vec<usize> = (0..x.len()).collect();
    x.extend_from_slice(&prepared.nuisances);
    let used = vec![true; prepared.segments.len()];
    let far = Huber(1e3);
    let mut point = settle(problem, &x, &prepared.segments, &used, far, 6)?;
    let plan = Plan {
        stage: "beginnings and events",
        iterations: options.iterations.min(10),
        locked: &locked,
        enough: 1e-6,
    };
    let mut clock = Clock::new(plan.iterations);
    point = improve(problem, point, &plan, control, &mut clock)?;
    let huber = threshold(problem, &point)?;
    if set_suspects_aside(problem, &mut point, huber)? > 0 {
        revise(problem, &mut point, &prepared.segments, huber)?;
        point = improve(problem, point, &plan, control, &mut clock)?;
    }
    Ok(point)
}

/// Root mean square of (simulation - recording) of the proof mass over a whole run from
/// rest, for information: impacts make it grow however good the model is. `None` where
/// the two have nothing in common.
///
/// # Errors
/// [`SimError`] if the model cannot be simulated.
pub fn free_run(model: &Model, recording: &Recording) -> Result<Option<f64>, SimError> {
    let drive = match recording.drive_table() {
        Some((time, volts)) => {
            let table = VoltageTable::from_recording(&recording.name, time, volts)?;
            Waveform::Table(std::sync::Arc::new(table))
        }
        None => Waveform::Rest,
    };
    let options = Options {
        rate: recording.sampling_rate(),
        ..Options::default()
    };
    let (_, end) = recording.span();
    if end <= 0.0 {
        return Ok(None);
    }
    let trace = simulate(model, &drive, end, &options)?;
    let grid = crate::recording::Grid {
        t0: trace.t0,
        dt: trace.dt,
        values: &trace.proof_mass,
        slopes: Some(&trace.proof_mass_velocity),
    };
    let misses: Vec<f64> = recording
        .time
        .iter()
        .zip(&recording.proof_mass)
        .filter_map(|(&t, x)| grid.value_at(t).map(|s| s - x))
        .filter(|d| d.is_finite())
        .collect();
    let square: f64 = misses.iter().map(|d| d * d).sum();
    Ok((!misses.is_empty()).then(|| (square / misses.len() as f64).sqrt()))
}

/// Profile of the parameter `id` of a `result` on the parts `train` that it was fitted to:
/// the best cost with its value held at each of `shifts` in its standard errors, all other
/// fitted parameters fitted anew. `options` are those of the fit but for what is free.
/// Cancelled, it gives the points found so far.
///
/// # Errors
/// [`FitError`] if a part cannot be used or the parameter was not fitted.
pub fn profile_of(
    result: &FitResult,
    train: &[Part],
    id: &str,
    shifts: &[f64],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Vec<ProfilePoint>, FitError> {
    let fitted: Vec<String> = result.parameters.iter().map(|p| p.id.clone()).collect();
    let Some(parameter) = result
        .parameters
        .iter()
        .find(|p| p.id.eq_ignore_ascii_case(id))
    else {
        return Err(FitError::NotFitted {
            id: id.to_owned(),
            fitted: fitted.join(", "),
        });
    };
    let space = Space::new(&result.model, &fitted)?;
    let findings = look(&result.model, train);
    let prepared = prepare(&result.model, &space, train, &findings, options)?;
    let point = estimate_states(&prepared, &result.model, options, control)?;
    profile(&prepared, point, parameter, shifts, options, control)
}
