//! TODO-doc

pub(super) mod lag_rivals;
pub(super) mod multistart;
pub(super) mod retune;
