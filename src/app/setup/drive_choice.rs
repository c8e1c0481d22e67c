//! TODO-doc

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

/// Live or Window mode of the Tune workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Default)]
pub enum Mode {
    /// Simulated time runs against wall time.
    Live,
    /// The whole span at once.
    #[default]
    Window,
}
