//! TODO-doc

pub(super) mod significance;
