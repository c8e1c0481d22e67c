//! What was left out: where simulation and recordings differ, why, and the proof.
//!
//! Recordings are cut at the events that they show ([`calm`]), and the baseline is
//! re-tuned to the stretches between ([`bench`]). All hypotheses are then weighed at once
//! in the linearised problem ([`scan`]), the promising ones fitted, judged on recordings
//! kept out and added one by one ([`explain`]). Laws of the ground are asked by events
//! ([`events`], [`laws`]), further modes by their ring ([`ring`], `struck`). [`locate`] says
//! where the misfit lies, [`evidence`] what force is missing whatever its name, [`continuity`]
//! whether the flight goes on unbroken from stretch to stretch; [`engine`] puts it all together,
//! `readings` asks it twice where it is in doubt how the recordings are to be read.
//! [`report`] writes it down for people and programs.

mod adhesion;
mod answer;
pub mod bench;
mod bounces;
pub mod calm;
pub mod candidates;
mod chance;
mod choice;
pub mod condition;
mod continuity;
mod curve;
mod drifts;
pub mod engine;
pub mod events;
pub mod evidence;
pub mod example;
pub mod explain;
mod further;
pub mod generic;
mod ground;
mod judged;
pub mod kin;
mod late;
pub mod laws;
mod left;
mod lifted;
mod lines;
pub mod locate;
#[cfg(test)]
mod made;
mod modes;
mod needless;
pub mod next;
pub mod noise;
pub mod options;
mod phases;
mod product;
pub mod promises;
mod readings;
mod refit;
mod refusal;
pub mod report;
pub mod result;
pub mod ring;
mod rubs;
mod scales;
pub mod scan;
mod search;
mod size;
mod step_time;
mod stretches;
mod strips;
mod struck;
mod swing;
mod touches;
pub mod trial;
mod weigh;

pub use answer::RELIABLE;
pub use options::{DiagnoseControl, DiagnoseError, DiagnoseOptions, DiagnoseProgress};
pub use readings::diagnose;
pub use result::{Diagnosis, Verdict};
