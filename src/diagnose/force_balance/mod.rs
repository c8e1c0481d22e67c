//! The force balance in flight, in its weak form: which forces act on the measured motion.
//!
//! The equation of motion is multiplied by smooth test functions and integrated over windows of
//! flight; derivatives move from the readings onto the test functions. Every effect of the
//! catalogue, evaluated along the measured motion, gives one column of a linear regression. Nothing
//! is simulated, so a large effect is found as well as a small one, and no starting values are
//! needed. Rows are in units of their noise: chi2 per row is 1 where the physics is complete.

pub mod analysis;
mod banded_cholesky;
mod equations;
mod gram;
mod local_polynomial;
mod measured_run;
mod regression;
pub mod selection;
mod structure;
mod test_function;
mod windows;

pub use self::analysis::{BalancedEffect, ForceBalance, analyse};
