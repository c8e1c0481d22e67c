//! Least squares by products: all that a comparison of hypotheses needs of the rows.

use nalgebra::{DMatrix, DVector};

/// Share of its own square below which a column is a combination of others.
const DEPENDENT_COLUMN_SHARE: f64 = 1e-11;

/// Share of its own square that is added to a recording's own unknown, so that two that are one can be
/// removed: no more than rounding.
const ROUNDING_SHARE: f64 = 1e-14;

/// Products of whitened columns with each other and with the right-hand side.
#[derive(Debug, Clone)]
pub struct Gram {
    /// Products of the columns with each other.
    pub products: DMatrix<f64>,
    /// Products with the right-hand side.
    pub slopes: DVector<f64>,
    /// Square of the right-hand side.
    pub square: f64,
    /// Rows, less what was projected out.
    pub freedom: f64,
}

/// A least-squares solution on some of the columns.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The columns.
    pub columns: Vec<usize>,
    /// Their coefficients.
    pub values: DVector<f64>,
    /// Covariance of these.
    pub covariance: DMatrix<f64>,
    /// Chi2 that remains.
    pub chi2: f64,
    /// Number of coefficients that are determined.
    pub rank: usize,
}

impl Gram {
    /// Of `count` columns, without rows.
    pub fn new(count: usize) -> Self {
        Self {
            products: DMatrix::zeros(count, count),
            slopes: DVector::zeros(count),
            square: 0.0,
            freedom: 0.0,
        }
    }

    /// Of whitened rows: `columns` is rows x columns, `right` the right-hand side.
    pub fn of(columns: &DMatrix<f64>, right: &DVector<f64>) -> Self {
        Self {
            products: columns.tr_mul(columns),
            slopes: columns.tr_mul(right),
            square: right.norm_squared(),
            freedom: right.len() as f64,
        }
    }

    /// Adds the rows of another.
    pub fn add(&mut self, other: &Self) {
        self.products += &other.products;
        self.slopes += &other.slopes;
        self.square += other.square;
        self.freedom += other.freedom;
    }

    /// With the last columns fitted and removed, one for each entry of `prior_errors`: the standard
    /// deviations of their coefficients around 0, infinite where nothing is known.
    #[must_use]
    pub fn without_nuisances(&self, prior_errors: &[f64]) -> Self {
        let own = prior_errors.len();
        let kept = self.slopes.len() - own;
        let mut inner = self.products.view((kept, kept), (own, own)).into_owned();
        for (i, error) in prior_errors.iter().enumerate() {
            inner[(i, i)] += error.powi(-2);
        }
        let scale = DVector::from_fn(own, |i, _| inner[(i, i)].max(f64::MIN_POSITIVE).powf(-0.5));
        let mut scaled = DMatrix::from_fn(own, own, |i, j| inner[(i, j)] * scale[i] * scale[j]);
        for i in 0..own {
            scaled[(i, i)] += ROUNDING_SHARE;
        }
        let cross = self.products.view((kept, 0), (own, kept)).into_owned();
        let cross = DMatrix::from_fn(own, kept, |i, j| cross[(i, j)] * scale[i]);
        let slope = DVector::from_fn(own, |i, _| self.slopes[kept + i] * scale[i]);
        let Some(root) = scaled.cholesky() else {
            return self.leading(kept);
        };
        let (solved, moved) = (root.solve(&cross), root.solve(&slope));
        let mut out = self.leading(kept);
        out.products -= cross.tr_mul(&solved);
        out.slopes -= cross.tr_mul(&moved);
        out.square -= slope.dot(&moved);
        out.freedom -= prior_errors.iter().filter(|e| e.is_infinite()).count() as f64;
        out
    }

    fn leading(&self, kept: usize) -> Self {
        Self {
            products: self.products.view((0, 0), (kept, kept)).into_owned(),
            slopes: self.slopes.rows(0, kept).into_owned(),
            square: self.square,
            freedom: self.freedom,
        }
    }

    /// Fits the coefficients of `columns`, the others 0. Columns that are combinations of earlier
    /// ones get 0.
    pub fn solve(&self, columns: &[usize]) -> Solution {
        let mut used: Vec<usize> = Vec::new();
        let size = |c: usize| self.products[(c, c)];
        let mut rows: Vec<Vec<f64>> = Vec::new();
        // Cholesky's factor row by row; what is left of a column says whether it is new.
        for &c in columns {
            if size(c) <= 0.0 || !size(c).is_finite() {
                continue;
            }
            let mut row: Vec<f64> = Vec::with_capacity(used.len() + 1);
            for (k, &other) in used.iter().enumerate() {
                let known: f64 = (0..k).map(|m| row[m] * rows[k][m]).sum();
                row.push((self.products[(c, other)] - known) / rows[k][k]);
            }
            let left = size(c) - row.iter().map(|r| r * r).sum::<f64>();
            if left > DEPENDENT_COLUMN_SHARE * size(c) {
                row.push(left.sqrt());
                rows.push(row);
                used.push(c);
            }
        }
        let n = used.len();
        let factor = DMatrix::from_fn(n, n, |i, j| rows[i].get(j).copied().unwrap_or(0.0));
        let inverse = factor
            .solve_lower_triangular(&DMatrix::identity(n, n))
            .unwrap_or_else(|| DMatrix::zeros(n, n));
        let covariance = inverse.tr_mul(&inverse);
        let slopes = DVector::from_fn(n, |i, _| self.slopes[used[i]]);
        let own = &covariance * &slopes;
        let fall = slopes.dot(&own);
        let place = |c: usize| used.iter().position(|u| *u == c);
        let m = columns.len();
        Solution {
            values: DVector::from_fn(m, |i, _| place(columns[i]).map_or(0.0, |k| own[k])),
            covariance: DMatrix::from_fn(m, m, |i, j| {
                match (place(columns[i]), place(columns[j])) {
                    (Some(a), Some(b)) => covariance[(a, b)],
                    (None, None) if i == j => f64::INFINITY,
                    _ => 0.0,
                }
            }),
            columns: columns.to_vec(),
            chi2: self.square - fall,
            rank: n,
        }
    }

    /// Chi2 at the coefficients of `solution`, as found on other rows.
    pub fn chi2_at(&self, solution: &Solution) -> f64 {
        let n = solution.columns.len();
        let at = |i: usize| solution.columns[i];
        let products = DMatrix::from_fn(n, n, |i, j| self.products[(at(i), at(j))]);
        let slopes = DVector::from_fn(n, |i, _| self.slopes[at(i)]);
        let v = &solution.values;
        self.square - 2.0 * v.dot(&slopes) + v.dot(&(products * v))
    }
}

#[cfg(test)]
mod tests {
    use super::super::gram::*;

    fn example() -> (DMatrix<f64>, DVector<f64>) {
        let columns = DMatrix::from_fn(40, 4, |i, j| {
            ((i * (j + 2)) as f64 * 0.37).sin() + 0.1 * j as f64
        });
        let right = DVector::from_fn(40, |i, _| (i as f64 * 0.91).cos());
        (columns, right)
    }

    #[test]
    fn a_projected_nuisance_is_a_fitted_one() {
        let (columns, right) = example();
        let all = Gram::of(&columns, &right).solve(&[0, 1, 2, 3]);
        let projected = Gram::of(&columns, &right).without_nuisances(&[f64::INFINITY]);
        let own = projected.solve(&[0, 1, 2]);
        for i in 0..3 {
            assert!((own.values[i] - all.values[i]).abs() < 1e-7);
            assert!((own.covariance[(i, i)] / all.covariance[(i, i)] - 1.0).abs() < 1e-6);
        }
        assert!((own.chi2 - all.chi2).abs() < 1e-7);
        assert_eq!(projected.freedom, 39.0);
        // One that is known well is not fitted.
        let known = Gram::of(&columns, &right).without_nuisances(&[1e-9]);
        let without = Gram::of(&columns, &right).solve(&[0, 1, 2]);
        assert!((known.solve(&[0, 1, 2]).chi2 - without.chi2).abs() < 1e-7);
    }

    #[test]
    fn a_repeated_column_gets_no_coefficient() {
        let (columns, right) = example();
        let twice = columns.clone().insert_column(4, 0.0);
        let mut twice = twice;
        let first = twice.column(0) * 2.0;
        twice.set_column(4, &first);
        let solution = Gram::of(&twice, &right).solve(&[0, 1, 4]);
        assert_eq!((solution.rank, solution.values[2]), (2, 0.0));
        assert!(solution.covariance[(2, 2)].is_infinite());
        let plain = Gram::of(&columns, &right).solve(&[0, 1]);
        assert!((solution.chi2 - plain.chi2).abs() < 1e-9);
        assert!((Gram::of(&columns, &right).chi2_at(&plain) - plain.chi2).abs() < 1e-7);
    }
}
