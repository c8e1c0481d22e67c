//! The verdict: checks of what the named effects leave, and whether their names stand.
//!
//! Every check turns a statistic into a [`Finding`](super::findings::Finding) where it is beyond its
//! threshold. The verdict is a fold over the findings.

pub(super) mod abstention;
pub(super) mod adequacy;
pub(super) mod decide;
pub mod known_values;
