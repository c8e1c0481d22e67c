//! TODO-doc

pub(super) mod autosave;
pub(super) mod bars;
pub(super) mod diagnosis;
pub(super) mod drive;
pub(super) mod layout_dump;
pub mod options;
pub mod picture;
pub(super) mod reference_curve;
#[cfg(test)]
pub(super) mod tests;
pub(super) mod toasts;
pub mod window;
