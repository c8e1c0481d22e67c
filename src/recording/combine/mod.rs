//! Recordings put together: repeated trials of one motion averaged, with their spread kept
//! ([`average`]), and two runs with one point each merged ([`merge_points`]).
//!
//! Both lay recordings over each other in time by their common drive voltage: by the shift at which the
//! voltages correlate best, to a fraction of a sample ([`super::align`]), after which the voltages must
//! agree. What differs is said in the warnings of the result.

mod average;
mod error;
mod interpolate;
mod merge;
mod misfit;
mod overlay;
mod said;
mod setting;
pub(super) mod spread;
mod stack;
#[cfg(test)]
mod tests;

pub use self::average::{Average, AverageOptions, average};
pub use self::error::CombineError;
pub use self::merge::merge_points;
pub use self::misfit::{AveragedTrial, Misfit};
pub use self::overlay::{Overlay, VoltageAgreement, compare_voltages, lay_over};
pub use self::setting::Combination;
pub use self::spread::TrialSpread;
