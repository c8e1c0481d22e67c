//! Robust losses under which fits are compared, and the bounds on what one value may cost.
//!
//! All costs are in units of the noise variance, so that a value costs 1 where nothing is
//! missing.

use crate::fit::problem::huber::Huber;

/// A loss that is practically quadratic: it tolerates no outliers.
pub const LEAST_SQUARES: Huber = Huber(1e4);
/// The Huber loss by which fits are compared; its bound is in standard deviations of the noise.
pub const ROBUST_LOSS: Huber = Huber(6.0);
/// Residuals are clipped at this many standard deviations where segments are compared.
pub const MAX_RESIDUAL: f64 = 6.0;
/// Largest cost of a value whose segment may be misread \[chi2\].
pub const MISREAD_CHI2: f64 = 30.0;
