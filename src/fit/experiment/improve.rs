//! Numbers that a run depends on, decided by the readings.

use super::instrument::{RunColumn, estimate_with_runs};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;

/// Most rounds of linearized improvement.
const MAX_ROUNDS: usize = 8;
/// Dampings of Levenberg and Marquardt that are tried, in this order: impacts bend the way.
pub const DAMPINGS: [f64; 6] = [0.0, 0.03, 0.3, 3.0, 30.0, 300.0];
/// A fall of the sum of squares by less than this share ends the rounds.
pub const CONVERGED_SHARE: f64 = 1e-4;

/// A number that is open within limits.
#[derive(Debug, Clone, Copy)]
pub struct OpenNumber {
    /// Step for differences.
    pub step: f64,
    /// Standard deviation around 0; infinite for no prior.
    pub sigma: f64,
    /// Farthest from 0.
    pub most: f64,
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

/// Improves `numbers` from `values` on; `at` is the experiment at given values. `None` if `go_on`
/// said no.
///
/// # Errors
/// [`ExperimentError`] if the device cannot be simulated.
pub fn improve(
    at: &impl Fn(&[f64]) -> Experiment,
    numbers: &[OpenNumber],
    values: Vec<f64>,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Improved>, ExperimentError> {
    let experiment = at(&values);
    let Some(result) = experiment.run(model, go_on)? else {
        return Ok(None);
    };
    let mut best = Improved {
        values,
        experiment,
        result,
    };
    for _ in 0..MAX_ROUNDS {
        let mut changed = Vec::with_capacity(numbers.len());
        for (k, number) in numbers.iter().enumerate() {
            // Towards zero, so that limits are not left.
            let step = if number.most.is_finite() && best.values[k] > 0.0 {
                -number.step
            } else {
                number.step
            };
            let mut values = best.values.clone();
            values[k] += step;
            let Some(run) = at(&values).run(model, go_on)? else {
                return Ok(None);
            };
            changed.push((run.trace, step));
        }
        let columns: Vec<RunColumn<'_>> = numbers
            .iter()
            .zip(&changed)
            .zip(&best.values)
            .map(|((number, (trace, step)), value)| RunColumn {
                changed: trace,
                step: *step,
                sigma: number.sigma,
                most: number.most,
                value: *value,
                window: (f64::NEG_INFINITY, f64::INFINITY),
            })
            .collect();
        let before = best.result.sum_of_squares(&best.experiment);
        let Some(better) = damped_step(&columns, &best, at, model, go_on)? else {
            break;
        };
        best = better;
        if best.result.sum_of_squares(&best.experiment) > (1.0 - CONVERGED_SHARE) * before {
            break;
        }
    }
    Ok(go_on().then_some(best))
}

/// The first of ever more damped steps by which the residual falls; `None` if there is none or `go_on`
/// said no.
fn damped_step(
    columns: &[RunColumn<'_>],
    best: &Improved,
    at: &impl Fn(&[f64]) -> Experiment,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Improved>, ExperimentError> {
    let Some(priors) = best.experiment.priors else {
        return Ok(None);
    };
    let before = best.result.sum_of_squares(&best.experiment);
    for damping in DAMPINGS {
        let trace = &best.result.trace;
        let (_, values) = estimate_with_runs(&best.experiment, trace, &priors, columns, damping);
        let experiment = at(&values);
        let Some(result) = experiment.run(model, go_on)? else {
            return Ok(None);
        };
        if result.sum_of_squares(&experiment) < before {
            return Ok(Some(Improved {
                values,
                experiment,
                result,
            }));
        }
    }
    Ok(None)
}
