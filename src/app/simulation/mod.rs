//! Runs the simulator on a thread of its own and prepares its results for drawing.

pub(super) mod features;
pub(super) mod live;
pub mod min_max_pyramid;
pub mod recorded_drive;
pub mod reference_run;
pub mod request;
pub mod snapshot;
pub mod worker;
