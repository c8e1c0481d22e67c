//! The curve kept for comparison (A/B), as a session holds it: by what it was computed
//! from, since the same input gives the same curve again.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::drive_choice::{DriveChoice, Mode};
use super::drive_text::DriveEntry;
use super::overlay::Overlay;
use crate::app::simulation::request::SimulationRequest;
use crate::app::simulation::snapshot::Snapshot;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::sim::simulate;

/// What a kept curve was computed from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Entry", into = "Entry")]
pub struct Kept {
    /// The device.
    pub preset: Preset,
    /// Its drive.
    pub drive: DriveChoice,
    /// Shift of the recording that drove it, as it was then [s].
    pub shift: f64,
    /// Its span [s].
    pub duration: f64,
}

/// The same in a session file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    duration: f64,
    #[serde(default)]
    shift: f64,
    preset: String,
    drive: DriveEntry,
}

impl From<Kept> for Entry {
    fn from(kept: Kept) -> Self {
        Self {
            duration: kept.duration,
            shift: kept.shift,
            preset: kept.preset.to_toml(),
            drive: DriveEntry::of(&kept.drive),
        }
    }
}

impl TryFrom<Entry> for Kept {
    type Error = String;

    fn try_from(entry: Entry) -> Result<Self, String> {
        let Entry {
            duration, shift, ..
        } = entry;
        if !(duration > 0.0 && duration.is_finite() && shift.is_finite()) {
            return Err(format!(
                "the kept curve over {duration} s, shifted by {shift} s, is none"
            ));
        }
        Ok(Self {
            preset: Preset::parse("device of the kept curve", &entry.preset)
                .map_err(|error| error.to_string())?,
            drive: entry.drive.read(duration)?,
            shift,
            duration,
        })
    }
}

impl Kept {
    /// Computes the curve again under `drive`, and how far the recordings are from it.
    ///
    /// # Errors
    /// Why it cannot be simulated.
    pub fn run(&self, drive: Waveform, overlays: &[Overlay]) -> Result<Arc<Snapshot>, String> {
        let started = Instant::now();
        let model = Arc::new(self.preset.model.clone());
        let wish = SimulationRequest {
            model: Arc::clone(&model),
            drive,
            duration: self.duration,
            forces: false,
            overlays: Vec::new(),
            mode: Mode::Window,
            slow_down: 1.0,
            paused: false,
            scrub: None,
            restarts: 0,
            steps: 0,
        };
        let trace = simulate(&model, &wish.drive, self.duration, &wish.options())
            .map_err(|error| error.to_string())?;
        let mut snapshot = Snapshot::new(0, &model, Arc::new(trace), overlays, started.elapsed());
        snapshot.run_of = Some((wish.drive, self.duration));
        Ok(Arc::new(snapshot))
    }
}
