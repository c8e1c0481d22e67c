//! What was left out: where simulation and recordings differ, why, and the proof.

pub mod bench;
pub mod calm;
pub mod candidates;
pub mod explain;
pub mod generic;
pub mod noise;
pub mod options;
pub mod report;
pub mod result;
pub mod ring;
pub mod scan;
pub mod trial;
