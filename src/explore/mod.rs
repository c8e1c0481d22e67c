//! Explore: how the steady response of a device depends on its drive and its coefficients.
//!
//! | part | what it does |
//! |---|---|
//! | [`waveform`] | drives that are drawn and varied, their limits, and files for function generators |
//! | [`steady_state`] | the periodic response under a periodic drive, its stability, and whether there is one |
//! | [`measures`] | numbers and categories of one steady cycle |
//! | [`map`] | measures over one or two axes: coarse first, finer where the regime changes |
//! | [`orbit`] | one number swept up and down, the state carried along |
//! | [`basin`] | which response each beginning leads to |
//! | [`robustness`] | ensembles of coefficients, and waveforms that keep a wish |
//! | [`gait`] | several feet under one drive, each delayed |

pub mod basin;
pub mod gait;
pub mod map;
pub mod measures;
pub mod orbit;
pub mod robustness;
pub mod steady_state;
#[cfg(test)]
mod test_support;
pub mod waveform;
