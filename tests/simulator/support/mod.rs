//! What several tests of the simulator share.

pub mod device;
pub mod difference;
pub mod waveform;
