//! TODO-doc

pub(super) mod channel_noise;
pub(super) mod plausible_units;
pub(crate) mod preconditions;
pub mod recording_summary;
pub(crate) mod same_device;
