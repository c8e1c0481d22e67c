//! Multiple shooting: every segment is simulated from an initial state of its own, all segments
//! share the model's parameters. Here are the recordings made ready for it, its fits, and the
//! clocks of the recordings, which are fitted with it.

pub(super) mod clock_skew;
pub(super) mod coarse_fit;
pub(super) mod fitted;
pub(super) mod free_parameters;
pub(super) mod latency;
pub(super) mod local_fit;
pub(super) mod set_aside;
pub(super) mod warm_start;
pub mod workspace;
