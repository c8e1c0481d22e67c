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

mod agree;
pub mod chain;
pub(crate) mod check;
pub mod cma;
pub mod colour;
pub mod combinations;
pub(crate) mod concerns;
mod engine;
pub mod error;
pub mod findings;
pub mod global;
pub mod interval;
mod noise;
pub mod options;
mod plausible;
pub mod prepare;
pub mod problem;
pub mod profile;
pub mod readings;
pub(crate) mod result;
pub mod revise;
pub mod robust;
pub mod segment;
pub mod solve;
pub mod space;
mod spread;
pub mod steps;
pub mod suspects;
pub mod table_a1;
pub mod table_fit;
pub mod timeline;
pub mod track;
pub mod validate;

pub use engine::{fit, free_run, judge};
pub use error::FitError;
pub use findings::Part;
pub use options::{FitOptions, FreeNuisances, default_free};
pub use profile::{ProfilePoint, profile_of};
pub use result::{FitResult, FittedParameter, Misfit};
pub use solve::{Control, Progress};

#[cfg(test)]
mod free_tests;
#[cfg(test)]
mod tests;
