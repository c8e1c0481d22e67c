//! The window itself: its frame loop, bars, notices, autosave and screenshot.

pub(super) mod autosave;
pub(super) mod bars;
pub(super) mod diagnosis;
mod job_list;
mod kept_curves;
pub(super) mod layout_dump;
pub mod options;
pub mod screenshot;
pub(super) mod simulator;
#[cfg(test)]
pub(super) mod tests;
pub(super) mod toasts;
pub mod window;
