//! The inverse root of a banded covariance: neighbouring test functions overlap, others do not.

/// Lower Cholesky factor of a symmetric banded matrix, `rows x (band + 1)`, row-major: entry `k` of
/// row `i` is the element at column `i - band + k`.
#[derive(Debug, Clone)]
pub struct BandedCholesky {
    band: usize,
    factor: Vec<f64>,
}

/// Share of the diagonal that is added where rows all but repeat each other: they then count once.
const REPEATED_ROW_SHARE: f64 = 1e-9;

impl BandedCholesky {
    /// Factors the matrix whose element of row `i` and column `j <= i`, `i - j <= band`, is
    /// `element(i, j)`. The matrix must be a covariance.
    pub fn new(rows: usize, band: usize, element: impl Fn(usize, usize) -> f64) -> Self {
        let width = band + 1;
        let mut factor = vec![0.0; rows * width];
        for i in 0..rows {
            let first = i.saturating_sub(band);
            for j in first..=i {
                let mut sum = element(i, j);
                if i == j {
                    sum *= 1.0 + REPEATED_ROW_SHARE;
                }
                let common = first.max(j.saturating_sub(band));
                for k in common..j {
                    sum -= factor[i * width + k + band - i] * factor[j * width + k + band - j];
                }
                factor[i * width + j + band - i] = if i == j {
                    sum.max(f64::MIN_POSITIVE).sqrt()
                } else {
                    sum / factor[j * width + band]
                };
            }
        }
        Self { band, factor }
    }

    /// Turns `values`, one a row, into as many that are independent and of variance 1 if `values`
    /// have the matrix as covariance.
    pub fn whiten(&self, values: &mut [f64]) {
        let width = self.band + 1;
        for i in 0..values.len() {
            let first = i.saturating_sub(self.band);
            let row = &self.factor[i * width..(i + 1) * width];
            let (known, own) = values.split_at_mut(i);
            let before = row[first + self.band - i..self.band]
                .iter()
                .zip(&known[first..]);
            let expected: f64 = before.map(|(f, v)| f * v).sum();
            own[0] = (own[0] - expected) / row[self.band];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::banded_cholesky::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn whitening_is_the_inverse_root_of_the_matrix() {
        let (n, band) = (9usize, 3usize);
        let element = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.0 + i as f64 * 0.1,
            1 => -0.7,
            2 => 0.3,
            3 => 0.1,
            _ => 0.0,
        };
        let dense = DMatrix::from_fn(n, n, element);
        let values: Vec<f64> = (0..n).map(|i| (i as f64 * 1.3).sin()).collect();
        let v = DVector::from_row_slice(&values);
        let expected = (v.transpose() * dense.try_inverse().unwrap() * &v)[(0, 0)];
        let mut white = values;
        BandedCholesky::new(n, band, element).whiten(&mut white);
        let found: f64 = white.iter().map(|w| w * w).sum();
        assert!((found / expected - 1.0).abs() < 1e-7, "{found} {expected}");
    }
}
