//! Residuals of one segment: it is simulated from event to event, and each sample, each law of
//! the ground and each prior gives a row in units of its standard deviation.

pub mod coloured_noise;
pub mod residual_rows;
pub(super) mod residuals;
mod segment_joints;
pub(crate) mod segment_start;
pub(crate) mod simulate_segment;
