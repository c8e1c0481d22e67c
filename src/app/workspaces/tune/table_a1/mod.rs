//! TODO-doc

pub(super) mod calibrate;
pub(super) mod case_picker;
pub(super) mod error_cell;
pub(super) mod features;
pub(super) mod panel;
