//! TODO-doc

pub(super) mod abstention;
pub(super) mod adequacy;
