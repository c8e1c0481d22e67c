//! Numbers that a run depends on, decided by the readings.

use super::instrument::{RunColumn, estimate_with_runs};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;

/// Most rounds of linearized improvement.
const MAX_ROUNDS: usize = 8;
/// Shares of a step that are tried: impacts bend the way.
const STEP_SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
/// A fall of the residual by less than this share ends the rounds.
const CONVERGED_SHARE: f64 = 1e-4;

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
    let Some(priors) = best.experiment.priors else {
        return Ok(Some(best));
    };
    for _ in 0..MAX_ROUNDS {
        let mut changed = Vec::with_capacity(numbers.len());
        for (k, number) in numbers.iter().enumerate() {
            // Towards zero, so that the limits are not left.
            let step = if best.values[k] > 0.0 {
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
            })
            .collect();
        let trace = &best.result.trace;
        let (_, found) = estimate_with_runs(&best.experiment, trace, &priors, &columns);
        let before = best.result.proof_mass.rms;
        let Some(better) = shorter_steps(&found, &best, at, model, go_on)? else {
            break;
        };
        best = better;
        if best.result.proof_mass.rms > (1.0 - CONVERGED_SHARE) * before {
            break;
        }
    }
    Ok(Some(best))
}

/// The first of ever shorter steps towards `found` by which the residual falls; `None` if there is
/// none or `go_on` said no.
fn shorter_steps(
    found: &[f64],
    best: &Improved,
    at: &impl Fn(&[f64]) -> Experiment,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Improved>, ExperimentError> {
    for share in STEP_SHARES {
        let toward = found.iter().zip(&best.values);
        let values: Vec<f64> = toward
            .map(|(to, from)| from + share * (to - from))
            .collect();
        let experiment = at(&values);
        let Some(result) = experiment.run(model, go_on)? else {
            return Ok(None);
        };
        if result.proof_mass.rms < best.result.proof_mass.rms {
            return Ok(Some(Improved {
                values,
                experiment,
                result,
            }));
        }
    }
    Ok(None)
}
