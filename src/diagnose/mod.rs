//! What a model leaves out: where simulation and recordings differ, why, and the proof.
//!
//! [`pipeline`] has the stages in order. Recordings are screened and cut at their contact events
//! ([`data`]); the baseline is re-tuned ([`baseline`]) to the segments of flight between, each with a
//! free initial state ([`shooting`]: multiple shooting). All effects of the catalogue are then scored
//! at once in the linearised problem ([`score_test`]); those with large scores become [`hypotheses`],
//! which are fitted, compared on held-out recordings ([`comparison`]) and added one by one
//! ([`selection`]). Contact laws are tested by bounces, releases and stays ([`contact`]).
//! [`discrepancy`] says where the misfit lies and what force is missing, whatever its form;
//! [`verdict`] whether the model is adequate and whether names stand; [`answer`] puts it together.
//! `ambiguous_contact` asks twice if contact is uncertain. [`thresholds`] holds every number that
//! decides, [`findings`] what the checks find, and [`report`] writes it down for people and programs.

pub(crate) mod ambiguous_contact;
pub mod answer;
pub mod baseline;
pub mod comparison;
pub mod contact;
pub mod data;
pub mod diagnosis;
pub mod discrepancy;
pub mod findings;
pub mod force_balance;
mod force_curve;
pub mod hypotheses;
pub mod options;
mod packed_points;
pub mod pipeline;
mod quantity;
pub mod report;
pub mod score_test;
pub mod selection;
pub mod shooting;
#[cfg(test)]
mod test_support;
pub mod thresholds;
pub mod verdict;

pub use self::ambiguous_contact::diagnose;
pub use self::answer::evaluate::{StretchMisfit, evaluate};
pub use self::diagnosis::{Diagnosis, Verdict};
pub use self::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions, DiagnoseProgress};
pub use self::thresholds::CALIBRATED_PRECISION;
