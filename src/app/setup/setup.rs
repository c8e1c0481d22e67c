//! What the person has set up: everything that undo covers and a session file holds.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::csv::ImportSettings;

use super::reference_curve::Kept;

/// Number of a recording within a session; never used again for another.
pub type OverlayId = u64;

/// The drive of the simulation.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveChoice {
    /// A waveform or a table.
    Waveform(Waveform),
    /// The voltage of a loaded recording.
    Recorded(OverlayId),
}

/// What a recording is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Fitted to.
    Train,
    /// Kept out, to judge a fit or a diagnosis by.
    HeldOut,
    /// Not used.
    Unused,
}

/// A recording laid over the simulation.
#[derive(Debug, Clone)]
pub struct Overlay {
    /// Its number.
    pub id: OverlayId,
    /// The data, immutable.
    pub recording: Arc<Recording>,
    /// How its columns were read.
    pub import: ImportSettings,
    /// Shift and scale against the simulation.
    pub alignment: Alignment,
    /// Whether it is drawn and compared.
    pub visible: bool,
    /// Place in the palette of `theme`.
    pub color: usize,
    /// Shipped with the program: a made-up recording, and said to be.
    pub made_up: bool,
    /// What it is used for; `None` until a person has chosen.
    pub role: Option<Role>,
}

impl PartialEq for Overlay {
    /// Recordings are immutable and keep their number: the number stands for the data.
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
            && self.alignment == other.alignment
            && self.visible == other.visible
            && self.color == other.color
            && self.role == other.role
    }
}

/// What undo and redo step through. One step per finished interaction.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The device with its values, effects and slider ranges.
    pub preset: Preset,
    /// The preset as it was read: what a reset goes back to.
    pub original: Arc<Preset>,
    /// Its drive.
    pub drive: DriveChoice,
    /// Span of the window mode [s].
    pub duration: f64,
    /// Ids of parameters that are locked against change.
    pub locked: BTreeSet<String>,
    /// Recordings laid over it.
    pub overlays: Vec<Overlay>,
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

/// The pictures that can be shown. One file each in `plots/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Picture {
    /// Drive voltage against time.
    Voltage,
    /// Proof mass and cantilever against time.
    Trajectory,
    /// Recording minus simulation against time.
    Residual,
    /// Forces against time.
    Forces,
    /// Velocity against displacement.
    PhasePortrait,
    /// Displacement against voltage.
    DriveLoop,
    /// The device drawn.
    Device,
}

impl Picture {
    /// All, in the order they are stacked.
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

/// How it is looked at: saved with the session, not undone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct View {
    /// Live or Window.
    pub mode: Mode,
    /// Simulated seconds per wall second in Live mode.
    pub slow_down: f64,
    /// Pictures shown.
    pub pictures: BTreeSet<Picture>,
    /// Dark or light.
    pub dark: bool,
    /// Whether the panel on the right is open.
    pub side_panel: bool,
    /// Whether the cantilever's curve is drawn.
    pub show_cantilever: bool,
    /// Whether events (impact, release) are marked.
    pub show_events: bool,
    /// Curves switched by hand from how they are by themselves, as `Picture: name`.
    pub switched_curves: BTreeSet<String>,
    /// Time span in view [s]; `None` is all of it.
    pub time_range: Option<(f64, f64)>,
    /// Name of the workspace.
    pub workspace: String,
    /// The curve kept for comparison, if a session can bring it back.
    pub kept: Option<Kept>,
}

impl Default for View {
    fn default() -> Self {
        Self {
            mode: Mode::Window,
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
            show_cantilever: true,
            show_events: true,
            switched_curves: BTreeSet::new(),
            time_range: None,
            workspace: "tune".to_owned(),
            kept: None,
        }
    }
}
