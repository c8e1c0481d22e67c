//! What drives the simulation, and whether it is shown live or as a whole.

use serde::{Deserialize, Serialize};

use super::overlay::OverlayId;
use crate::model::drive::{DriveReading, Waveform};

/// The drive of the simulation.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveChoice {
    /// A waveform or a table.
    Waveform(Waveform),
    /// The voltage of a loaded recording.
    Recorded(OverlayId),
}

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

/// Live or whole-span mode of the Tune workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
pub enum Mode {
    /// The device runs in slow motion.
    Live,
    /// The whole time span is simulated at once. Sessions know this mode as `Window`.
    #[default]
    #[serde(rename = "Window")]
    WholeSpan,
}
