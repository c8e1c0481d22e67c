//! TODO-doc

pub mod editor;
pub(super) mod place;
pub(super) mod preview;
pub(super) mod table;
