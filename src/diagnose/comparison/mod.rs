//! Hypotheses, their fits, and whether a gain is significant.

pub(super) mod hypothesis;
pub(super) mod significance;
pub(super) mod trial;
