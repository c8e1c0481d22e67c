//! What was left out: where simulation and recordings differ, why, and the proof.
//!
//! Recordings are cut at the events that they show ([`calm`]), and the baseline is
//! re-tuned to the stretches between ([`workspace`]). All hypotheses are then weighed at once
//! in the linearised problem ([`scan`]), the promising ones fitted, judged on recordings
//! kept out and added one by one ([`explain`]). Laws of the ground are asked by events
//! ([`events`], [`laws`]), further modes by their ring ([`ring`], `struck`). [`locate`] says
//! where the misfit lies, [`evidence`] what force is missing whatever its name, [`continuity`]
//! whether the flight goes on unbroken from stretch to stretch; [`engine`] puts it all together,
//! `readings` asks it twice where it is in doubt how the recordings are to be read.
//! [`report`] writes it down for people and programs.

pub(crate) mod ambiguous_contact;
pub mod answer;
pub mod baseline;
pub mod comparison;
pub mod contact;
pub mod data;
pub mod diagnosis;
pub mod discrepancy;
pub mod findings;
pub mod hypotheses;
pub mod options;
pub mod pipeline;
pub mod report;
pub mod score_test;
pub mod selection;
pub mod shooting;
#[cfg(test)]
mod test_support;
pub mod thresholds;
pub mod verdict;

pub use self::ambiguous_contact::diagnose;
pub use self::diagnosis::{Diagnosis, Verdict};
pub use self::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions, DiagnoseProgress};
pub use self::thresholds::CALIBRATED_PRECISION;
