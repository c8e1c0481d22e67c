//! TODO-doc

pub(super) mod effect_size;
pub(super) mod named_effects;
pub mod next_experiment;
pub(super) mod proof;
pub(super) mod systematic_error;
