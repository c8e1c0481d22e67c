//! What was left out: where simulation and recordings differ, why, and the proof.

pub mod calm;
pub mod noise;
pub mod options;
pub mod report;
pub mod result;
pub mod trial;
