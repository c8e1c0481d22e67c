//! A second opinion on the simulator, written from the description of the device alone.
//!
//! Nothing here uses the crate under test: modes, presets, matrices, drive and contact
//! law are written again, in physical coordinates `[xc, xp, xc', xp']` instead of modal
//! ones, in other units (um, ms, mg, uN), and integrated by `diffsol` instead of the
//! simulator's own method. What both agree on is unlikely to be wrong in the same way.

// Several test programs and a benchmark share this folder; none of them uses all of it.
#![allow(dead_code, unused_imports)]

pub mod device;
pub mod flow;
pub mod hybrid;
pub mod native;
pub mod voltage;

pub use device::Device;
pub use hybrid::{Kind, Outcome, Tolerance, run};
pub use voltage::Drive;
