//! Robust losses under which fits are compared, and the bounds on what one value may cost.
//!
//! All costs are in units of the noise variance, so that a value costs 1 where nothing is
//! missing.

use crate::fit::problem::huber::Huber;

/// A loss that forgives nothing.
pub const LEAST_SQUARES: Huber = Huber(1e4);
/// Loss by which fits are compared, in units of the noise.
pub const ROBUST_LOSS: Huber = Huber(6.0);
/// Residuals beyond this many standard deviations count no more where stretches are compared.
pub const MAX_RESIDUAL: f64 = 6.0;
/// What a value counts for at most where its stretch may be misread [chi2].
pub const MISREAD_CHI2: f64 = 30.0;
