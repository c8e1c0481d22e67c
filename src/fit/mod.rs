//! Identification: parameters with standard errors from recordings.
//!
//! A long simulation diverges from a recording after one impact that is slightly mistimed. So
//! a recording is cut into segments, each simulated from a free initial state through the
//! events that the data show (multiple shooting; Bock 1983). The stages, in order:
//!
//! 1. [`inspect`]: noise, ground level and events of each recording; refuse what cannot be used.
//! 2. [`segment`]: the drive as smooth pieces, the events, the cut, first guesses of the states.
//! 3. [`residual`]: simulate one segment; samples, laws of the ground and priors give its rows.
//! 4. [`problem`]: Jacobians of all segments; each segment's own unknowns are eliminated.
//! 5. [`solve`]: bounded, robust Levenberg-Marquardt from several starts; misread events revised.
//! 6. [`uncertainty`]: covariance, profile likelihood, identifiability, consistency of devices.
//!
//! [`fit()`] runs all of it, [`evaluate`] measures a model on recordings without fitting its
//! parameters. [`contact_readings`] and [`paper_steps`] are the paper's identification step by
//! step, [`table_a1`] its table. The numbers that decide are in [`thresholds`].

pub mod choices;
pub mod contact_readings;
pub mod contact_sample;
pub mod error;
pub mod experiment;
#[cfg(test)]
mod free_tests;
pub mod inspect;
pub mod modal;
pub mod options;
pub mod paper_steps;
pub(crate) mod pipeline;
pub mod problem;
mod recipes;
pub mod residual;
pub mod segment;
pub mod solve;
pub mod table_a1;
#[cfg(test)]
mod tests;
pub mod thresholds;
pub mod uncertainty;

pub use self::choices::{FixedParameter, ParameterChoices};
pub use self::error::FitError;
pub use self::options::Part;
pub use self::options::{FitOptions, FreeNuisances, default_free, whole_device};
pub use self::pipeline::{evaluate, fit};
pub use self::solve::levenberg_marquardt::{Control, Progress};
pub use self::uncertainty::contradiction::{Contradiction, HeldParameter};
pub use self::uncertainty::fit_result::{FitResult, FittedParameter, Misfit};
pub use self::uncertainty::profile_likelihood::{ProfilePoint, profile_of};
