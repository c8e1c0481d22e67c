//! Whether recordings that do not fit together are of one device: ground level and first frequency
//! are fitted to each alone, and the values are compared.

use std::sync::Arc;

use super::fit_result::{misfits, uncertainty};
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::prepare;
use crate::fit::solve::estimate_states::estimate_states;
use crate::fit::solve::levenberg_marquardt::{Clock, Control, Plan, improve};
use crate::fit::thresholds::{DEVICE_DIFFERENCE_SHARE, DEVICE_DIFFERENCE_SIGMAS, SET_ASIDE_CHI2};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::format_quantity;

/// Starting values of the first frequency, relative to that of all recordings, until one leads to a
/// fit: from far off, the search may end anywhere.
const START_FREQUENCY_FACTORS: [f64; 3] = [1.0, 0.8, 1.25];
/// Most iterations for each of them.
const MAX_DEVICE_ITERATIONS: usize = 15;

/// A value with its standard error, SI.
type Value = (f64, f64);
/// A value with the name of the recording that it fits.
type Named<'a> = (&'a str, Value);

/// Sentences on recordings whose ground level or first frequency differ, each fitted alone around
/// the values of `model`. Empty for a single recording.
///
/// # Errors
/// [`FitError`] if a part cannot be used.
pub(crate) fn disagreements(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    options: &FitOptions,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Vec<String>, FitError> {
    let mut parts: Vec<&Part> = Vec::new();
    for part in train.iter().chain(held_out) {
        // Two parts of one recording are of one device.
        if parts
            .iter()
            .all(|p| !Arc::ptr_eq(&p.recording, &part.recording))
        {
            parts.push(part);
        }
    }
    let of_device = [ParameterId::Dp, ParameterId::F1];
    let ids: Vec<String> = of_device
        .into_iter()
        .filter(|id| model.uses(*id) && model.parameters[*id] > 0.0)
        .map(|id| id.spec().id.to_owned())
        .collect();
    if parts.len() < 2 || ids.is_empty() {
        return Ok(Vec::new());
    }
    clock.expected = clock.done() + MAX_DEVICE_ITERATIONS * parts.len();
    let mut alone: Vec<(&str, Vec<Value>)> = Vec::new();
    for part in parts {
        let values = fitted_alone(model, part, &ids, options, control, clock)?;
        alone.push((&part.recording.name, values));
    }
    if control.cancelled() {
        return Ok(Vec::new());
    }
    let mut out = Vec::new();
    for (i, id) in ids.iter().enumerate() {
        let unit = of_device
            .iter()
            .map(|p| p.spec())
            .find(|spec| spec.id == *id)
            .map_or("", |spec| spec.unit);
        let own: Vec<Named<'_>> = alone.iter().map(|(name, v)| (*name, v[i])).collect();
        out.extend(most_different(&own).map(|((a, x), (b, y))| {
            let write = |v: Value| {
                let (value, error) = (format_quantity(v.0, unit, 4), format_quantity(v.1, unit, 2));
                format!("{value} +- {error}")
            };
            format!(
                "{a} and {b} do not agree: where each is fitted alone, with all else as fitted to all, {id} is {} in the one and {} in the other; they may be of different devices (fit them separately), or the model lacks something that acts differently in them (a diagnosis looks for it)",
                write(x),
                write(y)
            )
        }));
    }
    Ok(out)
}

/// The values of `ids` fitted to one part alone, all other parameters held; the film keeps its
/// thickness at contact.
fn fitted_alone(
    model: &Model,
    part: &Part,
    ids: &[String],
    options: &FitOptions,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Vec<Value>, FitError> {
    let mut free = ids.to_vec();
    if model.has_ground {
        free.push(ParameterId::Gp.spec().id.to_owned());
    }
    let space = Space::new(model, &free)?;
    let one = std::slice::from_ref(part);
    let summaries = summarize(model, one);
    let mut begin = model.clone();
    if let Ok(level) = summaries[0].level
        && level < 0.0
        && model.has_ground
    {
        let p = &mut begin.parameters;
        let thickness = p[ParameterId::Gp] - p[ParameterId::Dp];
        p.set(ParameterId::Dp, -level);
        p.set(ParameterId::Gp, thickness - level);
    }
    let locked: Vec<usize> = (ids.len()..free.len()).collect();
    let plan = Plan {
        stage: "each recording by itself",
        iterations: MAX_DEVICE_ITERATIONS,
        locked: &locked,
        enough: 1e-4,
    };
    let f1 = begin.parameters[ParameterId::F1];
    let mut best: Option<(f64, Vec<Value>)> = None;
    for factor in START_FREQUENCY_FACTORS {
        if control.cancelled() {
            break;
        }
        if model.uses(ParameterId::F1) {
            begin.parameters.set(ParameterId::F1, factor * f1);
        }
        let prepared = prepare(&begin, &space, one, &summaries, options)?;
        let point = estimate_states(&prepared, &begin, options, control, clock)?;
        let point = improve(&prepared.problem, point, &plan, control, clock)?;
        let (misfit, _) = misfits(&prepared, &point)?;
        // What is set aside does not fit either.
        let off = misfit.chi2 + SET_ASIDE_CHI2 * misfit.set_aside;
        if best.as_ref().is_none_or(|b| off < b.0) {
            let found = uncertainty(model, &prepared, &point, misfit.chi2)?;
            let own = found.parameters.iter().take(ids.len());
            best = Some((off, own.map(|p| (p.value, p.std_error)).collect()));
        }
        if !misfit.is_bad() || !model.uses(ParameterId::F1) {
            break;
        }
    }
    Ok(best.map(|b| b.1).unwrap_or_default())
}

/// The two values that differ most, if any differ.
fn most_different<'a>(all: &[Named<'a>]) -> Option<(Named<'a>, Named<'a>)> {
    let mut out = None;
    let mut most = DEVICE_DIFFERENCE_SIGMAS;
    for (i, a) in all.iter().enumerate() {
        for b in &all[i + 1..] {
            let (x, y) = (a.1, b.1);
            let apart = (x.0 - y.0).abs();
            let errors = apart / x.1.hypot(y.1);
            if errors > most && apart > DEVICE_DIFFERENCE_SHARE * x.0.abs().max(y.0.abs()) {
                most = errors;
                out = Some((*a, *b));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::most_different;

    #[test]
    fn values_differ_if_neither_errors_nor_scales_explain_it() {
        let names =
            |all: &[(&'static str, (f64, f64))]| most_different(all).map(|(a, b)| (a.0, b.0));
        let three = [("a", (58.0, 0.1)), ("b", (48.0, 0.1)), ("c", (57.9, 3.0))];
        assert_eq!(names(&three), Some(("a", "b")));
        assert_eq!(names(&[("a", (58.0, 0.001)), ("b", (58.5, 0.001))]), None);
        assert_eq!(names(&[("a", (58.0, 3.0)), ("b", (48.0, 3.0))]), None);
        assert_eq!(
            names(&[("a", (58.0, 0.1)), ("b", (48.0, f64::INFINITY))]),
            None
        );
        assert_eq!(names(&three[..1]), None);
    }
}
