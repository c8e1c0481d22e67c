//! Find drive waveforms by eye: what a device does under drives that are drawn and varied.

pub mod gait;
pub mod waveform;
