//! TODO-doc

pub mod confidence_interval;
pub(super) mod device_consistency;
pub(crate) mod fit_result;
pub mod identifiability;
pub(super) mod normal_inverse;
pub mod profile_likelihood;
pub(super) mod sandwich_covariance;
