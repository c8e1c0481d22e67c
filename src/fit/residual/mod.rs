//! TODO-doc

pub mod coloured_noise;
pub mod residual_rows;
pub(super) mod residuals;
pub(crate) mod simulate_segment;
