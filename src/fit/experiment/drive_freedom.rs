//! What the voltage's samples leave open of the drive, decided by the readings.

use super::instrument::{RunColumn, estimate_with_runs};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;
use crate::recording::measured_drive::MeasuredDrive;

/// Most rounds of linearized improvement.
const MAX_ROUNDS: usize = 8;
/// Step of a number for differences, as a share of its standard deviation.
const STEP_SHARE: f64 = 0.02;
/// Shares of a step that are tried: impacts bend the way.
const STEP_SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
/// A fall of the residual by less than this share ends the rounds.
const CONVERGED_SHARE: f64 = 1e-4;

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
    let Some(priors) = experiment.priors else {
        return Ok(Some(best));
    };
    let open: Vec<usize> = (0..measured.freedoms.len())
        .filter(|&k| measured.freedoms[k].sigma > 0.0)
        .collect();
    if open.is_empty() {
        return Ok(Some(best));
    }
    for _ in 0..MAX_ROUNDS {
        let mut changed = Vec::with_capacity(open.len());
        for &k in &open {
            let freedom = &measured.freedoms[k];
            let step = STEP_SHARE * freedom.sigma;
            // Towards zero, so that the limits are not left.
            let step = if best.values[k] > 0.0 { -step } else { step };
            let mut values = best.values.clone();
            values[k] += step;
            let Some(run) = under(&values).run(model, go_on)? else {
                return Ok(None);
            };
            changed.push((run.trace, step));
        }
        let columns: Vec<RunColumn<'_>> = open
            .iter()
            .zip(&changed)
            .map(|(&k, (trace, step))| RunColumn {
                changed: trace,
                step: *step,
                sigma: measured.freedoms[k].sigma,
                most: measured.freedoms[k].most,
                value: best.values[k],
            })
            .collect();
        let (_, found) = estimate_with_runs(experiment, &best.result.trace, &priors, &columns);
        let before = best.result.proof_mass.rms;
        let Some(better) = shorter_steps(&open, &found, &best, under, model, go_on)? else {
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
    open: &[usize],
    found: &[f64],
    best: &ImprovedDrive,
    under: impl Fn(&[f64]) -> Experiment,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<ImprovedDrive>, ExperimentError> {
    for share in STEP_SHARES {
        let mut values = best.values.clone();
        for (&k, value) in open.iter().zip(found) {
            values[k] += share * (value - values[k]);
        }
        let experiment = under(&values);
        let Some(result) = experiment.run(model, go_on)? else {
            return Ok(None);
        };
        if result.proof_mass.rms < best.result.proof_mass.rms {
            return Ok(Some(ImprovedDrive {
                values,
                experiment,
                result,
            }));
        }
    }
    Ok(None)
}
