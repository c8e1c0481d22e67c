//! TODO-doc

pub mod load_example;
pub(super) mod sealed_trial;
