//! The text of a session file: writing and reading it.

use std::collections::{BTreeSet, HashSet};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::built_in;
use crate::app::setup::current_setup::{DiagnosisChoices, Setup};
use crate::app::setup::drive_text::{DriveEntry, OwnDriveEntry};
use crate::app::setup::explore::ExploreChoices;
use crate::app::setup::kept_curve::{KeptCurve, lasting, of_session};
use crate::app::setup::overlay::{Estimates, Overlay, Role};
use crate::app::setup::own_drive::OwnDrive;
use crate::app::setup::view::View;
use crate::model::preset::Preset;
use crate::model::preset::toml_fault::{TomlFault, short_reason};
use crate::recording::align::Alignment;
use crate::recording::csv::ImportSettings;

/// Version of the format that is written and read.
pub const FORMAT_VERSION: u32 = 1;
/// The key that distinguishes a session from a preset; its value is the version.
pub const VERSION_KEY: &str = "impactscope_session";

/// Begins the results, which stand behind the setup as comments: a damaged one does not cost
/// the setup.
pub const RESULTS_MARK: &str = "#@ results ";

/// Largest number of a recording. Counting on from it stays within what a file can hold.
const MAX_RECORDING_NUMBER: u64 = 1 << 48;

/// Why a text is no session that can be opened.
#[derive(Debug, Clone, PartialEq)]
pub enum TextError {
    /// A session of another version.
    ForeignVersion(i64),
    /// Damaged, or no session; the text says what is wrong.
    Damaged(String),
}

/// The file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    impactscope_session: u32,
    duration: f64,
    locked: BTreeSet<String>,
    drive: DriveEntry,
    /// The device as the text of a preset, which checks itself when it is read.
    preset: String,
    /// The preset that a reset goes back to; the device itself if absent.
    #[serde(default)]
    original: Option<String>,
    view: View,
    /// Number of recordings, to notice a file that was cut off before them.
    #[serde(default)]
    recordings: Option<usize>,
    #[serde(default)]
    recording: Vec<RecordingEntry>,
    /// Curves kept to compare with.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    kept: Vec<KeptCurve>,
    /// What a diagnosis is asked.
    #[serde(default, skip_serializing_if = "DiagnosisChoices::is_usual")]
    diagnosis: DiagnosisChoices,
    /// What was chosen in the Explore workspace.
    #[serde(default, skip_serializing_if = "ExploreChoices::is_usual")]
    explore: ExploreChoices,
}

/// A recording that a session refers to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingEntry {
    /// Its number in the session.
    pub id: u64,
    /// Its path; none for a built-in recording.
    pub path: Option<PathBuf>,
    /// Its path relative to the session's folder, for sessions that are moved.
    #[serde(default)]
    pub relative: Option<PathBuf>,
    /// Hash of its bytes when it was loaded.
    pub sha256: Option<String>,
    /// Whether it is a made-up recording that comes with the program.
    #[serde(default)]
    pub made_up: bool,
    /// How its columns are read.
    pub import: ImportSettings,
    /// Shift and scale.
    pub alignment: Alignment,
    /// What drives its own run, if it is not its measured voltage as recognised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<OwnDriveEntry>,
    /// What of its instrument is estimated.
    #[serde(default)]
    pub estimates: Estimates,
    /// Whether it is drawn.
    pub visible: bool,
    /// Index into the palette.
    pub color: usize,
    /// What it is used for; `None` until a person has chosen.
    #[serde(default)]
    pub role: Option<Role>,
    /// Its name, by which a built-in one is found.
    #[serde(default)]
    pub name: Option<String>,
}

/// The text of a session that will be saved in `folder`, including `missing` recordings.
///
/// # Errors
/// What cannot be written, for example a path that is not Unicode.
pub fn to_text(
    setup: &Setup,
    view: &View,
    missing: &[RecordingEntry],
    folder: &Path,
) -> Result<String, String> {
    let file = File {
        impactscope_session: FORMAT_VERSION,
        duration: setup.duration,
        locked: setup.locked.clone(),
        drive: DriveEntry::of(&setup.drive),
        preset: setup.preset.to_toml(),
        original: (setup.preset != *setup.original).then(|| setup.original.to_toml()),
        view: view.clone(),
        recordings: Some(setup.overlays.len() + missing.len()),
        recording: setup
            .overlays
            .iter()
            .map(|overlay| entry(overlay, folder))
            .chain(missing.iter().cloned())
            .collect(),
        kept: lasting(&setup.kept),
        diagnosis: setup.diagnosis.clone(),
        explore: setup.explore.clone(),
    };
    toml::to_string(&file).map_err(|error| error.to_string())
}

fn entry(overlay: &Overlay, folder: &Path) -> RecordingEntry {
    let path = overlay
        .recording
        .path
        .as_ref()
        .map(|path| std::path::absolute(path).unwrap_or_else(|_| path.clone()));
    RecordingEntry {
        id: overlay.id,
        relative: path.as_ref().and_then(|path| relative_to(path, folder)),
        path,
        sha256: overlay.recording.sha256.clone(),
        made_up: overlay.made_up,
        import: overlay.import.clone(),
        alignment: overlay.alignment,
        drive: OwnDriveEntry::of(&overlay.drive),
        estimates: overlay.estimates,
        visible: overlay.visible,
        color: overlay.color,
        role: overlay.role,
        name: overlay
            .recording
            .path
            .is_none()
            .then(|| overlay.recording.name.clone()),
    }
}

/// `path` relative to `folder`, both absolute; `None` if they are on different drives.
fn relative_to(path: &Path, folder: &Path) -> Option<PathBuf> {
    let folder = std::path::absolute(folder).ok()?;
    let (to, from): (Vec<_>, Vec<_>) = (path.components().collect(), folder.components().collect());
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    // A `..` in the folder may pass a symbolic link, so it cannot be resolved here.
    if common == 0 || from[common..].contains(&Component::ParentDir) {
        return None;
    }
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - common);
    Some(up.chain(to[common..].iter().copied()).collect())
}

/// Whether a text has the session's key at the beginning of a line.
pub fn has_version_key(text: &str) -> bool {
    text.lines().any(|line| {
        line.trim_start()
            .strip_prefix(VERSION_KEY)
            .is_some_and(|rest| rest.trim_start().starts_with('='))
    })
}

/// Where the results begin in the bytes of a session: at their end if there are none.
pub fn results_start(bytes: &[u8]) -> usize {
    let mark = RESULTS_MARK.as_bytes();
    let mut starts = (0..bytes.len()).filter(|&i| i == 0 || bytes[i - 1] == b'\n');
    starts
        .find(|&i| bytes[i..].starts_with(mark))
        .unwrap_or(bytes.len())
}

/// Reads the text of a session.
///
/// # Errors
/// [`TextError`].
pub fn from_text(text: &str) -> Result<Loaded, TextError> {
    let (text, results) = text.split_at(results_start(text.as_bytes()));
    let damaged =
        |error: toml::de::Error| TextError::Damaged(TomlFault::new(text, &error).to_string());
    // The version is checked first: another version may have other keys.
    let table: toml::Table = toml::from_str(text).map_err(damaged)?;
    match table.get(VERSION_KEY).and_then(toml::Value::as_integer) {
        None => {
            return Err(TextError::Damaged(format!(
                "this is not a session: it has no {VERSION_KEY}"
            )));
        }
        Some(version) if version != i64::from(FORMAT_VERSION) => {
            return Err(TextError::ForeignVersion(version));
        }
        Some(_) => {}
    }
    // Parsed from the text again, so that an error names its line.
    let file: File = toml::from_str(text).map_err(damaged)?;
    let loaded = loaded(file).map_err(|reason| TextError::Damaged(short_reason(&reason)))?;
    Ok(Loaded {
        results: results.to_owned(),
        ..loaded
    })
}

fn loaded(mut file: File) -> Result<Loaded, String> {
    check(&file)?;
    file.kept.extend(file.view.formerly_kept.take());
    let kept = of_session(file.kept)?;
    renumber(&mut file.recording);
    let preset =
        Preset::parse("device in the session", &file.preset).map_err(|error| error.to_string())?;
    let original = match &file.original {
        Some(text) => Preset::parse("original device in the session", text)
            .map_err(|error| error.to_string())?,
        None => preset.clone(),
    };
    let drive = file.drive.read(file.duration)?;
    let (shipped, recordings): (Vec<_>, Vec<_>) = file
        .recording
        .into_iter()
        .partition(|entry| entry.path.is_none());
    let mut missing = Vec::new();
    let mut overlays = Vec::new();
    for entry in shipped {
        match built_in::shipped(entry.name.as_deref(), entry.id) {
            Some(overlay) => overlays.push(Overlay {
                alignment: entry.alignment,
                drive: own_drive(entry.drive.as_ref(), file.duration)?,
                estimates: entry.estimates,
                visible: entry.visible,
                color: entry.color,
                role: entry.role,
                ..overlay
            }),
            None => missing.push(format!(
                "recording {} has no file and cannot be shown; load it again",
                entry.id
            )),
        }
    }
    Ok(Loaded {
        setup: Setup {
            preset,
            original: Arc::new(original),
            drive,
            duration: file.duration,
            locked: file.locked,
            overlays,
            kept,
            diagnosis: file.diagnosis,
            explore: file.explore,
        },
        view: file.view,
        recordings,
        missing,
        results: String::new(),
    })
}

/// The drive of a recording's own run, as a session has it.
///
/// # Errors
/// What is wrong with it.
pub fn own_drive(entry: Option<&OwnDriveEntry>, duration: f64) -> Result<OwnDrive, String> {
    entry.map_or_else(|| Ok(OwnDrive::default()), |e| e.clone().read(duration))
}

/// Gives recordings with a number already taken a new one, so that a session with duplicate
/// numbers can still be opened. A recorded drive then means the first of them.
fn renumber(recordings: &mut [RecordingEntry]) {
    let mut known = HashSet::new();
    let mut next = recordings.iter().map(|entry| entry.id).max().unwrap_or(0);
    for entry in recordings {
        if !known.insert(entry.id) {
            next = next.saturating_add(1);
            entry.id = next;
            known.insert(next);
        }
    }
}

/// Rejects numbers that would cause errors later.
fn check(file: &File) -> Result<(), String> {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    if !positive(file.duration) {
        return Err(format!("the span of {} s is invalid", file.duration));
    }
    if let Some(longest) = file.diagnosis.longest.filter(|longest| !positive(*longest)) {
        return Err(format!(
            "the longest time of a diagnosis of {longest} s is invalid"
        ));
    }
    if !positive(file.view.slow_down) {
        return Err(format!("the slow-down {} is invalid", file.view.slow_down));
    }
    if let Some((start, end)) = file.view.time_range
        && !(start.is_finite() && end.is_finite() && start < end)
    {
        return Err(format!(
            "the time range in view, {start} s to {end} s, is empty"
        ));
    }
    for (name, (low, high)) in &file.view.value_ranges {
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(format!(
                "the range of values in view of {name}, {low} to {high}, is empty"
            ));
        }
    }
    let found = file.recording.len();
    if let Some(expected) = file.recordings
        && expected != found
    {
        return Err(format!(
            "the file is truncated: it has {found} of {expected} recordings"
        ));
    }
    let drive = match file.drive {
        DriveEntry::Recorded(id) => Some(id),
        _ => None,
    };
    let ids = file.recording.iter().map(|entry| entry.id).chain(drive);
    if let Some(id) = ids.filter(|id| *id > MAX_RECORDING_NUMBER).max() {
        return Err(format!(
            "there is no recording number {id}; the largest is {MAX_RECORDING_NUMBER}"
        ));
    }
    for entry in &file.recording {
        let a = &entry.alignment;
        let numbers = [
            a.time_shift,
            a.xp_scale,
            a.xp_offset,
            a.xc_scale,
            a.xc_offset,
            a.voltage_scale,
        ];
        if !numbers.iter().all(|value| value.is_finite()) {
            return Err(format!(
                "the alignment of recording {} is not a number",
                entry.id
            ));
        }
    }
    Ok(())
}

/// A session read from its file; its recordings are not read yet.
#[derive(Debug)]
pub struct Loaded {
    /// The setup, without the recordings that come from files.
    pub setup: Setup,
    /// The view.
    pub view: View,
    /// Recordings to import.
    pub recordings: Vec<RecordingEntry>,
    /// What could not be restored and what to do, for the window.
    pub missing: Vec<String>,
    /// The lines of results, not read yet.
    pub results: String,
}

impl Loaded {
    /// The highest number of any recording; new ones are numbered from it.
    pub fn last_id(&self) -> u64 {
        let shown = self.setup.overlays.iter().map(|overlay| overlay.id);
        let to_come = self.recordings.iter().map(|entry| entry.id);
        shown.chain(to_come).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::session_text::*;

    #[test]
    fn paths_are_relative_to_the_folder_of_the_session() {
        let relative = |path: &str, folder: &str| relative_to(Path::new(path), Path::new(folder));
        assert_eq!(relative("/a/b/c.csv", "/a/b"), Some(PathBuf::from("c.csv")));
        assert_eq!(
            relative("/a/c.csv", "/a/b"),
            Some(PathBuf::from("../c.csv"))
        );
        assert_eq!(
            relative("/x/y/c.csv", "/a/b"),
            Some(PathBuf::from("../../x/y/c.csv"))
        );
        assert_eq!(relative("/x/c.csv", "/a/../b"), None);
    }

    #[test]
    fn a_damaged_line_of_half_a_megabyte_gives_a_short_message() {
        let long = "x".repeat(467_000);
        for text in [
            format!("impactscope_session = 1 {long}"),
            format!("impactscope_session = \"{long}"),
            format!("impactscope_session = 1\nduration = \"{long}\""),
            format!("impactscope_session = 1\n{long} = \"\\u001b\""),
            format!("{long} = 1"),
        ] {
            let Err(TextError::Damaged(said)) = from_text(&text) else {
                panic!("it was read");
            };
            assert!(said.len() < 1500, "{} bytes", said.len());
            assert!(!said.contains(char::is_control), "{said:?}");
        }
    }

    #[test]
    fn a_recording_number_that_no_file_could_hold_is_refused() {
        let setup = built_in::setup();
        let text = to_text(&setup, &View::default(), &[], Path::new("/a")).unwrap();
        assert!(from_text(&text).is_ok());
        let huge = text.replacen("\nid = ", "\nid = 922337203685477580", 1);
        assert_ne!(huge, text, "the first setup has a recording");
        let Err(TextError::Damaged(said)) = from_text(&huge) else {
            panic!("it was read");
        };
        assert!(
            said.contains("recording number 922337203685477580"),
            "{said}"
        );
    }

    #[test]
    fn the_version_key_is_not_found_in_a_comment() {
        assert!(has_version_key("# mine\nimpactscope_session = 1\n"));
        assert!(!has_version_key("# made from an impactscope_session = 1\n"));
        assert!(!has_version_key("impactscope_sessions = 1"));
    }
}
