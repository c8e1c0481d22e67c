//! The reference curve (A), held for comparison with the present one (B). A session stores
//! what it was computed from; `simulation::reference_run` computes it again.

use serde::{Deserialize, Serialize};

use super::drive_choice::DriveChoice;
use super::drive_text::DriveEntry;
use crate::model::preset::Preset;

/// What a reference curve was computed from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Entry", into = "Entry")]
pub struct ReferenceCurve {
    /// The device.
    pub preset: Preset,
    /// Its drive.
    pub drive: DriveChoice,
    /// Time shift of the recording that supplied the drive \[s\]. It is stored because the
    /// recording may be shifted later.
    pub shift: f64,
    /// Simulated span \[s\].
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

impl From<ReferenceCurve> for Entry {
    fn from(curve: ReferenceCurve) -> Self {
        Self {
            duration: curve.duration,
            shift: curve.shift,
            preset: curve.preset.to_toml(),
            drive: DriveEntry::of(&curve.drive),
        }
    }
}

impl TryFrom<Entry> for ReferenceCurve {
    type Error = String;

    fn try_from(entry: Entry) -> Result<Self, String> {
        let Entry {
            duration, shift, ..
        } = entry;
        if !(duration > 0.0 && duration.is_finite() && shift.is_finite()) {
            return Err(format!(
                "the reference curve is invalid: span {duration} s, time shift {shift} s"
            ));
        }
        Ok(Self {
            preset: Preset::parse("device of the reference curve", &entry.preset)
                .map_err(|error| error.to_string())?,
            drive: entry.drive.read(duration)?,
            shift,
            duration,
        })
    }
}
