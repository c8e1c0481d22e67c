//! TODO-doc

pub(super) mod hypothesis;
pub(super) mod significance;
pub(super) mod trial;
