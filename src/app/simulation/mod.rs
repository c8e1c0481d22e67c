//! Runs the simulator on a thread of its own and prepares its results for drawing.

pub mod experiments;
mod features;
pub mod kept;
pub(super) mod live;
pub mod min_max_pyramid;
pub mod misfit_history;
pub mod recorded_drive;
pub mod request;
pub mod snapshot;
pub mod stretch_misfits;
pub mod worker;
