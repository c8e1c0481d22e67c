//! What the person sets up and asks for: device, drive, recordings, view and commands.
//! Plain data, no drawing.

pub mod command;
pub mod current_setup;
pub mod drive_choice;
pub(super) mod drive_text;
pub mod explore;
pub mod kept_curve;
pub mod notice;
pub mod overlay;
pub mod own_drive;
pub mod undo;
pub mod view;
pub mod workspace_id;
