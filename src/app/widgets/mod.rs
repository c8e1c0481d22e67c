//! TODO-doc

pub(super) mod callout;
pub(super) mod default_value;
pub(crate) mod icon;
pub(super) mod parameter_slider;
pub(super) mod quantity_field;
pub(super) mod slider_track;
pub(super) mod text;
