//! How the person looks at the setup: mode, pictures, theme, zoom. Saved with a session,
//! but not covered by undo.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::drive_choice::Mode;
use super::explore::ExplorePanel;
use super::kept_curve::KeptCurve;
use super::overlay::OverlayId;

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

/// In what the residual is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResidualUnit {
    /// A length.
    #[default]
    Length,
    /// Each recording's residual divided by its own noise.
    Noise,
}

/// Limits of the residual's scale that are fixed in one press, in units of the noise: what is
/// beyond is an error of the model for certain.
pub const FIXED_NOISE: f64 = 5.0;

impl ResidualUnit {
    /// Its base unit on axes, and in fields.
    pub fn base(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Noise => "x noise",
        }
    }

    /// Name of the residual's scale in [`View::value_ranges`]: each unit has its own.
    pub fn scale_name(self) -> &'static str {
        match self {
            Self::Length => Picture::Residual.name(),
            Self::Noise => "Residual in units of the noise",
        }
    }
}

/// How several recordings are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordingLayout {
    /// All in one picture.
    #[default]
    Overlay,
    /// One panel for each.
    SmallMultiples,
}

/// How the setup is looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct View {
    /// Live or whole span.
    pub mode: Mode,
    /// Whether the whole span begins in the steady response instead of at rest.
    pub from_steady: bool,
    /// Simulated seconds per wall second in Live mode.
    pub slow_down: f64,
    /// Pictures shown.
    pub pictures: BTreeSet<Picture>,
    /// Dark or light.
    pub dark: bool,
    /// Whether runs are shown whole instead of played, and nothing glides or zooms.
    pub less_motion: bool,
    /// Whether the panel on the right is open.
    pub side_panel: bool,
    /// Curves that the person switched from their default visibility, as `Picture: name`.
    pub switched_curves: BTreeSet<String>,
    /// Time span in view \[s\]; `None` is all of it.
    pub time_range: Option<(f64, f64)>,
    /// Values in view, SI, by the name of the picture; all of them in a picture without an entry.
    pub value_ranges: BTreeMap<String, (f64, f64)>,
    /// Names of the ranges that the person fixed: they stay when all values are shown again.
    pub fixed_scales: BTreeSet<String>,
    /// In what the residual is drawn.
    pub residual_unit: ResidualUnit,
    /// How several recordings are drawn.
    pub recording_layout: RecordingLayout,
    /// Small multiples: whether each panel has values of its own in view.
    pub own_value_scales: bool,
    /// Small multiples: whether all panels show the same time, and not each its whole recording.
    pub common_time: bool,
    /// Small multiples: the one recording that has all the room.
    pub shown_alone: Option<OverlayId>,
    /// Name of the workspace.
    pub workspace: String,
    /// The panel of the Explore workspace.
    pub explore_panel: ExplorePanel,
    /// The only curve that sessions of earlier versions keep. When one is read, the curve goes to
    /// the setup.
    #[serde(rename = "kept", skip_serializing)]
    pub formerly_kept: Option<KeptCurve>,
}

impl Default for View {
    fn default() -> Self {
        Self {
            mode: Mode::WholeSpan,
            from_steady: false,
            slow_down: 0.01,
            pictures: [
                Picture::Voltage,
                Picture::Trajectory,
                Picture::Residual,
                Picture::Device,
            ]
            .into(),
            dark: true,
            less_motion: false,
            side_panel: true,
            switched_curves: BTreeSet::new(),
            time_range: None,
            value_ranges: BTreeMap::new(),
            fixed_scales: BTreeSet::new(),
            residual_unit: ResidualUnit::default(),
            recording_layout: RecordingLayout::default(),
            own_value_scales: false,
            common_time: false,
            shown_alone: None,
            workspace: "tune".to_owned(),
            explore_panel: ExplorePanel::default(),
            formerly_kept: None,
        }
    }
}

impl View {
    /// Name of the scale on which the residual is drawn.
    pub fn residual_scale(&self) -> &'static str {
        self.residual_unit.scale_name()
    }

    /// The residual as a length instead of in units of the noise, or the other way round.
    pub fn switch_residual_unit(&mut self) {
        self.residual_unit = match self.residual_unit {
            ResidualUnit::Length => ResidualUnit::Noise,
            ResidualUnit::Noise => ResidualUnit::Length,
        };
    }

    /// The residual in units of the noise, on a fixed scale.
    pub fn fix_residual_in_noise(&mut self) {
        self.residual_unit = ResidualUnit::Noise;
        self.fix_values(self.residual_scale(), (-FIXED_NOISE, FIXED_NOISE));
    }

    /// Recordings in a panel each instead of in one picture, or the other way round.
    pub fn switch_recording_layout(&mut self) {
        self.recording_layout = match self.recording_layout {
            RecordingLayout::Overlay => RecordingLayout::SmallMultiples,
            RecordingLayout::SmallMultiples => RecordingLayout::Overlay,
        };
    }

    /// Fixes the values in view of a scale, by its name; SI.
    pub fn fix_values(&mut self, scale: &str, range: (f64, f64)) {
        self.value_ranges.insert(scale.to_owned(), range);
        self.fixed_scales.insert(scale.to_owned());
    }

    /// Shows all values on a scale again.
    pub fn release_values(&mut self, scale: &str) {
        self.value_ranges.remove(scale);
        self.fixed_scales.remove(scale);
    }

    /// Shows all values on every scale that is not fixed. Returns whether one was zoomed.
    pub fn zoom_out_values(&mut self) -> bool {
        let before = self.value_ranges.len();
        let fixed = &self.fixed_scales;
        self.value_ranges.retain(|name, _| fixed.contains(name));
        self.value_ranges.len() < before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zoom_of_values_is_undone_and_a_fixed_scale_stays() {
        let mut view = View::default();
        let scale = ResidualUnit::Noise.scale_name();
        view.fix_values(scale, (-5.0, 5.0));
        view.value_ranges
            .insert("Trajectory".to_owned(), (0.0, 1e-6));
        assert!(view.zoom_out_values());
        assert!(!view.zoom_out_values());
        assert_eq!(view.value_ranges[scale], (-5.0, 5.0));
        view.release_values(scale);
        assert_eq!(view, View::default());
    }
}
