//! What each parameter changes in the residual of whole runs: the columns of the Jacobian in units of
//! the noise, and how much of the present residual each of them could take away alone.
//!
//! A column is the central difference of the residual itself, with the instrument's zero, clock and
//! scale estimated anew on either side. So what a zero takes up does not count as an influence.

use rayon::prelude::*;

use super::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;
use crate::model::parameter::Scale;

/// Root mean square of the change of the readings for which a difference is taken, in units of the
/// noise: well above the rounding of a run, and small where impacts bend the way.
const TARGET_RMS: f64 = 0.3;
/// A difference is taken as it is if its root mean square is within this factor of the target.
const TARGET_FACTOR: f64 = 10.0;
/// First step of a difference, as a share of the step that columns are stated for.
const FIRST_SHARE: f64 = 0.05;
/// Largest and smallest step of a difference, as shares of the step that columns are stated for.
const STEP_SHARES: (f64, f64) = (1e-5, 3.0);
/// Most differences tried until one is near the target.
const MAX_DIFFERENCES: usize = 3;
/// A parameter that changes the readings by less has no influence: root mean square in units of the
/// noise for the stated step. Differences of runs are not known better.
const NEGLIGIBLE_RMS: f64 = 1e-4;
/// Shares of the way to the linear estimate that are simulated until one is better: impacts bend it.
const WAY_SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
/// Most samples of a recording for which a column is kept, evenly picked.
const MAX_COLUMN_SAMPLES: usize = 4000;

/// A parameter to be looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Its id: `Cs`, `quadratic_drag.cd`.
    pub id: String,
    /// The change of its value that columns are stated for, SI, above 0.
    pub step: f64,
    /// Whether many steps are equal differences, or equal ratios as for one above 0 that spans
    /// decades.
    pub scale: Scale,
    /// Values that it can have, SI, inclusive.
    pub limits: (f64, f64),
}

impl Probe {
    /// The value `steps` away from `value`, within the limits.
    fn moved(&self, value: f64, steps: f64) -> f64 {
        let to = match self.scale {
            Scale::Log if value > 0.0 => value * (steps * self.step / value).exp(),
            _ => value + steps * self.step,
        };
        to.clamp(self.limits.0, self.limits.1)
    }
}

/// The value of a parameter that leaves least, if only this parameter is moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suggestion {
    /// SI.
    pub value: f64,
    /// Sum of squares in units of the noise as simulated with it.
    pub chi2: f64,
    /// Whether it is the linear estimate itself, and not a part of the way there or a limit.
    pub is_linear: bool,
}

/// What one parameter changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Influence {
    /// Its id.
    pub id: String,
    /// Its present value, SI.
    pub value: f64,
    /// The change of its value that the columns are stated for, SI.
    pub step: f64,
    /// For each experiment the change of simulation minus recording, in units of the noise, for
    /// `step`, at [`Sensitivity::times`]; NaN where nothing was compared.
    pub columns: Vec<Vec<f64>>,
    /// Root mean square of the columns over all samples.
    pub rms: f64,
    /// By how much chi2 would fall at the best value of this parameter alone, if all were linear:
    /// `(r j)^2 / (j j)`.
    pub gain: f64,
    /// The change of the parameter in units of `step` that this takes: `-(r j) / (j j)`.
    pub steps_to_best: f64,
    /// A value that was simulated and is better than the present one; `None` if there is none on the
    /// way to the linear estimate.
    pub suggestion: Option<Suggestion>,
}

impl Influence {
    /// The part of the present residual of experiment `i` that this parameter could take away, in
    /// units of the noise, at [`Sensitivity::times`].
    #[must_use]
    pub fn explained(&self, i: usize) -> Vec<f64> {
        let column = self.columns.get(i).map_or(&[][..], Vec::as_slice);
        column.iter().map(|j| -self.steps_to_best * j).collect()
    }
}

/// What all parameters change around one device.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sensitivity {
    /// Sum of squares of the present residual in units of the noise.
    pub chi2: f64,
    /// Number of samples in it.
    pub count: usize,
    /// For each experiment the times of its columns, as aligned \[s\].
    pub times: Vec<Vec<f64>>,
    /// How many samples each sample of a column stands for, for each experiment.
    strides: Vec<usize>,
    /// The parameters that change something, in the order of the probes.
    pub influences: Vec<Influence>,
    /// Ids of those that change nothing that could be seen.
    pub without_influence: Vec<String>,
    /// Ids of those that could not be moved, each with the reason.
    pub failed: Vec<(String, String)>,
}

impl Sensitivity {
    /// The present misfit in units of the noise.
    #[must_use]
    pub fn misfit(&self) -> f64 {
        self.misfit_of(self.chi2)
    }

    /// The misfit in units of the noise for another sum of squares.
    #[must_use]
    pub fn misfit_of(&self, chi2: f64) -> f64 {
        (chi2 / self.count.max(1) as f64).sqrt()
    }

    /// Pairs of parameters, by their places in `influences`, whose columns are alike: the
    /// correlation is above `at_least` in size. It is negative if they act against each other.
    #[must_use]
    pub fn twins(&self, at_least: f64) -> Vec<(usize, usize, f64)> {
        let product = |a: &Influence, b: &Influence| -> f64 {
            let parts = a.columns.iter().zip(&b.columns).zip(&self.strides);
            parts
                .map(|((a, b), stride)| {
                    let terms = a.iter().zip(b).map(|(a, b)| a * b);
                    *stride as f64 * terms.filter(|term| term.is_finite()).sum::<f64>()
                })
                .sum()
        };
        let all = &self.influences;
        let norms: Vec<f64> = all.iter().map(|a| product(a, a).sqrt()).collect();
        let mut found = Vec::new();
        for i in 0..all.len() {
            for k in i + 1..all.len() {
                let correlation = product(&all[i], &all[k]) / (norms[i] * norms[k]);
                if correlation.abs() > at_least {
                    found.push((i, k, correlation));
                }
            }
        }
        found
    }
}

/// The present residuals, in units of the noise, sample by sample of each recording.
struct Present<'a> {
    experiments: &'a [Experiment],
    /// Noise of each experiment on the scale of the comparison \[m\].
    noise: Vec<f64>,
    results: Vec<ExperimentResult>,
}

/// A difference of runs for one step.
struct Difference {
    /// Products of the column with itself and with the residual, for a step of 1 unit of the probe.
    jj: f64,
    rj: f64,
    columns: Vec<Vec<f64>>,
}

impl Present<'_> {
    fn samples(&self, i: usize) -> std::ops::Range<usize> {
        let compared = &self.results[i].proof_mass;
        compared.first..compared.first + compared.residual.len()
    }

    fn stride(&self, i: usize) -> usize {
        self.samples(i).len().div_ceil(MAX_COLUMN_SAMPLES).max(1)
    }

    /// Times of the samples that columns are kept for \[s\].
    fn times(&self, i: usize) -> Vec<f64> {
        let (recording, alignment) = (&self.experiments[i].recording, self.results[i].alignment);
        let picked = self.samples(i).step_by(self.stride(i));
        picked.map(|k| alignment.time(recording.time[k])).collect()
    }

    /// Sum of squares of `results` over the samples that the present residual has, in units of its
    /// noise, and their number.
    fn chi2(&self, results: &[ExperimentResult]) -> (f64, usize) {
        let (mut sum, mut count) = (0.0, 0);
        for (i, result) in results.iter().enumerate() {
            for k in self.samples(i) {
                let r = residual(result, k) / self.noise[i];
                if r.is_finite() && residual(&self.results[i], k).is_finite() {
                    sum += r * r;
                    count += 1;
                }
            }
        }
        (sum, count)
    }

    /// The difference of two runs whose values are `distance` apart, for a change of `step`.
    fn difference(
        &self,
        low: &[ExperimentResult],
        high: &[ExperimentResult],
        step_over_distance: f64,
    ) -> Difference {
        let (mut jj, mut rj) = (0.0, 0.0);
        let mut columns = Vec::with_capacity(self.results.len());
        for i in 0..self.results.len() {
            let (samples, stride) = (self.samples(i), self.stride(i));
            let mut column = Vec::with_capacity(samples.len() / stride + 1);
            for (n, k) in samples.enumerate() {
                let change = residual(&high[i], k) - residual(&low[i], k);
                let j = change * step_over_distance / self.noise[i];
                let r = residual(&self.results[i], k) / self.noise[i];
                if (j * r).is_finite() {
                    jj += j * j;
                    rj += j * r;
                }
                if n % stride == 0 {
                    column.push(j);
                }
            }
            columns.push(column);
        }
        Difference { jj, rj, columns }
    }
}

/// Simulation minus recording of sample `k` of the recording \[m\]; NaN where it was not compared.
fn residual(result: &ExperimentResult, k: usize) -> f64 {
    let compared = &result.proof_mass;
    let place = k.checked_sub(compared.first);
    let value = place.and_then(|n| compared.residual.get(n));
    value.copied().unwrap_or(f64::NAN)
}

/// What became of one parameter.
enum Outcome {
    Influence(Influence),
    Nothing,
    Failed(String),
    Cancelled,
}

/// What each of `probes` changes in the residuals of `experiments` around `model`. `run` simulates
/// the experiment of a place in `experiments` with a device and compares it; `None` from it cancels
/// all. `done` hears after each
/// parameter. Experiments without noise have no unit and must be left out.
///
/// # Errors
/// [`ExperimentError`] if the present device cannot be simulated. A parameter that cannot be moved is
/// in [`Sensitivity::failed`].
pub fn sensitivity<R>(
    model: &Model,
    experiments: &[Experiment],
    probes: &[Probe],
    run: &R,
    done: &(impl Fn() + Sync),
) -> Result<Option<Sensitivity>, ExperimentError>
where
    R: Fn(usize, &Model) -> Result<Option<ExperimentResult>, ExperimentError> + Sync,
{
    let Some(results) = run_all(model, experiments.len(), run)? else {
        return Ok(None);
    };
    let noise = experiments
        .iter()
        .zip(&results)
        .map(|(experiment, result)| experiment.noise.0 * result.alignment.xp_scale.abs());
    let present = Present {
        experiments,
        noise: noise.collect(),
        results,
    };
    let (chi2, count) = present.chi2(&present.results);
    let outcomes: Vec<Outcome> = probes
        .par_iter()
        .map(|probe| {
            let outcome = influence(model, &present, probe, run);
            done();
            outcome
        })
        .collect();
    let all = 0..experiments.len();
    let mut found = Sensitivity {
        chi2,
        count,
        times: all.clone().map(|i| present.times(i)).collect(),
        strides: all.map(|i| present.stride(i)).collect(),
        ..Sensitivity::default()
    };
    for (probe, outcome) in probes.iter().zip(outcomes) {
        match outcome {
            Outcome::Influence(influence) => found.influences.push(influence),
            Outcome::Nothing => found.without_influence.push(probe.id.clone()),
            Outcome::Failed(reason) => found.failed.push((probe.id.clone(), reason)),
            Outcome::Cancelled => return Ok(None),
        }
    }
    Ok(Some(found))
}

fn run_all<R>(
    model: &Model,
    count: usize,
    run: &R,
) -> Result<Option<Vec<ExperimentResult>>, ExperimentError>
where
    R: Fn(usize, &Model) -> Result<Option<ExperimentResult>, ExperimentError>,
{
    let mut results = Vec::with_capacity(count);
    for i in 0..count {
        match run(i, model)? {
            Some(result) => results.push(result),
            None => return Ok(None),
        }
    }
    Ok(Some(results))
}

/// Runs with one parameter at another value: `None` if cancelled, the reason if it cannot be.
fn run_at<R>(
    model: &Model,
    present: &Present<'_>,
    (id, value): (&str, f64),
    run: &R,
) -> Result<Option<Vec<ExperimentResult>>, String>
where
    R: Fn(usize, &Model) -> Result<Option<ExperimentResult>, ExperimentError>,
{
    let mut moved = model.clone();
    moved.set(id, value).map_err(|error| error.to_string())?;
    moved.check().map_err(|error| error.to_string())?;
    run_all(&moved, present.experiments.len(), run).map_err(|error| error.to_string())
}

fn influence<R>(model: &Model, present: &Present<'_>, probe: &Probe, run: &R) -> Outcome
where
    R: Fn(usize, &Model) -> Result<Option<ExperimentResult>, ExperimentError>,
{
    let Some(value) = model.get(&probe.id) else {
        return Outcome::Failed("the device has no such parameter".to_owned());
    };
    let difference = match difference(model, present, (probe, value), run) {
        Ok(Some(difference)) => difference,
        Ok(None) => return Outcome::Cancelled,
        Err(reason) => return Outcome::Failed(reason),
    };
    let Difference { jj, rj, columns } = difference;
    let (chi2, count) = present.chi2(&present.results);
    let rms = (jj / count.max(1) as f64).sqrt();
    if rms < NEGLIGIBLE_RMS || !rms.is_finite() {
        return Outcome::Nothing;
    }
    let steps_to_best = -rj / jj;
    let mut influence = Influence {
        id: probe.id.clone(),
        value,
        step: probe.step,
        columns,
        rms,
        gain: rj * rj / jj,
        steps_to_best,
        suggestion: None,
    };
    let (low, high) = probe.limits;
    for share in WAY_SHARES {
        let tried = probe.moved(value, share * steps_to_best);
        if tried == value {
            break;
        }
        // A value that the device refuses is too far, as is one with which it is worse.
        match run_at(model, present, (probe.id.as_str(), tried), run) {
            Ok(None) => return Outcome::Cancelled,
            Err(_) => {}
            Ok(Some(results)) => {
                let (with, compared) = present.chi2(&results);
                if compared == count && with < chi2 {
                    influence.suggestion = Some(Suggestion {
                        value: tried,
                        chi2: with,
                        is_linear: share == 1.0 && tried > low && tried < high,
                    });
                    break;
                }
            }
        }
    }
    Outcome::Influence(influence)
}

/// The central difference around `value`, one-sided at a limit, with a step by which the readings
/// change by about a third of the noise; `None` if cancelled.
fn difference<R>(
    model: &Model,
    present: &Present<'_>,
    (probe, value): (&Probe, f64),
    run: &R,
) -> Result<Option<Difference>, String>
where
    R: Fn(usize, &Model) -> Result<Option<ExperimentResult>, ExperimentError>,
{
    let (least, most) = (STEP_SHARES.0 * probe.step, STEP_SHARES.1 * probe.step);
    let mut step = FIRST_SHARE * probe.step;
    let mut last = None;
    for _ in 0..MAX_DIFFERENCES {
        let mut sides = Vec::with_capacity(2);
        let mut refused = None;
        for side in [value - step, value + step] {
            let side = side.clamp(probe.limits.0, probe.limits.1);
            if side == value {
                continue;
            }
            match run_at(model, present, (probe.id.as_str(), side), run) {
                Ok(Some(results)) => sides.push((side, results)),
                Ok(None) => return Ok(None),
                Err(reason) => refused = Some(reason),
            }
        }
        let own = || (value, present.results.clone());
        let (a, b) = match (sides.pop(), sides.pop()) {
            (Some(b), Some(a)) => (a, b),
            (Some(only), None) => (own(), only),
            _ => return Err(refused.unwrap_or_else(|| "it cannot be moved".to_owned())),
        };
        let found = present.difference(&a.1, &b.1, probe.step / (b.0 - a.0));
        let (_, count) = present.chi2(&present.results);
        // Of the difference itself, from the middle to one side.
        let rms = (found.jj / count.max(1) as f64).sqrt() * step / probe.step;
        last = Some(found);
        let is_near = (TARGET_RMS / TARGET_FACTOR..=TARGET_RMS * TARGET_FACTOR).contains(&rms);
        let factor = if rms > 0.0 {
            TARGET_RMS / rms
        } else {
            f64::INFINITY
        };
        let better = (step * factor).clamp(least, most);
        if is_near || better == step {
            break;
        }
        step = better;
    }
    Ok(last)
}

#[cfg(test)]
#[path = "sensitivity_tests.rs"]
mod tests;
