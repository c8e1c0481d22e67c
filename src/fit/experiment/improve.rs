//! Numbers that a run depends on, decided by the readings: Levenberg and Marquardt on whole runs.

use std::sync::Arc;

use super::instrument::{RunColumn, estimate_with_runs};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;
use crate::sim::Trace;

/// Most rounds of linearized improvement.
const MAX_ROUNDS: usize = 12;
/// Dampings that are tried, in this order: impacts bend the way.
const DAMPINGS: [f64; 6] = [0.0, 0.03, 0.3, 3.0, 30.0, 300.0];
/// A fall of the sum of squares by less than this share ends the rounds.
const CONVERGED_SHARE: f64 = 1e-4;
/// Runs in which numbers that act from an instant on are changed together: every sixth of them. Until
/// the next in the same run, the device has forgotten most of the last.
const RUNS_OF_LOCAL_NUMBERS: usize = 6;

/// A number that is open within limits.
#[derive(Debug, Clone, Copy)]
pub struct OpenNumber {
    /// Step for differences.
    pub step: f64,
    /// Standard deviation around 0; infinite for no prior.
    pub sigma: f64,
    /// Farthest from 0.
    pub most: f64,
    /// From when on it acts \[s\]; minus infinity for all the time.
    pub acts_from: f64,
}

/// An experiment with its numbers improved.
#[derive(Debug, Clone)]
pub struct Improved {
    /// The numbers.
    pub values: Vec<f64>,
    /// The experiment at them.
    pub experiment: Experiment,
    /// Its comparison.
    pub result: ExperimentResult,
}

/// A run with some numbers changed.
struct ChangedRun {
    trace: Arc<Trace>,
    /// Which, by how much, and from when to when \[s\] each is what makes the run differ.
    changes: Vec<(usize, f64, (f64, f64))>,
}

/// A search for numbers. Each of its functions gives `None` if `go_on` said no.
pub struct Search<'a, A, F> {
    /// The experiment at given values of the numbers.
    pub at: A,
    /// What is open.
    pub numbers: Vec<OpenNumber>,
    /// The device.
    pub model: &'a Model,
    /// Asked whether to go on.
    pub go_on: &'a F,
}

impl<A: Fn(&[f64]) -> Experiment, F: Fn() -> bool + Sync> Search<'_, A, F> {
    /// The experiment at `values`, simulated.
    ///
    /// # Errors
    /// [`ExperimentError`] if the device cannot be simulated.
    pub fn run(&self, values: Vec<f64>) -> Result<Option<Improved>, ExperimentError> {
        let experiment = (self.at)(&values);
        let result = experiment.run(self.model, self.go_on)?;
        Ok(result.map(|result| Improved {
            values,
            experiment,
            result,
        }))
    }

    /// Sum of squares of all readings and of what is known beforehand, in units of their errors.
    pub fn cost(&self, of: &Improved) -> f64 {
        let known = self.numbers.iter().zip(&of.values);
        let known: f64 = known.map(|(n, value)| (value / n.sigma).powi(2)).sum();
        of.result.sum_of_squares(&of.experiment) + known
    }

    /// Rounds of linearized improvement.
    ///
    /// # Errors
    /// [`ExperimentError`] if the device cannot be simulated.
    pub fn descend(&self, start: Improved) -> Result<Option<Improved>, ExperimentError> {
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

    /// One run for each number that acts all the time, and a few for all that act from an instant on.
    fn changed_runs(&self, best: &Improved) -> Result<Option<Vec<ChangedRun>>, ExperimentError> {
        let from = |k: usize| self.numbers[k].acts_from;
        let (local, lasting): (Vec<usize>, Vec<usize>) =
            (0..self.numbers.len()).partition(|&k| from(k).is_finite());
        let all_time = (f64::NEG_INFINITY, f64::INFINITY);
        let mut groups: Vec<Vec<(usize, (f64, f64))>> =
            lasting.into_iter().map(|k| vec![(k, all_time)]).collect();
        for group in 0..RUNS_OF_LOCAL_NUMBERS.min(local.len()) {
            let own: Vec<usize> = local
                .iter()
                .copied()
                .skip(group)
                .step_by(RUNS_OF_LOCAL_NUMBERS)
                .collect();
            let ends = own.iter().skip(1).map(|&k| from(k)).chain([f64::INFINITY]);
            let windows = own.iter().zip(ends).map(|(&k, end)| (k, (from(k), end)));
            groups.push(windows.collect());
        }
        let mut runs = Vec::with_capacity(groups.len());
        for group in groups {
            let mut values = best.values.clone();
            let mut changes = Vec::with_capacity(group.len());
            for (k, window) in group {
                let number = &self.numbers[k];
                // Towards zero, so that limits are not left.
                let inwards = number.most.is_finite() && best.values[k] > 0.0;
                let step = if inwards { -number.step } else { number.step };
                values[k] += step;
                changes.push((k, step, window));
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

    /// How the readings change with each number, in their order.
    fn columns<'r>(&self, best: &Improved, runs: &'r [ChangedRun]) -> Vec<RunColumn<'r>> {
        let mut all: Vec<(usize, RunColumn<'r>)> = Vec::with_capacity(self.numbers.len());
        for run in runs {
            for &(k, step, window) in &run.changes {
                let column = RunColumn {
                    changed: &run.trace,
                    step,
                    sigma: self.numbers[k].sigma,
                    most: self.numbers[k].most,
                    value: best.values[k],
                    window,
                };
                all.push((k, column));
            }
        }
        all.sort_by_key(|column| column.0);
        all.into_iter().map(|column| column.1).collect()
    }

    /// The first of ever more damped steps by which the sum of squares falls; `None` if there is none
    /// or `go_on` said no.
    fn damped_step(
        &self,
        columns: &[RunColumn<'_>],
        best: &Improved,
    ) -> Result<Option<Improved>, ExperimentError> {
        let Some(priors) = best.experiment.priors else {
            return Ok(None);
        };
        let before = self.cost(best);
        for damping in DAMPINGS {
            let trace = &best.result.trace;
            let (_, values) =
                estimate_with_runs(&best.experiment, trace, &priors, columns, damping);
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
