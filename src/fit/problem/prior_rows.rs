//! Rows of the least-squares problem that come from what is known beforehand: the nuisances' priors,
//! and the known values of parameters.
//!
//! A known value `k +- s` adds the residual `(p - k) / s` of the value p itself, whatever the
//! coordinate in which p is moved. A coordinate may be a logarithm, and the film's value depends on
//! several ones, so the slopes are differences of the value over the coordinates.

use super::Problem;
use super::huber::Huber;
use super::parameter_space::Space;
use crate::model::preset::known_value::KnownValue;

/// Step of a coordinate for the slope of a value.
const SLOPE_STEP: f64 = 1e-5;

/// A row that depends on a few unknowns alone.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorRow {
    /// Index of each unknown with the slope of the residual.
    pub slopes: Vec<(usize, f64)>,
    /// The residual.
    pub value: f64,
    /// Whether it counts under the robust loss. What is known of a parameter does not: it must not
    /// give way the more, the more the recordings contradict it.
    pub is_robust: bool,
}

impl PriorRow {
    /// Its cost under a loss.
    pub fn cost(&self, huber: Huber) -> f64 {
        if self.is_robust {
            huber.cost(self.value)
        } else {
            self.value * self.value
        }
    }

    /// The square of its weight under a loss.
    pub fn weight(&self, huber: Huber) -> f64 {
        if self.is_robust {
            huber.root_weight(self.value).powi(2)
        } else {
            1.0
        }
    }
}

impl Problem {
    /// Rows of all priors at unknowns `x`.
    pub fn prior_rows(&self, x: &[f64]) -> Vec<PriorRow> {
        let first = self.space.len();
        let nuisances = self.nuisances.iter().enumerate();
        let own = nuisances.filter(|(_, n)| n.sigma.is_finite());
        let mut rows: Vec<PriorRow> = own
            .map(|(i, n)| {
                let slope = n.unit / n.sigma;
                PriorRow {
                    slopes: vec![(first + i, slope)],
                    value: slope * x[first + i] - n.mean / n.sigma,
                    is_robust: n.has_outliers(),
                }
            })
            .collect();
        rows.extend(
            self.known
                .iter()
                .map(|known| known_row(&self.space, known, x)),
        );
        rows
    }

    /// Cost of all priors at unknowns `x`.
    pub fn prior_cost(&self, x: &[f64], huber: Huber) -> f64 {
        let first = self.space.len();
        let nuisances = self.nuisances.iter().zip(&x[first..]);
        let own = nuisances.filter(|(n, _)| n.sigma.is_finite());
        let of_nuisances: f64 = own
            .map(|(n, x)| {
                let off = (x * n.unit - n.mean) / n.sigma;
                if n.has_outliers() {
                    huber.cost(off)
                } else {
                    off * off
                }
            })
            .sum();
        of_nuisances + self.known_cost(x)
    }

    /// Cost of what is known of the parameters at unknowns `x`.
    pub fn known_cost(&self, x: &[f64]) -> f64 {
        if self.known.is_empty() {
            return 0.0;
        }
        let model = self.space.model(x);
        let pull = |known: &KnownValue| pull(model.get(&known.id), known);
        self.known.iter().map(|known| pull(known).powi(2)).sum()
    }
}

/// Distance of a value from what is known, in its standard errors; 0 for a parameter that the model
/// does not have.
fn pull(value: Option<f64>, known: &KnownValue) -> f64 {
    value.map_or(0.0, |value| (value - known.value) / known.std_error)
}

/// The row of a known value at unknowns `x`.
pub(crate) fn known_row(space: &Space, known: &KnownValue, x: &[f64]) -> PriorRow {
    let at = |x: &[f64]| pull(space.model(x).get(&known.id), known);
    let mut slopes = Vec::new();
    let mut there = x.to_vec();
    for (j, entry) in space.entries.iter().enumerate() {
        let (low, high) = (
            (x[j] - SLOPE_STEP).max(entry.low),
            (x[j] + SLOPE_STEP).min(entry.high),
        );
        if high <= low {
            continue;
        }
        there[j] = low;
        let below = at(&there);
        there[j] = high;
        let above = at(&there);
        there[j] = x[j];
        if above != below {
            slopes.push((j, (above - below) / (high - low)));
        }
    }
    PriorRow {
        slopes,
        value: at(x),
        is_robust: false,
    }
}

#[cfg(test)]
mod tests {
    use super::super::prior_rows::*;
    use crate::model::preset::Preset;

    /// Newton's steps along the rows of known values alone end at these values, also in the
    /// coordinates of the film, and of logarithms, from a start that is far off.
    #[test]
    fn rows_of_known_values_lead_to_them_in_any_coordinates() {
        let model = Preset::embedded("paper").unwrap().model;
        let ids = ["dp", "gp", "Cs", "zeta1"].map(str::to_owned);
        let space = Space::new(&model, &ids).unwrap();
        let known: Vec<KnownValue> = [
            ("dp", 60e-6, 1e-7),
            ("gp", 75e-6, 1e-6),
            ("Cs", 4e-21, 1e-22),
            ("zeta1", 0.05, 1e-3),
        ]
        .map(|(id, value, error)| KnownValue::new(&model, id, (value, error)).unwrap())
        .to_vec();
        let mut x = space.coordinates(&model);
        for _ in 0..20 {
            let rows: Vec<PriorRow> = known.iter().map(|k| known_row(&space, k, &x)).collect();
            let mut jacobian = nalgebra::DMatrix::zeros(4, 4);
            for (i, row) in rows.iter().enumerate() {
                row.slopes
                    .iter()
                    .for_each(|&(j, slope)| jacobian[(i, j)] = slope);
            }
            let right = nalgebra::DVector::from_iterator(4, rows.iter().map(|row| -row.value));
            let step = jacobian.lu().solve(&right).unwrap();
            x.iter_mut()
                .zip(step.iter())
                .for_each(|(x, d)| *x += d.clamp(-1.0, 1.0));
        }
        for (value, known) in space.values(&x).iter().zip(&known) {
            let off = (value - known.value) / known.std_error;
            assert!(
                off.abs() < 1e-3,
                "{}: {value} against {}",
                known.id,
                known.value
            );
        }
        // The film's strength at contact depends on the gap, and so does the row of Cs.
        assert!(known_row(&space, &known[2], &x).slopes.len() > 1);
        // A row of a parameter that is far off keeps its whole cost under a robust loss.
        let mut far = x.clone();
        far[3] += 2.0;
        let row = known_row(&space, &known[3], &far);
        assert!(row.value > 100.0 && row.cost(Huber(3.0)) == row.value * row.value);
    }
}
