//! A fit from beginning to end: look, check, search, judge.

use super::error::FitError;
use super::inspect::preconditions::{check, check_fit};
use super::inspect::recording_summary::summarize;
use super::options::{FitOptions, Part};
use super::problem::parameter_space::Space;
use super::problem::prepare::{Prepared, prepare};
use super::solve::estimate_states::estimate_states;
use super::solve::levenberg_marquardt::{Clock, Control, Plan, improve};
use super::solve::multistart::{joint_plan, revise_events, search};
use super::solve::normal_equations::normal_equations;
use super::solve::point::{Point, settle, threshold};
use super::uncertainty::device_consistency::disagreements;
use super::uncertainty::fit_result::{FitResult, Misfit, misfit_remarks, misfits, uncertainty};
use crate::model::Model;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::ParameterId;
use crate::recording::Recording;
use crate::sim::{Options, SimError, simulate};

/// Iterations in which states and nuisances are estimated as a rule, for the time left.
const EXPECTED_ESTIMATE_ITERATIONS: usize = 5;
/// Most iterations in which the others follow parameters that are put back.
const MAX_FOLLOW_ITERATIONS: usize = 15;

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
    let findings = summarize(model, train);
    check(model, train, &findings, options)?;
    for part in held_out {
        let one = std::slice::from_ref(part);
        // A held-out part need not touch the ground.
        match check(model, one, &summarize(model, one), options) {
            Err(FitError::NoContact { .. }) | Ok(()) => {}
            Err(error) => return Err(error),
        }
    }
    let doubts = check_fit(model, (train, &findings), held_out, options)?;
    let mut clock = Clock::new(0);
    clock.doubts = doubts.clone().into();
    let (prepared, mut best) = search(model, train, &findings, options, control, &mut clock)?;
    reset_irrelevant(model, &prepared, &mut best)?;
    let mut result = result_at(start, &prepared, &best, control)?;
    if let Some(point) = hold_undetermined(model, &prepared, &best, &result, control, &mut clock)? {
        best = point;
        result = result_at(start, &prepared, &best, control)?;
    }
    if result.cancelled {
        let kept_out = if held_out.is_empty() {
            ""
        } else {
            "; it was not measured on what is held out"
        };
        result.remarks.push(format!(
            "the fit was cancelled: this is the best so far{kept_out}"
        ));
    } else {
        let all = train.len() + held_out.len();
        clock.expected =
            clock.done() + EXPECTED_ESTIMATE_ITERATIONS * usize::from(!held_out.is_empty());
        if !held_out.is_empty() {
            let found = evaluate_on(&result.model, held_out, options, control, &mut clock)?;
            result.remarks.extend(misfit_remarks(&found.1));
            result.held_out = Some(found);
        }
        let each = result.held_out.iter().flat_map(|h| &h.1);
        let bad = each.chain(&result.train.1).any(Misfit::is_bad);
        if bad && all > 1 {
            let parts = (train, held_out);
            let words = disagreements(&result.model, parts, options, control, &mut clock)?;
            result.remarks.extend(words);
        }
    }
    result.remarks.extend(doubts);
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
pub(super) fn fit_from(
    model: &Model,
    train: &[Part],
    begin: impl FnOnce(&Prepared) -> Result<Point, SimError>,
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<FitResult, FitError> {
    model.check()?;
    let space = Space::new(model, &options.free)?;
    let findings = summarize(model, train);
    let prepared = prepare(model, &space, train, &findings, options)?;
    let plan = joint_plan(options);
    let mut clock = Clock::new(options.iterations);
    let begin = begin(&prepared)?;
    let point = improve(&prepared.problem, begin, &plan, control, &mut clock)?;
    let best = revise_events(&prepared, point, &plan, control, &mut clock)?;
    result_at(model, &prepared, &best, control)
}

/// What was found at a point: values with their errors, and what is left.
fn result_at(
    start: &Model,
    prepared: &Prepared,
    point: &Point,
    control: &Control<'_>,
) -> Result<FitResult, FitError> {
    let train = misfits(prepared, point)?;
    let mut result = uncertainty(start, prepared, point, train.0.chi2)?;
    result.remarks.extend(misfit_remarks(&train.1));
    result.train = train;
    result.cancelled = control.cancelled();
    Ok(result)
}

/// Parameters on which nothing that was read depends go back to where they began: on the
/// way to the fit they may have wandered.
fn reset_irrelevant(model: &Model, prepared: &Prepared, best: &mut Point) -> Result<(), FitError> {
    let problem = &prepared.problem;
    let space = &problem.space;
    let huber = threshold(problem, best)?;
    let reduced = problem.linearise(&best.x, &best.segments, &best.used, huber, &[])?;
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

/// Parameters that the data do not tell because others make up for any change of them
/// may have gone anywhere along the valley. They go back to where they began and the
/// others follow; of a film's two the strength follows the gap. `None` if there are none.
fn hold_undetermined(
    model: &Model,
    prepared: &Prepared,
    best: &Point,
    result: &FitResult,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Option<Point>, FitError> {
    let space = &prepared.problem.space;
    let untold: Vec<&str> = result
        .parameters
        .iter()
        .filter(|p| p.std_error.is_infinite())
        .map(|p| p.id.as_str())
        .collect();
    let mut held: Vec<usize> = untold.iter().filter_map(|id| space.position(id)).collect();
    let begin = space.coordinates(model);
    if held.iter().all(|&i| best.x[i] == begin[i]) {
        return Ok(None);
    }
    if let (Some(cs), Some(gp)) = (space.position("Cs"), space.position("gp"))
        && (held.contains(&cs) || held.contains(&gp))
    {
        held.retain(|i| *i != cs);
        if !held.contains(&gp) {
            held.push(gp);
        }
    }
    if control.cancelled() {
        return Ok(None);
    }
    let mut x = best.x.clone();
    for &i in &held {
        x[i] = begin[i];
    }
    let problem = &prepared.problem;
    let huber = threshold(problem, best)?;
    let point = settle(problem, &x, &best.segments, &best.used, huber, 3)?;
    let plan = Plan {
        stage: "what the data do not tell",
        iterations: MAX_FOLLOW_ITERATIONS,
        locked: &held,
        enough: 1e-6,
    };
    clock.expected = clock.done() + MAX_FOLLOW_ITERATIONS;
    Ok(Some(improve(problem, point, &plan, control, clock)?))
}

/// Distance between `model` and `parts`, its parameters frozen: initial states of the
/// segments, instants of the events and the rig's nuisances are estimated.
///
/// # Errors
/// [`FitError`] if a part cannot be used.
pub fn evaluate(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<(Misfit, Vec<Misfit>), FitError> {
    evaluate_on(
        model,
        parts,
        options,
        control,
        &mut Clock::new(EXPECTED_ESTIMATE_ITERATIONS),
    )
}

fn evaluate_on(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<(Misfit, Vec<Misfit>), FitError> {
    let space = Space::new(model, &options.free)?;
    let findings = summarize(model, parts);
    let prepared = prepare(model, &space, parts, &findings, options)?;
    let point = estimate_states(&prepared, model, options, control, clock)?;
    Ok(misfits(&prepared, &point)?)
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::super::pipeline::*;
    use crate::model::preset::Preset;
    use crate::model::sensor::Sensor;

    #[test]
    fn a_film_that_is_not_told_goes_back_to_its_gap_and_the_rest_follows() {
        let model = Preset::default().model;
        let drive = Waveform::parse("sine:50Hz:8V", 0.05).unwrap();
        let mut trace = simulate(&model, &drive, 0.05, &Options::default()).unwrap();
        let sensor = Sensor {
            noise: 20e-9,
            ..Sensor::default()
        };
        sensor.add_noise(&mut trace.proof_mass, 1);
        let (volts, xp) = (trace.voltage.clone(), trace.proof_mass.clone());
        let r = Recording::new("r", trace.times(), Some(volts), xp, None).unwrap();
        let parts = [Part::whole(Arc::new(r))];
        let options = FitOptions {
            free: ["eta", "dp", "Cs", "gp"].map(str::to_owned).to_vec(),
            ..FitOptions::for_model(&model)
        };
        let cancel = AtomicBool::new(false);
        let control = Control {
            cancel: &cancel,
            progress: &|_| {},
        };
        let found = fitted(&model, &parts, &[], &options, &control).unwrap();
        let space = &found.prepared.problem.space;
        let mut clock = Clock::new(0);
        let mut held = |point: &Point, result: &FitResult| {
            let prepared = &found.prepared;
            hold_undetermined(&model, prepared, point, result, &control, &mut clock).unwrap()
        };
        assert!(held(&found.point, &found.result).is_none());
        // Far along the valley, where neither is told.
        let mut strayed = found.point.clone();
        strayed.x[space.position("gp").unwrap()] += 2.0;
        let mut result = found.result.clone();
        result.parameters[space.position("Cs").unwrap()].std_error = f64::INFINITY;
        let back = space.model(&held(&strayed, &result).unwrap().x);
        let gap = |m: &Model| m.parameters[ParameterId::Gp] - m.parameters[ParameterId::Dp];
        assert!((gap(&back) / gap(&model) - 1.0).abs() < 1e-6);
        let strength = back.parameters[ParameterId::Cs] / model.parameters[ParameterId::Cs];
        assert!((strength - 1.0).abs() < 0.05, "{strength}");
    }
}
