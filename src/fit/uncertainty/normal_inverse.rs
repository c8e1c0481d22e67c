//! Inverse of the normal equations (`J^T W J`), which may be singular: the covariance of a
//! linearized fit in units of the noise.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Inverse of a positive semidefinite matrix, scaled to its diagonal; directions that
/// the data do not determine get a very large variance.
pub(crate) fn inverse(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let n = normal.nrows();
    if n == 0 {
        return normal.clone();
    }
    let scale = DVector::from_fn(n, |i, _| 1.0 / normal[(i, i)].max(1e-200).sqrt());
    let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let eigen = SymmetricEigen::new(scaled);
    let inverted = eigen.eigenvalues.map(|v| 1.0 / v.max(1e-13));
    let whole =
        &eigen.eigenvectors * DMatrix::from_diagonal(&inverted) * eigen.eigenvectors.transpose();
    DMatrix::from_fn(n, n, |i, j| whole[(i, j)] * scale[i] * scale[j])
}
