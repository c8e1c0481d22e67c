//! The joint score of several directions: normal equations solved by an eigenvalue decomposition,
//! nearly dependent directions left out.

use nalgebra::{DMatrix, DVector};

/// Score of several directions together.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Fall of chi2.
    pub gain: f64,
    /// Number of directions that are determined.
    pub rank: usize,
    /// Step along each direction.
    pub theta: Vec<f64>,
    /// Standard errors of those steps.
    pub errors: Vec<f64>,
}

/// Solves the normal equations of directions that may be nearly dependent; `None` if they are not
/// finite. Eigenvalues below 1e-5 of the scaled matrix are skipped.
pub fn solve(normal: &DMatrix<f64>, gradient: &DVector<f64>) -> Option<Joint> {
    let n = gradient.len();
    if n == 0 {
        return Some(Joint {
            gain: 0.0,
            rank: 0,
            theta: Vec::new(),
            errors: Vec::new(),
        });
    }
    let scale = DVector::from_fn(n, |i, _| 1.0 / normal[(i, i)].max(1e-200).sqrt());
    let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let slope = DVector::from_fn(n, |i, _| gradient[i] * scale[i]);
    let eigen = scaled.symmetric_eigen();
    let mut theta = DVector::zeros(n);
    let mut variance = DVector::zeros(n);
    let (mut gain, mut rank) = (0.0, 0);
    for k in 0..n {
        let value = eigen.eigenvalues[k];
        if value.is_nan() {
            return None;
        }
        if value < 1e-5 {
            continue;
        }
        let v = eigen.eigenvectors.column(k);
        let along = v.dot(&slope);
        gain += along * along / value;
        rank += 1;
        theta -= v * (along / value);
        variance += v.map(|c| c * c / value);
    }
    Some(Joint {
        gain,
        rank,
        theta: (0..n).map(|i| theta[i] * scale[i]).collect(),
        errors: (0..n)
            .map(|i| variance[i].max(0.0).sqrt() * scale[i])
            .collect(),
    })
}
