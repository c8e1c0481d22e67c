//! TODO-doc

pub(super) mod clock_skew;
pub(super) mod coarse_fit;
pub(super) mod fitted;
pub(super) mod free_parameters;
pub(super) mod latency;
pub(super) mod local_fit;
pub(super) mod set_aside;
pub(super) mod warm_start;
pub mod workspace;
