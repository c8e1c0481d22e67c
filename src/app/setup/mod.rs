//! TODO-doc

pub mod command;
pub(super) mod drive_text;
pub(super) mod reference_curve;
pub mod setup;
pub mod undo;
