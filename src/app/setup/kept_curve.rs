//! Curves kept to compare the present one with, each with a name. A session stores what they
//! were computed from; `simulation::kept` computes them again.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::drive_choice::DriveChoice;
use super::drive_text::DriveEntry;
use crate::model::drive::DriveReading;
use crate::model::preset::Preset;

/// Most curves that are kept at a time: more can be distinguished neither by colour nor by line.
pub const MAX_KEPT_CURVES: usize = 12;
/// Longest name that can be typed \[letters\].
pub const MAX_NAME_LETTERS: usize = 60;

/// What a kept curve was computed from. It never changes.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOrigin {
    /// The device.
    pub preset: Preset,
    /// Its drive.
    pub drive: DriveChoice,
    /// Time shift of the recording that supplied the drive \[s\]. It is stored because the
    /// recording may be shifted later.
    pub shift: f64,
    /// How the voltage of that recording was read, which may be changed later, too.
    pub reading: DriveReading,
    /// Simulated span \[s\].
    pub duration: f64,
    /// Number of the live result that was kept. A live run cannot be repeated: it is lost when
    /// the window is closed, and no session holds it.
    pub live: Option<u64>,
}

/// Whether two curves were computed from the same.
pub fn same_origin(a: &Arc<RunOrigin>, b: &Arc<RunOrigin>) -> bool {
    // Live runs are distinguished by their numbers, without a look at the rest.
    Arc::ptr_eq(a, b) || (a.live == b.live && **a == **b)
}

/// A kept curve.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Entry", into = "Entry")]
pub struct KeptCurve {
    /// Its name, which no other kept curve has.
    pub name: String,
    /// Index into the palette of kept curves.
    pub color: usize,
    /// Whether it is drawn.
    pub visible: bool,
    /// What it was computed from.
    pub origin: Arc<RunOrigin>,
}

impl PartialEq for KeptCurve {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
            && self.color == other.color
            && self.visible == other.visible
            && same_origin(&self.origin, &other.origin)
    }
}

/// The same in a session file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// Sessions of earlier versions have one curve without a name.
    #[serde(default = "unnamed")]
    name: String,
    #[serde(default)]
    color: usize,
    #[serde(default = "visible")]
    visible: bool,
    duration: f64,
    #[serde(default)]
    shift: f64,
    #[serde(default, skip_serializing_if = "is_usual")]
    reading: DriveReading,
    preset: String,
    drive: DriveEntry,
}

fn unnamed() -> String {
    numbered_name(&[])
}

#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_usual(reading: &DriveReading) -> bool {
    *reading == DriveReading::default()
}

fn visible() -> bool {
    true
}

impl From<KeptCurve> for Entry {
    fn from(curve: KeptCurve) -> Self {
        let origin = &curve.origin;
        Self {
            duration: origin.duration,
            shift: origin.shift,
            reading: origin.reading,
            preset: origin.preset.to_toml(),
            drive: DriveEntry::of(&origin.drive),
            name: curve.name,
            color: curve.color,
            visible: curve.visible,
        }
    }
}

impl TryFrom<Entry> for KeptCurve {
    type Error = String;

    fn try_from(entry: Entry) -> Result<Self, String> {
        let Entry {
            name,
            color,
            visible,
            duration,
            shift,
            reading,
            preset,
            drive,
        } = entry;
        if !(duration > 0.0 && duration.is_finite() && shift.is_finite()) {
            return Err(format!(
                "the kept curve {name:?} is invalid: span {duration} s, time shift {shift} s"
            ));
        }
        let preset = Preset::parse(&format!("device of the kept curve {name:?}"), &preset)
            .map_err(|error| error.to_string())?;
        Ok(Self {
            name,
            color,
            visible,
            origin: Arc::new(RunOrigin {
                preset,
                drive: drive.read(duration)?,
                shift,
                reading,
                duration,
                live: None,
            }),
        })
    }
}

/// The curves that a session holds: all but those of live runs.
pub fn lasting(kept: &[KeptCurve]) -> Vec<KeptCurve> {
    let lasts = |curve: &&KeptCurve| curve.origin.live.is_none();
    kept.iter().filter(lasts).cloned().collect()
}

/// The curves that a session file holds, each with a name of its own.
///
/// # Errors
/// If there are too many.
pub fn of_session(read: Vec<KeptCurve>) -> Result<Vec<KeptCurve>, String> {
    let count = read.len();
    if count > MAX_KEPT_CURVES {
        return Err(format!(
            "the session keeps {count} curves, at most {MAX_KEPT_CURVES} can be kept; remove some of its tables [[kept]]"
        ));
    }
    let mut kept: Vec<KeptCurve> = Vec::new();
    for mut curve in read {
        if curve.name.trim().is_empty() {
            curve.name = numbered_name(&kept);
        }
        curve.name = distinct_name(&kept, None, &curve.name);
        kept.push(curve);
    }
    Ok(kept)
}

/// The first colour that no kept curve has.
pub fn free_color(kept: &[KeptCurve]) -> usize {
    let is_free = |color: &usize| kept.iter().all(|curve| curve.color != *color);
    (0..).find(is_free).unwrap_or(0)
}

/// `kept 1`, or the next number that no curve has.
pub fn numbered_name(kept: &[KeptCurve]) -> String {
    let is_free = |name: &String| kept.iter().all(|curve| curve.name != *name);
    let mut names = (1..=kept.len() + 1).map(|number| format!("kept {number}"));
    names.find(is_free).unwrap_or_default()
}

/// `name`, with a number after it if another curve than number `own` has it.
pub fn distinct_name(kept: &[KeptCurve], own: Option<usize>, name: &str) -> String {
    let is_taken = |name: &str| {
        let mut others = kept.iter().enumerate().filter(|(i, _)| Some(*i) != own);
        others.any(|(_, curve)| curve.name == name)
    };
    let mut distinct = name.to_owned();
    let mut number = 2;
    while is_taken(&distinct) {
        distinct = format!("{name} ({number})");
        number += 1;
    }
    distinct
}

/// Gives a kept curve another name. Spaces around it are left out; without any letter the name
/// stays.
pub fn rename(kept: &mut [KeptCurve], index: usize, name: &str) {
    let name = name.trim();
    if name.is_empty() || index >= kept.len() {
        return;
    }
    let name: String = name.chars().take(MAX_NAME_LETTERS).collect();
    kept[index].name = distinct_name(kept, Some(index), &name);
}

#[cfg(test)]
mod tests {
    use super::super::kept_curve::*;
    use crate::model::drive::Waveform;

    fn curve(name: &str, color: usize) -> KeptCurve {
        KeptCurve {
            name: name.to_owned(),
            color,
            visible: true,
            origin: Arc::new(RunOrigin {
                preset: Preset::default(),
                drive: DriveChoice::Waveform(Waveform::Rest),
                shift: 0.0,
                reading: DriveReading::default(),
                duration: 0.4,
                live: None,
            }),
        }
    }

    #[test]
    fn names_and_colours_are_distinct() {
        let mut kept = vec![curve("kept 1", 0), curve("kept 2", 2)];
        assert_eq!(numbered_name(&[]), "kept 1");
        assert_eq!(numbered_name(&kept), "kept 3");
        assert_eq!(free_color(&kept), 1);
        rename(&mut kept, 1, "  soft film ");
        assert_eq!(kept[1].name, "soft film");
        assert_eq!(numbered_name(&kept), "kept 2");
        rename(&mut kept, 0, "soft film");
        assert_eq!(kept[0].name, "soft film (2)");
        // Its own name is no other curve's, and an empty one is none.
        rename(&mut kept, 1, "soft film");
        rename(&mut kept, 0, " ");
        rename(&mut kept, 9, "of none");
        assert_eq!(kept[0].name, "soft film (2)");
        assert_eq!(kept[1].name, "soft film");
        rename(&mut kept, 0, &"x".repeat(500));
        assert_eq!(kept[0].name.chars().count(), MAX_NAME_LETTERS);
    }

    #[test]
    fn a_session_file_by_hand_gets_distinct_names_and_not_too_many_curves() {
        let names = ["a", "", "a", "a (2)"];
        let read = names.map(|name| curve(name, 0)).to_vec();
        let kept = of_session(read).unwrap();
        let names: Vec<&str> = kept.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["a", "kept 1", "a (2)", "a (2) (2)"]);
        assert_eq!(of_session(kept.clone()).unwrap(), kept);
        let many = vec![curve("a", 0); MAX_KEPT_CURVES + 1];
        let error = of_session(many).unwrap_err();
        assert!(error.contains("13 curves, at most 12"), "{error}");
    }

    #[test]
    fn a_session_leaves_out_live_runs() {
        let mut kept = vec![curve("a", 0), curve("b", 1)];
        let origin = RunOrigin {
            live: Some(7),
            ..(*kept[0].origin).clone()
        };
        kept[0].origin = Arc::new(origin);
        assert_eq!(lasting(&kept), kept[1..]);
    }
}
