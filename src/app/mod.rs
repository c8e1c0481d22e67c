//! The window. Nothing below this floor knows egui.

pub mod command;
pub mod setup;
pub mod snapshot;
pub mod state;
