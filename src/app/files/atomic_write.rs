//! TODO-doc

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::session_text::FORMAT;
use crate::atomic_write;

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

/// Writes bytes to a file so that it is either whole or as before, also after a cut in
/// the power supply.
///
/// # Errors
/// [`SessionError::Io`]; nothing is left behind then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SessionError> {
    atomic_write::write_atomically(path, bytes).map_err(|source| SessionError::Io {
        path: path.to_owned(),
        source,
    })
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
