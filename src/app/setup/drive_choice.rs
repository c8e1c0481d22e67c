//! What drives the simulation, and whether it is shown live or as a whole.

use serde::{Deserialize, Serialize};

use super::overlay::OverlayId;
use crate::model::drive::Waveform;

/// The drive of the simulation.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveChoice {
    /// A waveform or a table.
    Waveform(Waveform),
    /// The voltage of a loaded recording.
    Recorded(OverlayId),
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
