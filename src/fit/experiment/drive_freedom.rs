//! What the voltage's samples leave open of the drive, decided by the readings.

use std::sync::Arc;

use super::instrument::{RunColumn, estimate_with_runs};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;
use crate::recording::compare::Comparison;
use crate::recording::measured_drive::MeasuredDrive;
use crate::sim::Trace;

/// Most rounds of linearized improvement.
const MAX_ROUNDS: usize = 12;
/// Step of a number for differences, as a share of its standard deviation: far above the
/// simulation's own error, and near enough for impacts to come in the same order.
const STEP_SHARE: f64 = 0.02;
/// Dampings of Levenberg and Marquardt that are tried, in this order: impacts bend the way.
const DAMPINGS: [f64; 6] = [0.0, 0.03, 0.3, 3.0, 30.0, 300.0];
/// A fall of the sum of squares by less than this share ends the rounds.
const CONVERGED_SHARE: f64 = 1e-4;
/// Runs in which numbers that act from an instant on, a turn's, are changed together: every sixth
/// of them. Until the next in the same run, the device has forgotten most of the last.
const RUNS_OF_LOCAL_NUMBERS: usize = 6;

/// An experiment with its drive improved within what the voltage allows.
#[derive(Debug, Clone)]
pub struct ImprovedDrive {
    /// The numbers of [`MeasuredDrive::freedoms`].
    pub values: Vec<f64>,
    /// The experiment under the improved drive.
    pub experiment: Experiment,
    /// Its comparison.
    pub result: ExperimentResult,
}

/// Improves the drive of an experiment, made of `measured`, from `start` on (one number for each
/// freedom, empty for zeros). `None` if `go_on` said no.
///
/// # Errors
/// [`ExperimentError`] if the device cannot be simulated.
pub fn improve_drive(
    experiment: &Experiment,
    measured: &MeasuredDrive,
    model: &Model,
    start: &[f64],
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<ImprovedDrive>, ExperimentError> {
    let (first, _) = experiment.recording.span();
    let under = |values: &[f64]| Experiment {
        drive: measured
            .changed(values)
            .waveform(&experiment.recording.name, -first),
        ..experiment.clone()
    };
    let mut values = start.to_vec();
    values.resize(measured.freedoms.len(), 0.0);
    let own = under(&values);
    let Some(result) = own.run(model, go_on)? else {
        return Ok(None);
    };
    let mut best = ImprovedDrive {
        values,
        experiment: own,
        result,
    };
    let open: Vec<usize> = (0..measured.freedoms.len())
        .filter(|&k| measured.freedoms[k].sigma > 0.0)
        .collect();
    if open.is_empty() || experiment.priors.is_none() {
        return Ok(Some(best));
    }
    for _ in 0..MAX_ROUNDS {
        let Some(runs) = changed_runs(&open, measured, &best, &under, model, go_on)? else {
            return Ok(None);
        };
        let columns = columns(&open, measured, &best, &runs);
        let before = cost(&best, measured);
        let Some(better) = damped_step(&open, &columns, &best, measured, &under, model, go_on)?
        else {
            break;
        };
        let fallen = before - cost(&better, measured);
        best = better;
        if fallen < CONVERGED_SHARE * before {
            break;
        }
    }
    Ok(Some(best))
}

/// Sum of squares of all readings and of what is known beforehand, in units of their errors.
fn cost(of: &ImprovedDrive, measured: &MeasuredDrive) -> f64 {
    let noise = of.experiment.noise;
    let unit = |sigma: f64| if sigma > 0.0 { sigma } else { 1.0 };
    let readings = |c: &Comparison, sigma: f64| c.count as f64 * (c.rms / unit(sigma)).powi(2);
    let proof_mass = readings(&of.result.proof_mass, noise.0);
    let cantilever = of.result.cantilever.as_ref().zip(noise.1);
    let known = of.values.iter().zip(&measured.freedoms);
    proof_mass
        + cantilever.map_or(0.0, |(c, sigma)| readings(c, sigma))
        + known
            .filter(|(_, freedom)| freedom.sigma > 0.0)
            .map(|(value, freedom)| (value / freedom.sigma).powi(2))
            .sum::<f64>()
}

/// A run with some numbers changed.
struct ChangedRun {
    trace: Arc<Trace>,
    /// Which, as positions among the open ones, by how much, and from when to when \[s\] each is what
    /// makes the run differ.
    changes: Vec<(usize, f64, (f64, f64))>,
}

/// One run for each number that acts all the time, and a few for all that act from an instant on.
/// `None` if `go_on` said no.
fn changed_runs(
    open: &[usize],
    measured: &MeasuredDrive,
    best: &ImprovedDrive,
    under: &impl Fn(&[f64]) -> Experiment,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Vec<ChangedRun>>, ExperimentError> {
    let from = |position: usize| measured.freedoms[open[position]].acts_from;
    let (local, lasting): (Vec<usize>, Vec<usize>) =
        (0..open.len()).partition(|&position| from(position).is_finite());
    let all_time = (f64::NEG_INFINITY, f64::INFINITY);
    let mut groups: Vec<Vec<(usize, (f64, f64))>> =
        lasting.into_iter().map(|p| vec![(p, all_time)]).collect();
    for group in 0..RUNS_OF_LOCAL_NUMBERS.min(local.len()) {
        let own: Vec<usize> = local
            .iter()
            .copied()
            .skip(group)
            .step_by(RUNS_OF_LOCAL_NUMBERS)
            .collect();
        let ends = own.iter().skip(1).map(|&p| from(p)).chain([f64::INFINITY]);
        let windows = own.iter().zip(ends).map(|(&p, end)| (p, (from(p), end)));
        groups.push(windows.collect());
    }
    let mut runs = Vec::with_capacity(groups.len());
    for group in groups {
        let mut values = best.values.clone();
        let mut changes = Vec::with_capacity(group.len());
        for (position, window) in group {
            let k = open[position];
            let step = STEP_SHARE * measured.freedoms[k].sigma;
            // Towards zero, so that the limits are not left.
            let step = if best.values[k] > 0.0 { -step } else { step };
            values[k] += step;
            changes.push((position, step, window));
        }
        let Some(run) = under(&values).run(model, go_on)? else {
            return Ok(None);
        };
        runs.push(ChangedRun {
            trace: run.trace,
            changes,
        });
    }
    Ok(Some(runs))
}

/// How the readings change with each open number, in their order.
fn columns<'a>(
    open: &[usize],
    measured: &MeasuredDrive,
    best: &ImprovedDrive,
    runs: &'a [ChangedRun],
) -> Vec<RunColumn<'a>> {
    let mut all: Vec<(usize, RunColumn<'a>)> = Vec::with_capacity(open.len());
    for run in runs {
        for &(position, step, window) in &run.changes {
            let freedom = &measured.freedoms[open[position]];
            let column = RunColumn {
                changed: &run.trace,
                step,
                sigma: freedom.sigma,
                most: freedom.most,
                value: best.values[open[position]],
                window,
            };
            all.push((position, column));
        }
    }
    all.sort_by_key(|column| column.0);
    all.into_iter().map(|column| column.1).collect()
}

/// The first of ever more damped steps by which the sum of squares falls; `None` if there is none or
/// `go_on` said no.
fn damped_step(
    open: &[usize],
    columns: &[RunColumn<'_>],
    best: &ImprovedDrive,
    measured: &MeasuredDrive,
    under: &impl Fn(&[f64]) -> Experiment,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<ImprovedDrive>, ExperimentError> {
    let Some(priors) = best.experiment.priors else {
        return Ok(None);
    };
    let before = cost(best, measured);
    for damping in DAMPINGS {
        let trace = &best.result.trace;
        let (_, found) = estimate_with_runs(&best.experiment, trace, &priors, columns, damping);
        let mut values = best.values.clone();
        for (&k, value) in open.iter().zip(&found) {
            values[k] = *value;
        }
        let experiment = under(&values);
        let Some(result) = experiment.run(model, go_on)? else {
            return Ok(None);
        };
        let tried = ImprovedDrive {
            values,
            experiment,
            result,
        };
        if cost(&tried, measured) < before {
            return Ok(Some(tried));
        }
    }
    Ok(None)
}
