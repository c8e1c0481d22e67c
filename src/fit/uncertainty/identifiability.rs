//! Identifiability: which combinations of the fitted parameters the recordings determine.
//!
//! Eigenvectors and eigenvalues of the Fisher information of relative changes; parameters
//! without a finite standard error are excluded.

use crate::fit::thresholds::MIN_DIRECTION_SHARE;
use nalgebra::{DMatrix, SymmetricEigen};

use super::fit_result::FitResult;

/// Rounding leaves this much of the largest variance.
const VARIANCE_ROUNDING: f64 = 1e-14;

/// Independent combinations of the determined parameters, the best known first.
#[derive(Debug, Clone, PartialEq)]
pub struct Combinations {
    /// Ids of the parameters.
    pub ids: Vec<String>,
    /// Fisher's eigenvalues of relative changes: one over the variance of each combination.
    pub values: Vec<f64>,
    /// Their directions, one a column.
    pub vectors: DMatrix<f64>,
}

impl Combinations {
    /// Those of a fit. A parameter that is not determined is excluded: its infinite variance would
    /// spoil the other figures. `None` if none remains, or if one has the value zero, so that
    /// relative changes have no meaning.
    pub fn of(result: &FitResult) -> Option<Self> {
        let indices = determined(result);
        let ids: Vec<String> = indices.iter().map(|&i| id(result, i)).collect();
        if indices.is_empty() {
            return None;
        }
        if indices.len() == result.parameters.len() {
            let least = result.fisher_values.last().copied().unwrap_or(0.0);
            let values = result.fisher_values.iter();
            return Some(Self {
                ids,
                values: values.map(|v| v.min(least / VARIANCE_ROUNDING)).collect(),
                vectors: result.fisher_vectors.clone(),
            });
        }
        let relative: Vec<f64> = indices
            .iter()
            .map(|&i| result.parameters[i].std_error / result.parameters[i].value.abs())
            .collect();
        if !relative.iter().all(|r| r.is_finite()) {
            return None;
        }
        let n = indices.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            result.correlations[(indices[i], indices[j])] * relative[i] * relative[j]
        });
        let eigen = SymmetricEigen::new(covariance);
        let least = VARIANCE_ROUNDING * eigen.eigenvalues.max();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        Some(Self {
            ids,
            values: order
                .iter()
                .map(|&i| 1.0 / eigen.eigenvalues[i].max(least))
                .collect(),
            vectors: DMatrix::from_fn(n, n, |i, j| eigen.eigenvectors[(i, order[j])]),
        })
    }

    /// How well the combination number `k` is known: its standard error, relative.
    pub fn error(&self, k: usize) -> f64 {
        self.values[k].sqrt().recip()
    }

    /// Ids of the parameters that make most of the combination number `k`, the strongest
    /// first.
    pub fn named(&self, k: usize) -> Vec<&str> {
        let share = |i: usize| self.vectors[(i, k)].abs();
        let mut order: Vec<usize> = (0..self.ids.len())
            .filter(|&i| share(i) > MIN_DIRECTION_SHARE)
            .collect();
        order.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
        order.into_iter().map(|i| self.ids[i].as_str()).collect()
    }
}

/// Indices of the parameters with a finite standard error.
pub fn determined(result: &FitResult) -> Vec<usize> {
    (0..result.parameters.len())
        .filter(|&i| result.parameters[i].std_error.is_finite())
        .collect()
}

fn id(result: &FitResult, i: usize) -> String {
    result.parameters[i].id.clone()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::fit_result::FittedParameter;
    use super::super::identifiability::*;
    use crate::model::preset::Preset;

    /// Cs and gp known to 1 % each and correlated by 0.6, Ca not determined.
    pub(crate) fn made_up() -> FitResult {
        let parameter = |id: &str, value, std_error| FittedParameter {
            id: id.to_owned(),
            value,
            std_error,
            unit: "",
            start: value,
            at_bound: false,
        };
        let mut correlations = DMatrix::identity(3, 3);
        (correlations[(0, 2)], correlations[(2, 0)]) = (0.6, 0.6);
        FitResult {
            model: Preset::default().model,
            parameters: vec![
                parameter("Cs", 2e-21, 2e-23),
                parameter("Ca", 1.7e-6, f64::INFINITY),
                parameter("gp", 7e-5, 7e-7),
            ],
            correlations,
            fisher_values: vec![1e300, 1.0, 1e-213],
            fisher_vectors: DMatrix::identity(3, 3),
            remarks: Vec::new(),
            train: Default::default(),
            held_out: None,
            cancelled: false,
        }
    }

    #[test]
    fn an_undetermined_parameter_does_not_spoil_the_other_figures() {
        // Two errors of 1 %, correlated by 0.6: variances of 0.4 and 1.6 times 1e-4.
        let found = Combinations::of(&made_up()).unwrap();
        assert_eq!(found.ids, ["Cs", "gp"]);
        assert!((found.values[0] - 25_000.0).abs() < 1e-6, "{found:?}");
        assert!((found.values[1] - 6250.0).abs() < 1e-6, "{found:?}");
        assert!((found.error(1) - 1.6e-4f64.sqrt()).abs() < 1e-12);
        assert_eq!(found.named(1).len(), 2);
    }

    #[test]
    fn with_all_determined_the_eigenvalues_of_the_fit_are_shown() {
        let mut result = made_up();
        result.parameters[1].std_error = 1e-7;
        result.fisher_values = vec![f64::MAX, 400.0, 100.0];
        let found = Combinations::of(&result).unwrap();
        assert!((found.values[0] - 1e16).abs() < 1e3, "{found:?}");
        assert_eq!((found.values[1], found.error(2)), (400.0, 0.1));
        assert_eq!(found.named(1), ["Ca"]);
    }
}
