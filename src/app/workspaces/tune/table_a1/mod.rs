//! Table A.1 of the paper, the only published measurements of the device: a case picker, the
//! features of the current case, all 16 cases in a panel, and the fit to them.

pub(crate) mod calibrate;
pub(super) mod case_picker;
pub(super) mod error_cell;
pub(super) mod features;
pub(super) mod panel;
