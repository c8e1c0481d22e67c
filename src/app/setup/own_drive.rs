//! What drives a recording's own run.

use crate::model::drive::{DriveReading, Waveform};

/// The drive under which a recording's own run is simulated.
#[derive(Debug, Clone, PartialEq)]
pub enum OwnDrive {
    /// Its measured voltage; the drive of the simulation for one without voltage.
    Measured(DriveReading),
    /// The drive of the simulation.
    Shared,
    /// A waveform chosen for it.
    Chosen(Waveform),
}

impl Default for OwnDrive {
    fn default() -> Self {
        Self::Measured(DriveReading::Recognised)
    }
}
