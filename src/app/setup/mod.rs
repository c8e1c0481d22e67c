//! TODO-doc

pub mod command;
pub mod drive_choice;
pub(super) mod drive_text;
pub mod notice;
pub mod overlay;
pub(super) mod reference_curve;
pub mod setup;
pub mod undo;
pub mod view;
