//! How certain a fit is: standard errors and correlations, profile likelihood, identifiability,
//! and whether the recordings agree on one device.

pub mod confidence_interval;
pub mod contradiction;
pub(super) mod device_consistency;
pub(crate) mod fit_result;
pub mod identifiability;
pub(super) mod normal_inverse;
pub mod profile_likelihood;
pub(super) mod sandwich_covariance;
mod stored_matrix;
