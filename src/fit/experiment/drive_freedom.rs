//! What the voltage's samples leave open of the drive, decided by the readings.

use super::improve::{Improved, OpenNumber, Search};
use super::{Experiment, ExperimentError};
use crate::model::Model;
use crate::recording::measured_drive::MeasuredDrive;

/// Step of a number for differences, as a share of its standard deviation: far above the
/// simulation's own error, and near enough for impacts to come in the same order.
const STEP_SHARE: f64 = 0.02;
/// Residual in units of the noise up to which the readings are followed.
const FOLLOWED_MISFIT: f64 = 1.05;
/// The same up to which the voltage's own error may be all that is left: a wrong device leaves more,
/// and no other place is looked at.
const NEARLY_FOLLOWED_MISFIT: f64 = 10.0;
/// Standard deviations aside from where the descent ended, for another start.
const ASIDE_SIGMAS: [f64; 4] = [-1.0, -0.4, 0.4, 1.0];

/// Improves the drive of an experiment, made of `measured`, from `start` on (one number for each
/// freedom, empty for zeros); the improved numbers are those of all freedoms. `None` if `go_on` said
/// no.
///
/// # Errors
/// [`ExperimentError`] if the device cannot be simulated.
pub fn improve_drive(
    experiment: &Experiment,
    measured: &MeasuredDrive,
    model: &Model,
    start: &[f64],
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Improved>, ExperimentError> {
    let mut all = start.to_vec();
    all.resize(measured.freedoms.len(), 0.0);
    let open: Vec<usize> = (0..all.len())
        .filter(|&k| measured.freedoms[k].sigma > 0.0)
        .collect();
    let with = |values: &[f64]| {
        let mut all = all.clone();
        for (&k, value) in open.iter().zip(values) {
            all[k] = *value;
        }
        all
    };
    let (first, _) = experiment.recording.span();
    let number = |&k: &usize| {
        let freedom = &measured.freedoms[k];
        OpenNumber {
            step: STEP_SHARE * freedom.sigma,
            sigma: freedom.sigma,
            most: freedom.most,
            acts_from: freedom.acts_from,
        }
    };
    let search = Search {
        at: |values: &[f64]| {
            let drive = measured.changed(&with(values));
            Experiment {
                drive: drive.waveform(&experiment.recording.name, -first),
                ..experiment.clone()
            }
        },
        numbers: open.iter().map(number).collect(),
        model,
        go_on,
    };
    let Some(begun) = search.run(open.iter().map(|&k| all[k]).collect())? else {
        return Ok(None);
    };
    let found = if open.is_empty() || experiment.priors.is_none() {
        begun
    } else {
        match improved_twice(&search, begun)? {
            Some(found) => found,
            None => return Ok(None),
        }
    };
    Ok(Some(Improved {
        values: with(&found.values),
        ..found
    }))
}

/// A descent, and a second one from aside where the first ends near the noise but not at it. `None` if
/// the search was to end.
fn improved_twice<A: Fn(&[f64]) -> Experiment, F: Fn() -> bool + Sync>(
    search: &Search<'_, A, F>,
    begun: Improved,
) -> Result<Option<Improved>, ExperimentError> {
    let Some(best) = search.descend(begun)? else {
        return Ok(None);
    };
    let misfit = best.result.misfit(&best.experiment);
    let misfit = misfit.unwrap_or(f64::INFINITY);
    if !(misfit > FOLLOWED_MISFIT && misfit < NEARLY_FOLLOWED_MISFIT) {
        return Ok(Some(best));
    }
    // An impact that comes in another order can hold the descent just before its end.
    let Some(other) = best_aside(search, &best)? else {
        return Ok(Some(best));
    };
    let Some(other) = search.descend(other)? else {
        return Ok(None);
    };
    let is_better = search.cost(&other) < search.cost(&best);
    Ok(Some(if is_better { other } else { best }))
}

/// The best of the places a standard deviation aside in each number that acts all the time; `None` if
/// there is none or the search was to end.
fn best_aside<A: Fn(&[f64]) -> Experiment, F: Fn() -> bool + Sync>(
    search: &Search<'_, A, F>,
    of: &Improved,
) -> Result<Option<Improved>, ExperimentError> {
    let mut best: Option<Improved> = None;
    for (k, number) in search.numbers.iter().enumerate() {
        if number.acts_from.is_finite() {
            continue;
        }
        for side in ASIDE_SIGMAS {
            let mut values = of.values.clone();
            values[k] = (values[k] + side * number.sigma).clamp(-number.most, number.most);
            let Some(tried) = search.run(values)? else {
                return Ok(None);
            };
            let is_better = best.as_ref();
            if is_better.is_none_or(|best| search.cost(&tried) < search.cost(best)) {
                best = Some(tried);
            }
        }
    }
    Ok(best)
}
