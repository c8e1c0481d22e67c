//! Widgets that several parts of the window share: sliders, quantity fields, icons, remarks
//! and small text.

pub(super) mod callout;
pub(super) mod default_value;
pub(crate) mod icon;
pub(super) mod job_progress;
pub(super) mod parameter_slider;
pub(super) mod quantity_field;
pub(super) mod result_buttons;
pub(super) mod role_choice;
pub(super) mod slider_search;
pub(super) mod slider_track;
pub(super) mod text;
