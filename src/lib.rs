//! `impactscope`: how small things hit the ground.
//!
//! Floors, each importing only from those below it:
//! `app` (the window) - `fit` (identification) - `recording` (measurements) - `sim` (the
//! hybrid simulator) - `model` (what the device is).

#[cfg(feature = "gui")]
pub mod app;
mod atomic_write;
pub mod cli;
pub mod diagnose;
pub mod fit;
pub mod model;
pub mod recording;
pub mod sim;
pub mod trial;
