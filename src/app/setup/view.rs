//! How the person looks at the setup: mode, pictures, theme, zoom. Saved with a session,
//! but not covered by undo.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::drive_choice::Mode;
use super::kept_curve::KeptCurve;

/// The pictures that can be shown; each has a file in `plots/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Picture {
    /// Drive voltage against time.
    Voltage,
    /// Proof mass and cantilever against time.
    Trajectory,
    /// Simulation minus recording against time.
    Residual,
    /// Forces against time.
    Forces,
    /// Velocity against displacement.
    PhasePortrait,
    /// Displacement against voltage.
    DriveLoop,
    /// A drawing of the device.
    Device,
}

impl Picture {
    /// All, from top to bottom.
    pub const ALL: [Picture; 7] = [
        Picture::Voltage,
        Picture::Trajectory,
        Picture::Residual,
        Picture::Forces,
        Picture::PhasePortrait,
        Picture::DriveLoop,
        Picture::Device,
    ];

    /// Name on screen.
    pub fn name(self) -> &'static str {
        match self {
            Picture::Voltage => "Voltage",
            Picture::Trajectory => "Trajectory",
            Picture::Residual => "Residual",
            Picture::Forces => "Forces",
            Picture::PhasePortrait => "Phase portrait",
            Picture::DriveLoop => "Drive loop",
            Picture::Device => "Device",
        }
    }
}

/// How the setup is looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct View {
    /// Live or whole span.
    pub mode: Mode,
    /// Simulated seconds per wall second in Live mode.
    pub slow_down: f64,
    /// Pictures shown.
    pub pictures: BTreeSet<Picture>,
    /// Dark or light.
    pub dark: bool,
    /// Whether the panel on the right is open.
    pub side_panel: bool,
    /// Curves that the person switched from their default visibility, as `Picture: name`.
    pub switched_curves: BTreeSet<String>,
    /// Time span in view \[s\]; `None` is all of it.
    pub time_range: Option<(f64, f64)>,
    /// Values in view, SI, by the name of the picture; all of them in a picture without an entry.
    pub value_ranges: BTreeMap<String, (f64, f64)>,
    /// Name of the workspace.
    pub workspace: String,
    /// The only curve that sessions of earlier versions keep. When one is read, the curve goes to
    /// the setup.
    #[serde(rename = "kept", skip_serializing)]
    pub formerly_kept: Option<KeptCurve>,
}

impl Default for View {
    fn default() -> Self {
        Self {
            mode: Mode::WholeSpan,
            slow_down: 0.01,
            pictures: [
                Picture::Voltage,
                Picture::Trajectory,
                Picture::Residual,
                Picture::Device,
            ]
            .into(),
            dark: true,
            side_panel: true,
            switched_curves: BTreeSet::new(),
            time_range: None,
            value_ranges: BTreeMap::new(),
            workspace: "tune".to_owned(),
            formerly_kept: None,
        }
    }
}
