//! The force balance in flight, in its weak form: which forces act on the measured motion.
//!
//! The equation of motion is multiplied by smooth test functions and integrated over windows of
//! flight; derivatives move from the readings onto the test functions. Every effect of the
//! catalogue, evaluated along the measured motion, gives one column of a linear regression. Nothing
//! is simulated, so a large effect is found as well as a small one, and no starting values are
//! needed. Rows are in units of their noise: chi2 per row is 1 where the physics is complete.
//!
//! [`analysis`] has the steps in order. `slow_mode` is the equation, `windows` and `test_function` the
//! integrals over the flights of a `measured_run`; `equations` makes rows and their noise,
//! `regression` the columns of what is known and asked, `least_squares` solves; `selection` adds effects;
//! `missing_force` measures what is missing as a curve, whatever its law.

mod analysis;
mod equations;
mod least_squares;
mod local_polynomial;
mod measured_run;
mod missing_force;
mod regression;
mod selection;
mod slow_mode;
mod test_function;
#[cfg(test)]
mod tests;
mod windows;

pub use self::analysis::{
    BalanceGuide, BalanceRival, BalancedEffect, ForceBalance, force_balance, forces_without, guide,
};
pub use self::selection::BalanceChi2;
