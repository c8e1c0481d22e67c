//! The window. Nothing below this floor knows egui.

pub mod command;
mod live;
mod noise;
pub mod plots;
pub mod setup;
pub mod snapshot;
pub mod state;
mod summary;
pub mod worker;
pub mod workspaces;
