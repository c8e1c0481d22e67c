//! What the voltage's samples leave open of the drive, decided by the readings.

use std::sync::Arc;

use super::improve::{CONVERGED_SHARE, DAMPINGS};
use super::instrument::{RunColumn, estimate_with_runs};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;
use crate::recording::measured_drive::MeasuredDrive;
use crate::sim::Trace;

/// Most rounds of linearized improvement.
const MAX_ROUNDS: usize = 12;
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
    let mut values = start.to_vec();
    values.resize(measured.freedoms.len(), 0.0);
    let search = Search {
        experiment,
        measured,
        open: (0..measured.freedoms.len())
            .filter(|&k| measured.freedoms[k].sigma > 0.0)
            .collect(),
        model,
        go_on,
    };
    let Some(first) = search.run(values)? else {
        return Ok(None);
    };
    if search.open.is_empty() || experiment.priors.is_none() {
        return Ok(Some(first));
    }
    let Some(best) = search.descend(first)? else {
        return Ok(None);
    };
    let misfit = best.result.misfit(experiment).unwrap_or(f64::INFINITY);
    if !(misfit > FOLLOWED_MISFIT && misfit < NEARLY_FOLLOWED_MISFIT) {
        return Ok(Some(best));
    }
    // An impact that comes in another order can hold the descent just before its end.
    let Some(other) = search.best_aside(&best)? else {
        return Ok(Some(best));
    };
    let Some(other) = search.descend(other)? else {
        return Ok(None);
    };
    let is_better = search.cost(&other) < search.cost(&best);
    Ok(Some(if is_better { other } else { best }))
}

/// A run with some numbers changed.
struct ChangedRun {
    trace: Arc<Trace>,
    /// Which, as positions among the open ones, by how much, and from when to when \[s\] each is what
    /// makes the run differ.
    changes: Vec<(usize, f64, (f64, f64))>,
}

/// What a search for the drive needs. Each of its functions gives `None` if `go_on` said no.
struct Search<'a, F> {
    experiment: &'a Experiment,
    measured: &'a MeasuredDrive,
    /// Indices of the freedoms that are open.
    open: Vec<usize>,
    model: &'a Model,
    go_on: &'a F,
}

impl<F: Fn() -> bool + Sync> Search<'_, F> {
    fn run(&self, values: Vec<f64>) -> Result<Option<ImprovedDrive>, ExperimentError> {
        let (first, _) = self.experiment.recording.span();
        let drive = self.measured.changed(&values);
        let experiment = Experiment {
            drive: drive.waveform(&self.experiment.recording.name, -first),
            ..self.experiment.clone()
        };
        let result = experiment.run(self.model, self.go_on)?;
        Ok(result.map(|result| ImprovedDrive {
            values,
            experiment,
            result,
        }))
    }

    /// Sum of squares of all readings and of what is known beforehand, in units of their errors.
    fn cost(&self, of: &ImprovedDrive) -> f64 {
        let known = self.open.iter().map(|&k| {
            let sigma = self.measured.freedoms[k].sigma;
            (of.values[k] / sigma).powi(2)
        });
        of.result.sum_of_squares(&of.experiment) + known.sum::<f64>()
    }

    /// Rounds of linearized improvement.
    fn descend(&self, start: ImprovedDrive) -> Result<Option<ImprovedDrive>, ExperimentError> {
        let mut best = start;
        for _ in 0..MAX_ROUNDS {
            let Some(runs) = self.changed_runs(&best)? else {
                return Ok(None);
            };
            let columns = self.columns(&best, &runs);
            let before = self.cost(&best);
            let Some(better) = self.damped_step(&columns, &best)? else {
                break;
            };
            let fallen = before - self.cost(&better);
            best = better;
            if fallen < CONVERGED_SHARE * before {
                break;
            }
        }
        Ok((self.go_on)().then_some(best))
    }

    /// The best of the places a standard deviation aside in each number that acts all the time.
    fn best_aside(&self, of: &ImprovedDrive) -> Result<Option<ImprovedDrive>, ExperimentError> {
        let mut best: Option<ImprovedDrive> = None;
        for &k in &self.open {
            let freedom = &self.measured.freedoms[k];
            if freedom.acts_from.is_finite() {
                continue;
            }
            for side in ASIDE_SIGMAS {
                let mut values = of.values.clone();
                values[k] = (values[k] + side * freedom.sigma).clamp(-freedom.most, freedom.most);
                let Some(tried) = self.run(values)? else {
                    return Ok(None);
                };
                let is_better = best.as_ref();
                if is_better.is_none_or(|best| self.cost(&tried) < self.cost(best)) {
                    best = Some(tried);
                }
            }
        }
        Ok(best)
    }

    /// One run for each number that acts all the time, and a few for all that act from an instant on.
    /// `None` if `go_on` said no.
    fn changed_runs(
        &self,
        best: &ImprovedDrive,
    ) -> Result<Option<Vec<ChangedRun>>, ExperimentError> {
        let from = |position: usize| self.measured.freedoms[self.open[position]].acts_from;
        let (local, lasting): (Vec<usize>, Vec<usize>) =
            (0..self.open.len()).partition(|&position| from(position).is_finite());
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
                let k = self.open[position];
                let step = STEP_SHARE * self.measured.freedoms[k].sigma;
                // Towards zero, so that the limits are not left.
                let step = if best.values[k] > 0.0 { -step } else { step };
                values[k] += step;
                changes.push((position, step, window));
            }
            let Some(run) = self.run(values)? else {
                return Ok(None);
            };
            runs.push(ChangedRun {
                trace: run.result.trace,
                changes,
            });
        }
        Ok(Some(runs))
    }

    /// How the readings change with each open number, in their order.
    fn columns<'r>(&self, best: &ImprovedDrive, runs: &'r [ChangedRun]) -> Vec<RunColumn<'r>> {
        let mut all: Vec<(usize, RunColumn<'r>)> = Vec::with_capacity(self.open.len());
        for run in runs {
            for &(position, step, window) in &run.changes {
                let freedom = &self.measured.freedoms[self.open[position]];
                let column = RunColumn {
                    changed: &run.trace,
                    step,
                    sigma: freedom.sigma,
                    most: freedom.most,
                    value: best.values[self.open[position]],
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
        &self,
        columns: &[RunColumn<'_>],
        best: &ImprovedDrive,
    ) -> Result<Option<ImprovedDrive>, ExperimentError> {
        let Some(priors) = best.experiment.priors else {
            return Ok(None);
        };
        let before = self.cost(best);
        for damping in DAMPINGS {
            let trace = &best.result.trace;
            let (_, found) = estimate_with_runs(&best.experiment, trace, &priors, columns, damping);
            let mut values = best.values.clone();
            for (&k, value) in self.open.iter().zip(&found) {
                values[k] = *value;
            }
            let Some(tried) = self.run(values)? else {
                return Ok(None);
            };
            if self.cost(&tried) < before {
                return Ok(Some(tried));
            }
        }
        Ok(None)
    }
}
