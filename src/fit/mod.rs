//! Identification: parameters from recordings.
//!
//! Impacts make a long simulation diverge from the recording after one contact that is
//! slightly mistimed. So a recording is cut into *segments*, and each is simulated from
//! a free initial state through the events that the data show, at free instants
//! ([`timeline`], [`segment`], [`chain`]). The laws of the ground (height at a touch,
//! velocity after a bounce, force at a release) are residuals like the readings. Each
//! segment's own unknowns are eliminated ([`problem`]), and parameters and the rig's
//! nuisances are found by bounded, robust Levenberg-Marquardt ([`solve`]) from several
//! starts ([`global`]).

pub mod contact_readings;
pub mod error;
#[cfg(test)]
mod free_tests;
pub mod inspect;
pub mod options;
pub mod paper_steps;
pub(crate) mod pipeline;
pub mod problem;
pub mod residual;
pub mod segment;
pub mod solve;
pub mod table_a1;
#[cfg(test)]
mod tests;
pub mod uncertainty;

pub use self::error::FitError;
pub use self::options::Part;
pub use self::options::{FitOptions, FreeNuisances, default_free};
pub use self::pipeline::{evaluate, fit, free_run};
pub use self::solve::levenberg_marquardt::{Control, Progress};
pub use self::uncertainty::fit_result::{FitResult, FittedParameter, Misfit};
pub use self::uncertainty::profile_likelihood::{ProfilePoint, profile_of};
