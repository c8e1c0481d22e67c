//! Devices drawn from what is known of the coefficients.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::error::RobustnessError;
use crate::explore::map::Axis;
use crate::model::Model;
use crate::model::drive::Waveform;

/// Most members; each costs a steady state a point.
const MOST_MEMBERS: usize = 100_000;
/// Standard deviation of a uniform number of width 1 is one over this.
const UNIFORM_DEVIATIONS: f64 = 3.464_101_615_137_754_6;
/// A correlation matrix may be so far from having no negative eigenvalue: it was rounded.
const ROUNDED_PIVOT: f64 = 1e-6;

/// A coefficient between two bounds, all values equally likely.
#[derive(Debug, Clone, PartialEq)]
pub struct CoefficientRange {
    /// Id: `Cs`, `effect.parameter`.
    pub id: String,
    /// Lower bound \[SI\], or as a factor.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Whether the bounds are factors on the value that the device has at a point.
    pub is_relative: bool,
    /// Whether equal ratios are equally likely, in place of equal differences.
    pub is_logarithmic: bool,
}

impl CoefficientRange {
    /// Factors on the device's value, equal ratios equally likely.
    #[must_use]
    pub fn relative(id: impl Into<String>, low: f64, high: f64) -> Self {
        Self {
            id: id.into(),
            low,
            high,
            is_relative: true,
            is_logarithmic: true,
        }
    }
}

/// Coefficients as a fit leaves them: jointly normal.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalSpread {
    /// Ids.
    pub ids: Vec<String>,
    /// Most likely values \[SI\].
    pub means: Vec<f64>,
    /// Standard errors \[SI\].
    pub std_errors: Vec<f64>,
    /// Correlations, a row for each; 1 on the diagonal.
    pub correlation: Vec<Vec<f64>>,
}

/// What is known of the coefficients.
#[derive(Debug, Clone, PartialEq)]
pub enum Spread {
    /// Independent ranges. They are filled evenly (Latin hypercube).
    Ranges(Vec<CoefficientRange>),
    /// The normal distribution of a fit.
    Normal(NormalSpread),
}

/// So many devices, the same for the same seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Ensemble {
    /// What is known.
    pub spread: Spread,
    /// Number of devices.
    pub members: usize,
    /// Seed.
    pub seed: u64,
}

/// A change of one coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// To a value \[SI\].
    Value(f64),
    /// By a factor.
    Factor(f64),
}

/// One device of an ensemble.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// In the order of [`Ensemble::ids`].
    pub changes: Vec<Change>,
    /// The same in standard deviations from the middle.
    pub deviations: Vec<f64>,
}

impl Ensemble {
    /// Ids of the coefficients that vary.
    #[must_use]
    pub fn ids(&self) -> Vec<&str> {
        match &self.spread {
            Spread::Ranges(ranges) => ranges.iter().map(|r| r.id.as_str()).collect(),
            Spread::Normal(normal) => normal.ids.iter().map(String::as_str).collect(),
        }
    }

    /// Checks it for a device.
    ///
    /// # Errors
    /// [`RobustnessError::Coefficient`] or [`RobustnessError::Ensemble`].
    pub fn check(&self, model: &Model) -> Result<(), RobustnessError> {
        let refuse = |reason: String| Err(RobustnessError::Ensemble(reason));
        if !(2..=MOST_MEMBERS).contains(&self.members) {
            return refuse(format!(
                "{} members are not in 2 .. {MOST_MEMBERS}; 64 are usual",
                self.members
            ));
        }
        let ids = self.ids();
        if ids.is_empty() {
            return refuse("no coefficient varies; name at least one, such as Cs".to_owned());
        }
        for (k, id) in ids.iter().enumerate() {
            let wrong = |reason: String| RobustnessError::Coefficient {
                id: (*id).to_owned(),
                reason,
            };
            if ids[..k].contains(id) {
                return Err(wrong("it is named twice; name it once".to_owned()));
            }
            if !Axis::ids(model, &Waveform::Rest)
                .iter()
                .any(|own| own == id)
            {
                let known = Axis::ids(model, &Waveform::Rest).join(", ");
                return Err(wrong(format!(
                    "the device has no such coefficient; it has {known}"
                )));
            }
        }
        match &self.spread {
            Spread::Ranges(ranges) => ranges.iter().try_for_each(check_range),
            Spread::Normal(normal) => check_normal(normal).map(|_| ()),
        }
    }

    /// The devices. Call [`Self::check`] before.
    ///
    /// # Errors
    /// [`RobustnessError::Ensemble`] if correlations are impossible.
    pub fn draw(&self) -> Result<Vec<Member>, RobustnessError> {
        match &self.spread {
            Spread::Ranges(ranges) => Ok(self.draw_ranges(ranges)),
            Spread::Normal(normal) => self.draw_normal(normal),
        }
    }

    /// Each range is cut in as many equal parts as there are members, and each part has one.
    fn draw_ranges(&self, ranges: &[CoefficientRange]) -> Vec<Member> {
        let n = self.members;
        let mut members = vec![
            Member {
                changes: Vec::new(),
                deviations: Vec::new(),
            };
            n
        ];
        for (k, range) in ranges.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(k as u64);
            let mut parts: Vec<usize> = (0..n).collect();
            for i in (1..n).rev() {
                parts.swap(i, rng.random_range(0..=i));
            }
            for (member, part) in members.iter_mut().zip(parts) {
                let share = (part as f64 + rng.random::<f64>()) / n as f64;
                let value = if range.is_logarithmic {
                    range.low * libm::pow(range.high / range.low, share)
                } else {
                    range.low + (range.high - range.low) * share
                };
                member.changes.push(if range.is_relative {
                    Change::Factor(value)
                } else {
                    Change::Value(value)
                });
                member.deviations.push(UNIFORM_DEVIATIONS * (share - 0.5));
            }
        }
        members
    }

    fn draw_normal(&self, normal: &NormalSpread) -> Result<Vec<Member>, RobustnessError> {
        let root = check_normal(normal)?;
        let n = normal.ids.len();
        let member = |k: usize| {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(k as u64);
            let independent: Vec<f64> = (0..n).map(|_| standard_normal(&mut rng)).collect();
            let rows = root.iter();
            let deviations: Vec<f64> = rows
                .map(|row| row.iter().zip(&independent).map(|(a, b)| a * b).sum())
                .collect();
            let changes = (0..n)
                .map(|i| Change::Value(normal.means[i] + normal.std_errors[i] * deviations[i]));
            Member {
                changes: changes.collect(),
                deviations,
            }
        };
        Ok((0..self.members).map(member).collect())
    }

    /// The device of a member in place of `model`.
    ///
    /// # Errors
    /// Why it is impossible.
    pub fn device(&self, model: &Model, member: &Member) -> Result<Model, String> {
        let mut own = model.clone();
        for (id, change) in self.ids().into_iter().zip(&member.changes) {
            let value = match change {
                Change::Value(value) => *value,
                Change::Factor(factor) => factor * model.get(id).unwrap_or(f64::NAN),
            };
            own.set(id, value).map_err(|error| error.to_string())?;
        }
        own.check().map_err(|error| error.to_string())?;
        Ok(own)
    }
}

fn check_range(range: &CoefficientRange) -> Result<(), RobustnessError> {
    let (low, high) = (range.low, range.high);
    let fault = if !(low.is_finite() && high.is_finite()) {
        "bounds must be finite numbers"
    } else if low >= high {
        "the range is empty; give a lower and a higher bound"
    } else if range.is_logarithmic && low <= 0.0 {
        "a logarithmic range must be above 0"
    } else {
        return Ok(());
    };
    Err(RobustnessError::Coefficient {
        id: range.id.clone(),
        reason: format!("{low} to {high}: {fault}"),
    })
}

/// Lower triangular root of the correlations (Cholesky).
fn check_normal(normal: &NormalSpread) -> Result<Vec<Vec<f64>>, RobustnessError> {
    let n = normal.ids.len();
    let sizes = [
        normal.means.len(),
        normal.std_errors.len(),
        normal.correlation.len(),
    ];
    if sizes != [n; 3] || normal.correlation.iter().any(|row| row.len() != n) {
        return Err(RobustnessError::Ensemble(format!(
            "{n} coefficients need as many means and errors, and {n} rows of {n} correlations"
        )));
    }
    let own = normal
        .ids
        .iter()
        .zip(normal.means.iter().zip(&normal.std_errors));
    for (id, (mean, error)) in own {
        if !(mean.is_finite() && *error >= 0.0 && error.is_finite()) {
            return Err(RobustnessError::Coefficient {
                id: id.clone(),
                reason: format!("{mean} +- {error} is no value with its standard error"),
            });
        }
    }
    let mut root = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let entry = normal.correlation[i][j];
            let explained: f64 = (0..j).map(|k| root[i][k] * root[j][k]).sum();
            let rest = entry - explained;
            let is_wrong = if i == j {
                (entry - 1.0).abs() > ROUNDED_PIVOT || rest.is_nan() || rest <= -ROUNDED_PIVOT
            } else {
                (entry - normal.correlation[j][i])
                    .abs()
                    .partial_cmp(&ROUNDED_PIVOT)
                    != Some(std::cmp::Ordering::Less)
            };
            if is_wrong {
                return Err(RobustnessError::Ensemble(format!(
                    "the correlations of {} and {} are impossible; a correlation matrix is symmetric with 1 on its diagonal and no negative eigenvalue",
                    normal.ids[i], normal.ids[j]
                )));
            }
            root[i][j] = if i == j {
                rest.max(0.0).sqrt()
            } else if root[j][j] > 0.0 {
                rest / root[j][j]
            } else {
                0.0
            };
        }
    }
    Ok(root)
}

/// A standard normal number (Box and Muller), the same bits on each machine.
pub(super) fn standard_normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - rng.random::<f64>())).sqrt();
    radius * libm::cos(std::f64::consts::TAU * rng.random::<f64>())
}
