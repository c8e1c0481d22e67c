//! The result of a fit: values with standard errors, correlations, Fisher eigenvalues, misfits.
//!
//! Errors come from the inverse of `J^T W J` (normal equations), scaled by chi2 where that is
//! above 1 and widened by the sandwich covariance (`sandwich_covariance`).

use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::normal_inverse::inverse;
use super::sandwich_covariance::{sandwich_inflation, segment_gradients, with_observed_curvature};
use super::stored_matrix;
use crate::fit::error::FitError;
use crate::fit::problem::prepare::Prepared;
use crate::fit::problem::prior_rows::known_row;
use crate::fit::recipes::recording_for;
use crate::fit::residual::residual_rows::Row;
use crate::fit::solve::normal_equations::{add_row, normal_equations};
use crate::fit::solve::point::{Point, residuals_at, threshold};
use crate::fit::thresholds::{
    BAD_FIT_CHI2, EXTREME_CORRELATION, MAX_FOLLOWED_NOISE_RATIO, MAX_SET_ASIDE_SHARE,
    UNDETERMINED_RANGES, UNUSABLE_SHARE, VAGUE_ERROR_SHARE,
};
use crate::model::Model;
use crate::model::parameter::Scale;
use crate::model::unit::{format_number, format_quantity};
use crate::sim::SimError;
use crate::static_text::{self, StaticText};

/// One fitted parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedParameter {
    /// Id.
    pub id: String,
    /// Value, SI.
    pub value: f64,
    /// Standard error, SI; infinite if the recordings do not determine the parameter.
    pub std_error: f64,
    /// SI unit.
    #[serde(deserialize_with = "static_text::one")]
    pub unit: StaticText,
    /// Value before the fit.
    pub start: f64,
    /// Whether it is at a bound.
    pub at_bound: bool,
}

/// Misfit of one recording, or of all together.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Misfit {
    /// Name of the recording, or empty for all together.
    pub name: String,
    /// Root mean square of (simulation - recording) of the proof mass \[m\].
    pub rms: f64,
    /// Standard deviation of the noise of the proof mass \[m\].
    pub noise: f64,
    /// Mean square of all residuals in units of their noise, corrected for the unknowns.
    pub chi2: f64,
    /// Samples of the proof mass compared.
    pub samples: usize,
    /// Share of the samples in segments that do not come down to the noise, or that cannot be
    /// simulated. The parameters are fitted without either; `rms` includes the former.
    pub set_aside: f64,
    /// Share of `chi2` from the laws of touch, bounce and release.
    pub at_ground: f64,
}

impl Misfit {
    /// Whether the misfit is clearly more than noise, in what was fitted or in most of what was set
    /// aside.
    #[must_use]
    pub fn is_bad(&self) -> bool {
        self.chi2 > BAD_FIT_CHI2
            || (self.set_aside > MAX_SET_ASIDE_SHARE && self.rms > BAD_FIT_CHI2 * self.noise)
    }
}

/// The result of a fit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FitResult {
    /// The model with the fitted values.
    pub model: Model,
    /// The fitted parameters.
    pub parameters: Vec<FittedParameter>,
    /// Correlations of their values, in the same order.
    #[serde(with = "stored_matrix")]
    pub correlations: DMatrix<f64>,
    /// Eigenvalues of the Fisher matrix of relative changes, largest first.
    pub fisher_values: Vec<f64>,
    /// Its eigenvectors, one a column.
    #[serde(with = "stored_matrix")]
    pub fisher_vectors: DMatrix<f64>,
    /// Sentences on what the recordings do not determine.
    pub remarks: Vec<String>,
    /// All recordings fitted to, together and one by one.
    pub train: (Misfit, Vec<Misfit>),
    /// The held-out recordings, together and one by one; `None` without any.
    pub held_out: Option<(Misfit, Vec<Misfit>)>,
    /// Whether it was cancelled.
    pub cancelled: bool,
}

/// Values with standard errors, correlations and Fisher eigenvalues at `point`.
///
/// # Errors
/// [`FitError`] if the model makes no sense at the point.
pub(crate) fn uncertainty(
    start: &Model,
    prepared: &Prepared,
    point: &Point,
    chi2: f64,
) -> Result<FitResult, FitError> {
    let problem = &prepared.problem;
    let space = &problem.space;
    let n = space.len();
    let huber = threshold(problem, point)?;
    let reduced = problem.linearize(&point.x, &point.segments, &point.used, huber, &[])?;
    let (mut normal, mut gradient) = normal_equations(problem, &point.x, &reduced, huber);
    // The misfit widens what the recordings tell, not what is known beforehand.
    for known in &problem.known {
        let row = known_row(space, known, &point.x);
        add_row(&mut normal, &mut gradient, &row, chi2.max(1.0) - 1.0);
    }
    let linearized = inverse(&normal);
    let wider = sandwich_inflation(&linearized, segment_gradients(&reduced), chi2);
    let covariance = with_observed_curvature(problem, point, huber, linearized * chi2.max(1.0))?;
    let covariance = DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        covariance[(i, j)] * wider[i] * wider[j]
    });
    let slopes = space.slopes(&point.x);
    let own = covariance.view((0, 0), (n, n)).into_owned();
    let values = space.values(&point.x);
    let of_values = &slopes * own * slopes.transpose();
    // NaN means that nothing is known; it must not become an error of zero.
    let error = |variance: f64| match variance.is_nan() {
        true => f64::INFINITY,
        false => variance.max(0.0).sqrt(),
    };
    let errors: Vec<f64> = (0..n).map(|i| error(of_values[(i, i)])).collect();
    let correlations = DMatrix::from_fn(n, n, |i, j| {
        let scale = errors[i] * errors[j];
        if i == j {
            1.0
        } else if scale > 0.0 && scale.is_finite() {
            (of_values[(i, j)] / scale).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    });
    let parameters: Vec<FittedParameter> = (0..n)
        .map(|i| {
            let entry = &space.entries[i];
            let near = 1e-9 * (1.0 + point.x[i].abs());
            let range = entry.spec.range.1 - entry.spec.range.0;
            let determined = errors[i] < UNDETERMINED_RANGES * range.max(values[i].abs());
            FittedParameter {
                id: entry.id.clone(),
                value: values[i],
                std_error: if determined { errors[i] } else { f64::INFINITY },
                unit: entry.spec.unit,
                start: start.get(&entry.id).unwrap_or(f64::NAN),
                at_bound: point.x[i] <= entry.low + near || point.x[i] >= entry.high - near,
            }
        })
        .collect();
    // Relative changes if a ratio is meaningful, otherwise shares of the range.
    let units: Vec<f64> = (0..n)
        .map(|i| {
            let spec = &space.entries[i].spec;
            match spec.scale {
                Scale::Log if values[i] != 0.0 => values[i].abs(),
                _ if values[i].abs() > 1e-3 * (spec.range.1 - spec.range.0) => values[i].abs(),
                _ => spec.range.1 - spec.range.0,
            }
        })
        .collect();
    let relative = DMatrix::from_fn(n, n, |i, j| of_values[(i, j)] / (units[i] * units[j]));
    let (fisher_values, fisher_vectors) = fisher(relative);
    // Whether a parameter has any effect, if the others stay where they are.
    let range = |i: usize| space.entries[i].high - space.entries[i].low;
    let bears: Vec<bool> = (0..n)
        .map(|i| normal[(i, i)] * range(i) * range(i) >= 1.0)
        .collect();
    let remarks = remarks(&parameters, &correlations, &units, &bears);
    Ok(FitResult {
        model: space.model(&point.x),
        parameters,
        correlations,
        fisher_values,
        fisher_vectors,
        remarks,
        train: Default::default(),
        held_out: None,
        cancelled: false,
    })
}

/// Eigenvalues of the inverse of a covariance, largest first, and its eigenvectors, one a column. Both
/// are empty without parameters.
fn fisher(covariance: DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let n = covariance.nrows();
    if n == 0 {
        return (Vec::new(), covariance);
    }
    let eigen = SymmetricEigen::new(covariance);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let values = order
        .iter()
        .map(|&i| 1.0 / eigen.eigenvalues[i].max(1e-300))
        .collect();
    let vectors = DMatrix::from_fn(n, n, |i, j| eigen.eigenvectors[(i, order[j])]);
    (values, vectors)
}

fn remarks(
    parameters: &[FittedParameter],
    correlations: &DMatrix<f64>,
    units: &[f64],
    bears: &[bool],
) -> Vec<String> {
    let mut out = Vec::new();
    for (i, p) in parameters.iter().enumerate() {
        if p.at_bound {
            out.push(format!(
                "{} is at its bound {}: the best value lies beyond it",
                p.id,
                format_quantity(p.value, p.unit, 4)
            ));
        } else if p.std_error.is_infinite() {
            let why = if bears[i] {
                "other parameters compensate any change of it"
            } else {
                "no event that was found depends on it"
            };
            let record = recording_for(&p.id);
            let record = record.map_or(String::new(), |text| {
                format!("; to determine it record {text}")
            });
            out.push(format!(
                "{} is not determined by these recordings: {why}{record}",
                p.id
            ));
        } else if p.std_error > VAGUE_ERROR_SHARE * units[i] {
            out.push(format!(
                "{} is hardly determined by these recordings: {} +- {}",
                p.id,
                format_quantity(p.value, p.unit, 3),
                format_quantity(p.std_error, p.unit, 2)
            ));
        }
    }
    for i in 0..parameters.len() {
        for j in i + 1..parameters.len() {
            let r = correlations[(i, j)];
            if r.abs() > EXTREME_CORRELATION {
                out.push(format!(
                    "{} and {} cannot be distinguished by these recordings (correlation {r:+.3})",
                    parameters[i].id, parameters[j].id
                ));
            }
        }
    }
    out
}

/// Sentences on the recordings that do not fit.
pub(crate) fn misfit_remarks(each: &[Misfit]) -> Vec<String> {
    each.iter()
        .filter(|m| m.is_bad())
        .map(|m| {
            if m.chi2 <= BAD_FIT_CHI2 && m.set_aside < UNUSABLE_SHARE {
                return format!(
                    "{:.0} % of {} could not be followed from event to event and was not used; the rest fits. A possible reason is impacts that follow each other too fast for the noise. If the recording itself looks unlike the simulation, it is of another device or the model lacks something",
                    100.0 * m.set_aside,
                    m.name
                );
            }
            let readings = m.chi2 * (1.0 - m.at_ground);
            if readings <= BAD_FIT_CHI2 && m.set_aside <= MAX_SET_ASIDE_SHARE && m.rms < MAX_FOLLOWED_NOISE_RATIO * m.noise {
                return format!(
                    "{} is followed to the noise, but its bounces and releases do not obey the model's laws of the ground (chi2 {}). If a release falls on a jump of the drive, it does not determine the adhesion; otherwise run a diagnosis to find what is missing",
                    m.name,
                    format_number(m.chi2, 3)
                );
            }
            format!(
                "{} does not fit (rms {} against noise {}, chi2 {}, {:.0} % set aside). It is of another device, the model lacks something, or impacts follow each other too fast. Values and errors then mean little; run a diagnosis to find what is missing",
                m.name,
                format_quantity(m.rms, "m", 3),
                format_quantity(m.noise, "m", 3),
                format_number(m.chi2, 3),
                100.0 * m.set_aside
            )
        })
        .collect()
}

/// Misfits at a point: all recordings together, and each.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub(crate) fn misfits(
    prepared: &Prepared,
    point: &Point,
) -> Result<(Misfit, Vec<Misfit>), SimError> {
    let problem = &prepared.problem;
    let all = residuals_at(problem, point, |_, _| true)?;
    let sums: Vec<Sums> = point
        .segments
        .iter()
        .zip(all)
        .enumerate()
        .map(|(i, (segment, r))| {
            let mut sums = Sums {
                unknowns: segment.locals.len(),
                ..Sums::default()
            };
            let sigma = problem.data[segment.recording].sigmas.xp;
            let Some(r) = r else {
                let rows = problem.rows(segment);
                let lost = rows.iter().filter(|row| **row == Row::ProofMass).count();
                return Sums {
                    lost,
                    ..Sums::default()
                };
            };
            for (row, r) in problem.rows(segment).iter().zip(&r) {
                if *row == Row::ProofMass {
                    sums.square += r * r * sigma * sigma;
                    sums.samples += 1;
                }
                if point.used[i] {
                    sums.chi2 += r * r;
                    sums.rows += 1;
                    if matches!(row, Row::Height | Row::Velocity | Row::Force) {
                        sums.ground += r * r;
                    }
                }
            }
            if !point.used[i] {
                sums.aside = sums.samples;
                sums.unknowns = 0;
            }
            sums
        })
        .collect();
    let of = |name: &str, pick: &dyn Fn(usize) -> bool| {
        let mut total = Sums::default();
        let mut noise = 0.0;
        for (sums, segment) in sums.iter().zip(&point.segments) {
            if pick(segment.recording) {
                total.add(sums);
                let sigma = problem.data[segment.recording].sigmas.xp;
                noise += sigma * sigma * sums.samples as f64;
            }
        }
        let samples = total.samples.max(1) as f64;
        let freedom = total.rows.saturating_sub(total.unknowns).max(1) as f64;
        Misfit {
            name: name.to_owned(),
            rms: (total.square / samples).sqrt(),
            noise: (noise / samples).sqrt(),
            chi2: total.chi2 / freedom,
            samples: total.samples,
            set_aside: (total.aside + total.lost) as f64
                / (total.samples + total.lost).max(1) as f64,
            at_ground: total.ground / total.chi2.max(f64::MIN_POSITIVE),
        }
    };
    let each = problem.data.iter().enumerate();
    let each = each
        .map(|(k, d)| of(&d.recording.name, &|r| r == k))
        .collect();
    Ok((of("", &|_| true), each))
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    square: f64,
    samples: usize,
    chi2: f64,
    /// Part of `chi2` from the laws of the ground.
    ground: f64,
    rows: usize,
    unknowns: usize,
    aside: usize,
    /// Samples in segments that cannot be simulated.
    lost: usize,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.square += other.square;
        self.samples += other.samples;
        self.chi2 += other.chi2;
        self.ground += other.ground;
        self.rows += other.rows;
        self.unknowns += other.unknowns;
        self.aside += other.aside;
        self.lost += other.lost;
    }
}

#[cfg(test)]
#[path = "fit_result_tests.rs"]
mod tests;
