//! TODO-doc

pub mod coloured_noise;
pub mod residual_rows;
pub(super) mod residuals;
pub(super) mod simulate_segment;
