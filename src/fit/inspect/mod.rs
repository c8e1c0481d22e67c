//! What can be said of recordings before a fit: noise, ground level, events, and whether units,
//! ranges and devices are plausible. Everything that is refused is refused here.

pub(super) mod channel_noise;
pub(crate) mod connections;
pub(crate) mod motion;
pub(super) mod plausible_units;
pub(crate) mod preconditions;
pub mod recording_summary;
pub(crate) mod same_device;
