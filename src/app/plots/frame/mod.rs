//! What all pictures have in common: axes, curves, layers, cursors, readouts, colours and
//! the handles between pictures.

pub(crate) mod axes;
pub(crate) mod cache;
pub(super) mod curve;
pub(crate) mod layer;
pub(crate) mod layout_note;
pub(super) mod readout;
pub(super) mod split;
pub mod style;
pub(crate) mod time_plot;
pub(crate) mod time_window;
pub(crate) mod xy;
