//! The answer: what the stages found, put together for people and programs.

pub(super) mod assemble;
pub(super) mod candidate_table;
pub(crate) mod conditions;
pub(super) mod effect_size;
pub mod evaluate;
pub(super) mod events_seen;
pub(crate) mod named_effects;
pub mod next_experiment;
pub(super) mod proof;
pub(super) mod remaining;
pub(super) mod systematic_error;
