//! A fit from beginning to end: inspect, check, search, estimate the uncertainty, evaluate on
//! held-out recordings.

use std::sync::atomic::AtomicBool;

use super::error::FitError;
use super::inspect::motion::check_motion;
use super::inspect::preconditions::{check, check_fit, or_connections};
use super::inspect::recording_summary::summarize;
use super::options::{FitOptions, Part};
use super::problem::parameter_space::Space;
use super::problem::prepare::{Prepared, prepare};
use super::solve::budget::{Ending, within_budget};
use super::solve::estimate_states::estimate_states;
use super::solve::levenberg_marquardt::{Clock, Control, Plan, improve};
use super::solve::multistart::{joint_plan, revise_events, search};
use super::solve::normal_equations::normal_equations;
use super::solve::point::{Point, settle, threshold};
use super::uncertainty::contradiction::{Contradiction, contradictions};
use super::uncertainty::device_consistency::disagreements;
use super::uncertainty::fit_result::{FitResult, Misfit, misfit_remarks, misfits, uncertainty};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::format_quantity;
use crate::sim::SimError;

/// Iterations that states and nuisances usually take, for the estimate of the time left.
const EXPECTED_ESTIMATE_ITERATIONS: usize = 5;
/// Most iterations in which the others follow parameters that went back.
const MAX_FOLLOW_ITERATIONS: usize = 15;

/// A fit with its problem and end point, for another fit that goes on from there.
pub(super) struct Fitted {
    /// What was found.
    pub result: FitResult,
    /// The problem.
    pub prepared: Prepared,
    /// Where it ended.
    pub point: Point,
}

/// Fits the free parameters of `model` to the parts `train`, and reports the misfit on them and
/// on `held_out`, where only initial states, events and nuisances are estimated. If cancelled,
/// it returns the best so far.
///
/// # Errors
/// [`FitError`] with one clear sentence if the input makes no sense, before any long
/// computation.
///
/// # Examples
/// ```no_run
/// use std::sync::Arc;
/// use std::sync::atomic::AtomicBool;
///
/// use impactscope::fit::{Control, FitOptions, Part, fit};
/// use impactscope::model::preset::Preset;
/// use impactscope::recording::csv::import_auto;
///
/// let model = Preset::default().model;
/// let recording = Arc::new(import_auto("recording.csv".as_ref(), None)?);
/// let (train, held_out) = Part::split(recording);
/// let cancel = AtomicBool::new(false);
/// let control = Control { cancel: &cancel, progress: &|_| {} };
/// let options = FitOptions::for_model(&model);
/// let result = fit(&model, &[train], &[held_out], &options, &control)?;
/// for p in &result.parameters {
///     println!("{} = {} +- {} {}", p.id, p.value, p.std_error, p.unit);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit(
    model: &Model,
    train: &[Part],
    held_out: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<FitResult, FitError> {
    Ok(fitted(model, train, held_out, options, control)?.result)
}

/// [`fit`] with the point that it ended at, within the time that the options allow.
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
    let work = |stop: &AtomicBool| {
        let watched = Control {
            cancel: stop,
            progress: control.progress,
        };
        fitted_until_stopped(model, (train, held_out), options, &watched)
    };
    let (found, ending) = within_budget(options.budget, control.cancel, work);
    let mut found = found?;
    if let (Ending::OutOfTime, Some(budget)) = (ending, options.budget)
        && found.result.cancelled
    {
        let seconds = format_quantity(budget.as_secs_f64(), "s", 3);
        found.result.remarks.insert(
            0,
            format!("its time of {seconds} was used up before the fit had ended: give it more time for the best values"),
        );
    }
    Ok(found)
}

/// [`fitted`] without a limit on its time.
///
/// # Errors
/// Those of [`fit`].
fn fitted_until_stopped(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Fitted, FitError> {
    if options.free.is_empty() {
        return Err(FitError::NothingFree);
    }
    let mut sound = model.clone();
    let p = &mut sound.parameters;
    // The film's thickness is searched from its own starts, so a bad one does not matter.
    if options.free.iter().any(|id| id.eq_ignore_ascii_case("gp"))
        && p[ParameterId::Gp] <= p[ParameterId::Dp]
    {
        p.set(ParameterId::Gp, 1.2 * p[ParameterId::Dp]);
    }
    let start = model;
    let model = &sound;
    model.check()?;
    let summaries = summarize(model, train);
    check_motion(train)?;
    let checked = check(model, train, &summaries, options);
    or_connections(checked, model, train)?;
    for part in held_out {
        let one = std::slice::from_ref(part);
        // A held-out part need not touch the ground.
        match check(model, one, &summarize(model, one), options) {
            Err(FitError::NoContact { .. }) | Ok(()) => {}
            Err(error) => return Err(error),
        }
    }
    let doubts = check_fit(model, (train, &summaries), held_out, options)?;
    let mut clock = Clock::new(0);
    clock.doubts = doubts.clone().into();
    let (prepared, mut best) = search(model, train, &summaries, options, control, &mut clock)?;
    reset_irrelevant(model, &prepared, &mut best)?;
    let mut result = result_at(start, &prepared, &best, control)?;
    if let Some(point) = hold_undetermined(model, &prepared, &best, &result, control, &mut clock)? {
        best = point;
        result = result_at(start, &prepared, &best, control)?;
    }
    if result.cancelled {
        let unevaluated = if held_out.is_empty() {
            ""
        } else {
            "; it was not evaluated on the held-out recordings"
        };
        result.remarks.push(format!(
            "the fit ended before it was done: this is the best so far{unevaluated}"
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
    let all: Vec<Part> = train.iter().chain(held_out).cloned().collect();
    result.remarks.extend(Part::fault_sentences(&all));
    Ok(Fitted {
        result,
        prepared,
        point: best,
    })
}

/// Fits from where another fit ended: `begin` is that point, transferred to `model`. No starts
/// are tried, and events are revised only in segments that do not fit.
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
    let summaries = summarize(model, train);
    let prepared = prepare(model, &space, train, &summaries, options)?;
    let plan = joint_plan(options);
    let mut clock = Clock::new(options.iterations);
    let begin = begin(&prepared)?;
    let point = improve(&prepared.problem, begin, &plan, control, &mut clock)?;
    let best = revise_events(&prepared, point, &plan, control, &mut clock)?;
    result_at(model, &prepared, &best, control)
}

/// The result at a point: values with standard errors, and misfits.
fn result_at(
    start: &Model,
    prepared: &Prepared,
    point: &Point,
    control: &Control<'_>,
) -> Result<FitResult, FitError> {
    let train = misfits(prepared, point)?;
    let chi2 = train.0.chi2;
    let mut result = uncertainty(start, prepared, point, chi2)?;
    let problem = &prepared.problem;
    let huber = threshold(problem, point)?;
    let needs = contradictions(problem, point, huber, chi2)?;
    result.remarks.extend(needs.iter().map(Contradiction::text));
    result.remarks.extend(misfit_remarks(&train.1));
    result.train = train;
    result.cancelled = control.cancelled();
    Ok(result)
}

/// Parameters that no residual depends on go back to their starting values: they may have
/// wandered during the search.
fn reset_irrelevant(model: &Model, prepared: &Prepared, best: &mut Point) -> Result<(), FitError> {
    let problem = &prepared.problem;
    let space = &problem.space;
    let huber = threshold(problem, best)?;
    let reduced = problem.linearize(&best.x, &best.segments, &best.used, huber, &[])?;
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

/// Parameters that are not determined, because others compensate any change of them, may be
/// anywhere along a valley of the cost. They go back to their starting values, and the others
/// follow; of the film's two the strength follows the gap. `None` if there are none.
fn hold_undetermined(
    model: &Model,
    prepared: &Prepared,
    best: &Point,
    result: &FitResult,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Option<Point>, FitError> {
    let space = &prepared.problem.space;
    let undetermined: Vec<&str> = result
        .parameters
        .iter()
        .filter(|p| p.std_error.is_infinite())
        .map(|p| p.id.as_str())
        .collect();
    let mut held: Vec<usize> = undetermined
        .iter()
        .filter_map(|id| space.position(id))
        .collect();
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
        stage: "undetermined parameters held",
        iterations: MAX_FOLLOW_ITERATIONS,
        locked: &held,
        enough: 1e-6,
    };
    clock.expected = clock.done() + MAX_FOLLOW_ITERATIONS;
    Ok(Some(improve(problem, point, &plan, control, clock)?))
}

/// Misfit of `model` on `parts` with its parameters held: initial states of the segments,
/// instants of the events and nuisances are estimated. All together, and each part.
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
    let summaries = summarize(model, parts);
    let prepared = prepare(model, &space, parts, &summaries, options)?;
    let point = estimate_states(&prepared, model, options, control, clock)?;
    Ok(misfits(&prepared, &point)?)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::super::pipeline::*;
    use crate::model::drive::Waveform;
    use crate::model::preset::Preset;
    use crate::model::sensor::Sensor;
    use crate::recording::Recording;
    use crate::sim::{Options, simulate};

    #[test]
    fn an_undetermined_film_goes_back_to_its_gap_and_the_rest_follows() {
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
        // Far along the valley, where neither is determined.
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
