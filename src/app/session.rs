//! Sessions: one versioned file, written to a temporary file and renamed. An unreadable
//! one is kept and named, never overwritten by defaults.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::session_file::{self, FORMAT, TextError};
use super::setup::{Setup, View};
use crate::atomic_write::{self, folder_of};

pub use super::memory::{import_settings_for, recent, remember, remember_import};
pub use super::session_file::RecordingEntry;

/// A session that cannot be saved or opened.
#[derive(Debug, Error)]
#[allow(missing_docs)] // The fields are the file and what is wrong with it.
pub enum SessionError {
    /// The file cannot be read or written.
    #[error("{}: {source}; check that the folder exists and can be written", path.display())]
    Io {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The session was written by another version of the program.
    #[error(
        "{}: the session has format {found}, this version reads {FORMAT}; open it with the version that wrote it",
        path.display()
    )]
    ForeignVersion { path: PathBuf, found: i64 },
    /// The file is damaged, or no session.
    #[error("{}: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },
    /// Something in the session has no form in a file.
    #[error("{}: the session cannot be written: {reason}", path.display())]
    Unwritable { path: PathBuf, reason: String },
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
    /// What could not be brought back, with the remedy: lines for the window.
    pub missing: Vec<String>,
}

impl Loaded {
    /// The highest number of any recording, to number new ones from.
    pub fn last_id(&self) -> u64 {
        let shown = self.setup.overlays.iter().map(|overlay| overlay.id);
        let to_come = self.recordings.iter().map(|entry| entry.id);
        shown.chain(to_come).max().unwrap_or(0)
    }
}

/// Writes bytes to a file so that it is either whole or as before.
///
/// # Errors
/// [`SessionError::Io`]; nothing is left behind then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SessionError> {
    atomic_write::write_atomically(path, bytes).map_err(|source| SessionError::Io {
        path: path.to_owned(),
        source,
    })
}

/// Saves a session. `absent` are recordings of it that could not be loaded this time:
/// they stay in it.
///
/// # Errors
/// [`SessionError::Io`], [`SessionError::Unwritable`].
pub fn save(
    path: &Path,
    setup: &Setup,
    view: &View,
    absent: &[RecordingEntry],
) -> Result<(), SessionError> {
    let text = session_file::to_text(setup, view, absent, folder_of(path)).map_err(|reason| {
        SessionError::Unwritable {
            path: path.to_owned(),
            reason,
        }
    })?;
    write_atomically(path, text.as_bytes())
}

/// Whether a file is a session rather than a preset.
pub fn is_session(path: &Path) -> bool {
    path.to_string_lossy().ends_with(".impactscope.toml")
        || std::fs::read_to_string(path).is_ok_and(|text| session_file::has_marker(&text))
}

/// Reads a session; its recordings are left to be imported. One that is not where it was
/// is looked for as seen from the session's folder, then beside the session.
///
/// # Errors
/// [`SessionError`]; the file is never changed.
pub fn load(path: &Path) -> Result<Loaded, SessionError> {
    let fail = |source| SessionError::Io {
        path: path.to_owned(),
        source,
    };
    let bytes = std::fs::read(path).map_err(fail)?;
    let text = String::from_utf8(bytes).map_err(|error| SessionError::Unreadable {
        path: path.to_owned(),
        reason: format!(
            "byte {} is not UTF-8 text",
            error.utf8_error().valid_up_to()
        ),
    })?;
    let mut loaded = session_file::from_text(&text).map_err(|error| match error {
        TextError::ForeignVersion(found) => SessionError::ForeignVersion {
            path: path.to_owned(),
            found,
        },
        TextError::Damaged(reason) => SessionError::Unreadable {
            path: path.to_owned(),
            reason,
        },
    })?;
    let folder = folder_of(path);
    for entry in &mut loaded.recordings {
        if let Some(found) = find(entry, folder) {
            entry.path = Some(found);
        }
    }
    Ok(loaded)
}

/// Where a session's recording is now, if not where it was.
fn find(entry: &RecordingEntry, folder: &Path) -> Option<PathBuf> {
    let path = entry.path.as_ref()?;
    if path.exists() {
        return None;
    }
    let beside = path.file_name().map(PathBuf::from);
    [entry.relative.clone(), beside]
        .into_iter()
        .flatten()
        .map(|place| folder.join(place))
        .find(|place| place.exists())
}

/// Copies an unreadable file to the first free `NAME.unreadable-N` and returns that path.
///
/// # Errors
/// [`SessionError::Io`].
pub fn keep_unreadable(path: &Path) -> Result<PathBuf, SessionError> {
    let fail = |path: &Path, source| SessionError::Io {
        path: path.to_owned(),
        source,
    };
    let mut from = std::fs::File::open(path).map_err(|e| fail(path, e))?;
    let mut n: u64 = 1;
    loop {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".unreadable-{n}"));
        let kept = path.with_file_name(name);
        match std::fs::File::create_new(&kept) {
            Ok(mut to) => {
                std::io::copy(&mut from, &mut to).map_err(|e| fail(&kept, e))?;
                to.sync_all().map_err(|e| fail(&kept, e))?;
                return Ok(kept);
            }
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => n += 1,
            Err(error) => return Err(fail(&kept, error)),
        }
    }
}

/// Folder of autosave, recent files and remembered imports; made if missing. The
/// environment variable `IMPACTSCOPE_DATA_DIR` names another.
pub fn data_dir() -> Option<PathBuf> {
    let folder = if cfg!(test) {
        // Tests see nothing of the person's, and leave it alone.
        std::env::temp_dir().join(format!("impactscope-test-{}", std::process::id()))
    } else {
        match std::env::var_os("IMPACTSCOPE_DATA_DIR").filter(|folder| !folder.is_empty()) {
            Some(folder) => PathBuf::from(folder),
            None => directories::ProjectDirs::from("", "", "impactscope")?
                .data_dir()
                .to_owned(),
        }
    };
    std::fs::create_dir_all(&folder).ok()?;
    Some(folder)
}

/// The autosaved session.
pub fn autosave_path() -> Option<PathBuf> {
    Some(data_dir()?.join("autosave.impactscope.toml"))
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
