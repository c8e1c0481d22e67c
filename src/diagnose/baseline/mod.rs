//! The baseline: the nominal model re-tuned to the fitted recordings, so that only missing physics
//! remains in its residuals.

pub(super) mod fit_steps;
mod guided;
pub(super) mod lag_rivals;
pub(super) mod multistart;
pub(super) mod recording_distances;
pub(super) mod retune;
