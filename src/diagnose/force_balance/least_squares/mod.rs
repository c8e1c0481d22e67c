//! Linear least squares with correlated rows: whitening, products, solutions.

pub mod banded_cholesky;
pub mod gram;
