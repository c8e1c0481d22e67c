//! What a person has said of the experiment that a recording is of: what drove it, and what of its
//! instrument is unknown. Simulation, fit and diagnosis all follow it.

use crate::model::drive::{DriveReading, Waveform};

/// What drove a recording.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveSource {
    /// Its measured voltage, read so.
    Measured(DriveReading),
    /// This waveform, whatever the voltage says; its t = 0 is at `start` \[s\] of the recording's
    /// clock.
    Waveform {
        /// The voltage.
        waveform: Waveform,
        /// See [`DriveSource::Waveform`].
        start: f64,
    },
}

impl Default for DriveSource {
    fn default() -> Self {
        Self::Measured(DriveReading::Recognised)
    }
}

/// What of a recording's instrument is unknown, beyond its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstrumentUnknowns {
    /// Whether the zero of each reading is.
    pub zeros: bool,
    /// Standard deviation of each reading's scale around 1; `None` holds it.
    pub scale: Option<f64>,
    /// Standard deviation of the clock of the readings around `lag` \[s\]; `None` holds it.
    pub clock: Option<f64>,
    /// Lag of the readings behind the voltage \[s\], known beforehand.
    pub lag: f64,
}
