//! Saves and opens sessions. A session is one versioned file, written to a temporary file
//! and renamed. An unreadable one is reported and never overwritten by defaults.

use std::path::{Path, PathBuf};

use super::atomic_write::{SessionError, data_dir, write_atomically};
use super::recent;
use super::session_text;
use super::session_text::{Loaded, RecordingEntry, TextError};
use crate::app::setup::current_setup::Setup;
use crate::app::setup::view::View;
use crate::atomic_write::folder_of;

/// Saves a session. `missing` are its recordings whose files could not be loaded this time;
/// they stay in the session.
///
/// # Errors
/// `SessionError::Io`, `SessionError::Unwritable`.
pub fn save(
    path: &Path,
    setup: &Setup,
    view: &View,
    missing: &[RecordingEntry],
) -> Result<(), SessionError> {
    let text = text(path, setup, view, missing)?;
    write_atomically(path, text.as_bytes())
}

/// Saves a session with its results, which are lines of comments.
///
/// # Errors
/// Those of [`save`].
pub fn save_with_results(
    path: &Path,
    setup: &Setup,
    view: &View,
    missing: &[RecordingEntry],
    results: &str,
) -> Result<(), SessionError> {
    let mut text = text(path, setup, view, missing)?;
    text.push('\n');
    text.push_str(results);
    write_atomically(path, text.as_bytes())
}

/// The text of a session that is saved as `path`; nothing is written.
///
/// # Errors
/// `SessionError::Unwritable`.
pub fn text(
    path: &Path,
    setup: &Setup,
    view: &View,
    missing: &[RecordingEntry],
) -> Result<String, SessionError> {
    session_text::to_text(setup, view, missing, folder_of(path)).map_err(|reason| {
        SessionError::Unwritable {
            path: path.to_owned(),
            reason,
        }
    })
}

/// Whether a file is a session rather than a preset.
pub fn is_session(path: &Path) -> bool {
    path.to_string_lossy().ends_with(".impactscope.toml")
        || std::fs::read(path).is_ok_and(|bytes| {
            let setup = &bytes[..session_text::results_start(&bytes)];
            session_text::has_version_key(&String::from_utf8_lossy(setup))
        })
}

/// Reads a session; its recordings are imported later. A recording that is no longer at its
/// path is looked for at its relative path, then in the session's folder.
///
/// # Errors
/// `SessionError`; the file is never changed.
pub fn load(path: &Path) -> Result<Loaded, SessionError> {
    let fail = |source| SessionError::Io {
        path: path.to_owned(),
        source,
    };
    let bytes = std::fs::read(path).map_err(fail)?;
    // Damage in the results does not cost the setup.
    let (setup, results) = bytes.split_at(session_text::results_start(&bytes));
    let setup = std::str::from_utf8(setup).map_err(|error| SessionError::Unreadable {
        path: path.to_owned(),
        reason: format!("byte {} is not UTF-8 text", error.valid_up_to()),
    })?;
    let text = [setup, &String::from_utf8_lossy(results)].concat();
    parse(path, &text)
}

/// Reads the text of the session `path`, like [`load`].
///
/// # Errors
/// `SessionError`.
pub fn parse(path: &Path, text: &str) -> Result<Loaded, SessionError> {
    let mut loaded = session_text::from_text(text).map_err(|error| match error {
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

/// Where a session's recording is now, if its path no longer exists.
fn find(entry: &RecordingEntry, folder: &Path) -> Option<PathBuf> {
    let path = entry.path.as_ref()?;
    if path.exists() {
        return None;
    }
    let same_folder = path.file_name().map(PathBuf::from);
    [entry.relative.clone(), same_folder]
        .into_iter()
        .flatten()
        .map(|place| folder.join(place))
        .find(|place| place.exists())
}

/// Folder of the autosaved sessions, with what interrupted writings left of the program's
/// other files swept. Each test has a folder of its own, so that windows of other tests are
/// no other windows of its person.
pub fn autosave_folder() -> Option<PathBuf> {
    let mut folder = data_dir()?;
    if cfg!(test) {
        folder.push(format!("{:?}", std::thread::current().id()));
        std::fs::create_dir_all(&folder).ok()?;
    }
    recent::sweep(&folder);
    Some(folder)
}

/// Whether a file is in the folder of the autosaved sessions.
pub fn is_autosaved(path: &Path) -> bool {
    let own = data_dir().and_then(|folder| folder.canonicalize().ok());
    let folder = folder_of(path).canonicalize().ok();
    own.is_some() && own == folder
}

/// Name of the file of the `number`th window's autosaved session, from 1.
pub fn autosave_file(number: usize) -> String {
    match number {
        1 => "autosave.impactscope.toml".to_owned(),
        _ => format!("autosave-{number}.impactscope.toml"),
    }
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
