//! TODO-doc

pub(crate) mod axes;
pub(crate) mod cache;
pub(super) mod curve;
pub(crate) mod layer;
pub(super) mod readout;
pub(super) mod split;
pub mod style;
pub(super) mod time_plot;
pub(super) mod time_window;
pub(super) mod xy;
