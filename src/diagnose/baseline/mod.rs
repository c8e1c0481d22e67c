//! TODO-doc

pub(super) mod fit_steps;
pub(super) mod lag_rivals;
pub(super) mod multistart;
pub(super) mod recording_distances;
pub(super) mod retune;
