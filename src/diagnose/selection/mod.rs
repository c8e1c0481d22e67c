//! TODO-doc

pub(super) mod choose;
pub(super) mod evaluate;
pub mod forward;
pub(super) mod law_shape;
pub(super) mod prune;
pub(super) mod refit;
pub(super) mod self_ringing;
pub(super) mod stopping;
