//! The window. Nothing below this floor knows egui.

pub mod command;
pub mod plots;
pub mod setup;
pub mod snapshot;
pub mod state;
pub mod workspaces;
