//! Explore: how the steady response of a device depends on its drive and its coefficients.
//!
//! | part | what it does |
//! |---|---|
//! | [`waveform`] | drives that are drawn and varied, their limits, and files for function generators |
//! | [`steady_state`] | the periodic response under a periodic drive, its stability, and whether there is one |
//! | [`measures`] | numbers and categories of one steady cycle |
//! | [`gait`] | several feet under one drive, each delayed |

pub mod gait;
pub mod map;
pub mod measures;
pub mod steady_state;
pub mod waveform;
