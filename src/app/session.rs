//! Sessions: one versioned file, written to a temporary file and renamed. An unreadable
//! one is kept and named, never overwritten by defaults.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::model::drive::{VoltageTable, Waveform};
use crate::model::preset::Preset;
use crate::recording::align::Alignment;
use crate::recording::csv::ImportSettings;

use super::first_start;
use super::setup::{DriveChoice, Overlay, Setup, View};

/// Version that is written.
const FORMAT: u32 = 1;

/// A session that cannot be saved or opened.
#[derive(Debug, Error)]
pub enum SessionError {
    /// The file cannot be read or written.
    #[error("{}: {source}; check that the folder exists and can be written", path.display())]
    Io {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The file is no session of this version.
    #[error("{}: {reason}; the file is left as it is", path.display())]
    Unreadable { path: PathBuf, reason: String },
}

/// The file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    impactscope_session: u32,
    duration: f64,
    locked: BTreeSet<String>,
    drive: DriveEntry,
    /// The device as a preset's text, which has its own checks.
    preset: String,
    view: View,
    #[serde(default)]
    recording: Vec<RecordingEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DriveEntry {
    Waveform(String),
    Chirp {
        text: String,
        sweep: f64,
    },
    Table {
        name: String,
        time: Vec<f64>,
        voltage: Vec<f64>,
    },
    Recorded(u64),
}

/// A recording that a session refers to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingEntry {
    /// Its number in the session.
    pub id: u64,
    /// Where it is; none for the shipped one.
    pub path: Option<PathBuf>,
    /// Hash of its bytes when it was loaded.
    pub sha256: Option<String>,
    /// How its columns are read.
    pub import: ImportSettings,
    /// Shift and scale.
    pub alignment: Alignment,
    /// Whether it is drawn.
    pub visible: bool,
    /// Place in the palette.
    pub color: usize,
}

/// A session read from its file, its recordings not yet.
#[derive(Debug)]
pub struct Loaded {
    /// Everything but the recordings from files.
    pub setup: Setup,
    /// How it was looked at.
    pub view: View,
    /// Recordings to import.
    pub recordings: Vec<RecordingEntry>,
}

/// Writes bytes to a file so that it is either whole or as before.
///
/// # Errors
/// [`SessionError::Io`].
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SessionError> {
    let fail = |source| SessionError::Io {
        path: path.to_owned(),
        source,
    };
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let temporary = path.with_file_name(name);
    let mut file = std::fs::File::create(&temporary).map_err(fail)?;
    file.write_all(bytes).map_err(fail)?;
    file.sync_all().map_err(fail)?;
    drop(file);
    std::fs::rename(&temporary, path).map_err(fail)
}

/// Saves a session.
///
/// # Errors
/// [`SessionError`].
pub fn save(path: &Path, setup: &Setup, view: &View) -> Result<(), SessionError> {
    let text = to_text(setup, view).map_err(|reason| SessionError::Unreadable {
        path: path.to_owned(),
        reason,
    })?;
    write_atomically(path, text.as_bytes())
}

fn to_text(setup: &Setup, view: &View) -> Result<String, String> {
    let drive = match &setup.drive {
        DriveChoice::Recorded(id) => DriveEntry::Recorded(*id),
        DriveChoice::Waveform(Waveform::Table(table)) => {
            let (time, voltage) = table.points();
            DriveEntry::Table {
                name: table.name.clone(),
                time: time.to_vec(),
                voltage: voltage.to_vec(),
            }
        }
        DriveChoice::Waveform(waveform @ Waveform::Chirp { duration, .. }) => DriveEntry::Chirp {
            text: waveform.to_string(),
            sweep: *duration,
        },
        DriveChoice::Waveform(waveform) => DriveEntry::Waveform(waveform.to_string()),
    };
    let entry = |overlay: &Overlay| RecordingEntry {
        id: overlay.id,
        path: overlay.recording.path.clone(),
        sha256: overlay.recording.sha256.clone(),
        import: overlay.import.clone(),
        alignment: overlay.alignment,
        visible: overlay.visible,
        color: overlay.color,
    };
    let file = File {
        impactscope_session: FORMAT,
        duration: setup.duration,
        locked: setup.locked.clone(),
        drive,
        preset: setup.preset.to_toml(),
        view: view.clone(),
        recording: setup.overlays.iter().map(entry).collect(),
    };
    toml::to_string(&file).map_err(|error| error.to_string())
}

/// Whether a TOML file is a session rather than a preset.
pub fn is_session(path: &Path) -> bool {
    path.to_string_lossy().ends_with(".impactscope.toml")
        || std::fs::read_to_string(path).is_ok_and(|text| text.contains("impactscope_session"))
}

/// Reads a session; its recordings are left to be imported.
///
/// # Errors
/// [`SessionError`].
pub fn load(path: &Path) -> Result<Loaded, SessionError> {
    let text = std::fs::read_to_string(path).map_err(|source| SessionError::Io {
        path: path.to_owned(),
        source,
    })?;
    let mut loaded = from_text(&text).map_err(|reason| SessionError::Unreadable {
        path: path.to_owned(),
        reason,
    })?;
    // A session that moved together with its recordings still finds them.
    let folder = path.parent().unwrap_or(Path::new(""));
    for entry in &mut loaded.recordings {
        if let Some(file) = &entry.path
            && !file.exists()
            && let Some(name) = file.file_name()
        {
            let beside = folder.join(name);
            if beside.exists() {
                entry.path = Some(beside);
            }
        }
    }
    Ok(loaded)
}

fn from_text(text: &str) -> Result<Loaded, String> {
    let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
    if file.impactscope_session != FORMAT {
        return Err(format!(
            "session format {} is not known to this version, which reads {FORMAT}",
            file.impactscope_session
        ));
    }
    if !(file.duration > 0.0 && file.duration.is_finite()) {
        return Err(format!("the span {} s is no time", file.duration));
    }
    let preset =
        Preset::parse("device in the session", &file.preset).map_err(|error| error.to_string())?;
    let parse = |text: &str, sweep| Waveform::parse(text, sweep).map_err(|error| error.to_string());
    let drive = match file.drive {
        DriveEntry::Recorded(id) => DriveChoice::Recorded(id),
        DriveEntry::Waveform(text) => DriveChoice::Waveform(parse(&text, file.duration)?),
        DriveEntry::Chirp { text, sweep } => DriveChoice::Waveform(parse(&text, sweep)?),
        DriveEntry::Table {
            name,
            time,
            voltage,
        } => {
            let table = VoltageTable::new(name, time, voltage, 0.0).map_err(|e| e.to_string())?;
            DriveChoice::Waveform(Waveform::Table(Arc::new(table)))
        }
    };
    let (shipped, recordings): (Vec<_>, Vec<_>) = file
        .recording
        .into_iter()
        .partition(|entry| entry.path.is_none());
    let overlays = shipped
        .into_iter()
        .filter_map(|entry| {
            let mut overlay = first_start::made_up(entry.id)?;
            overlay.alignment = entry.alignment;
            overlay.visible = entry.visible;
            overlay.color = entry.color;
            Some(overlay)
        })
        .collect();
    Ok(Loaded {
        setup: Setup {
            preset,
            drive,
            duration: file.duration,
            locked: file.locked,
            overlays,
        },
        view: file.view,
        recordings,
    })
}

/// Copies an unreadable file to the first free `NAME.unreadable-N` and returns that path.
///
/// # Errors
/// [`SessionError::Io`].
pub fn keep_unreadable(path: &Path) -> Result<PathBuf, SessionError> {
    let kept = (1..)
        .map(|n| {
            let mut name = path.file_name().unwrap_or_default().to_owned();
            name.push(format!(".unreadable-{n}"));
            path.with_file_name(name)
        })
        .find(|kept| !kept.exists())
        .unwrap_or_else(|| path.with_extension("unreadable"));
    std::fs::copy(path, &kept).map_err(|source| SessionError::Io {
        path: kept.clone(),
        source,
    })?;
    Ok(kept)
}

/// Folder of autosave, recent files and remembered imports; made if missing. The
/// environment variable `IMPACTSCOPE_DATA_DIR` names another.
pub fn data_dir() -> Option<PathBuf> {
    let folder = match std::env::var_os("IMPACTSCOPE_DATA_DIR") {
        Some(folder) => PathBuf::from(folder),
        None => directories::ProjectDirs::from("", "", "impactscope")?
            .data_dir()
            .to_owned(),
    };
    std::fs::create_dir_all(&folder).ok()?;
    Some(folder)
}

/// The autosaved session.
pub fn autosave_path() -> Option<PathBuf> {
    Some(data_dir()?.join("autosave.impactscope.toml"))
}

/// Files opened last and how recordings were read, remembered between starts.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct Memory {
    recent: Vec<PathBuf>,
    import: Vec<(PathBuf, ImportSettings)>,
}

impl Memory {
    fn load() -> Self {
        // Losing this list loses nothing of the person's work.
        data_dir()
            .and_then(|folder| std::fs::read_to_string(folder.join("memory.json")).ok())
            .and_then(|text| serde_json::from_str(&text).ok())
            .unwrap_or_default()
    }

    fn save(&self) {
        if let (Some(folder), Ok(text)) = (data_dir(), serde_json::to_string(self))
            && let Err(error) = write_atomically(&folder.join("memory.json"), text.as_bytes())
        {
            log::warn!("{error}");
        }
    }
}

/// Files opened last, newest first.
pub fn recent() -> Vec<PathBuf> {
    Memory::load().recent
}

/// Puts a file at the top of the recent ones, and remembers how it was read.
pub fn remember(path: &Path, settings: Option<&ImportSettings>) {
    let mut memory = Memory::load();
    memory.recent.retain(|known| known != path);
    memory.recent.insert(0, path.to_owned());
    memory.recent.truncate(12);
    if let Some(settings) = settings {
        memory.import.retain(|(known, _)| known != path);
        memory.import.insert(0, (path.to_owned(), settings.clone()));
        memory.import.truncate(100);
    }
    memory.save();
}

/// How a recording was read last time.
pub fn import_settings_for(path: &Path) -> Option<ImportSettings> {
    let memory = Memory::load();
    memory
        .import
        .into_iter()
        .find(|(known, _)| known == path)
        .map(|(_, settings)| settings)
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
