//! Forward selection: hypotheses are refitted, tested on the held-out recordings and added one by
//! one; earlier ones that became superfluous are removed.

pub(super) mod choose;
pub(super) mod evaluate;
pub mod forward;
pub(super) mod law_shape;
pub(super) mod prune;
pub(super) mod refit;
pub(super) mod self_ringing;
pub(super) mod stopping;
