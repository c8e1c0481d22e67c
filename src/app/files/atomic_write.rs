//! Writes files so that a crash or power cut never leaves half a file, and keeps copies of
//! files that cannot be read. Also what can go wrong with a session, and the folder of the
//! program's own files.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::session_text::FORMAT_VERSION;
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
        "{}: the session has format {found}, this version reads {FORMAT_VERSION}; open it with the version that wrote it",
        path.display()
    )]
    ForeignVersion { path: PathBuf, found: i64 },
    /// The file is damaged, or no session.
    #[error("{}: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },
    /// The session holds something that cannot be written to a file.
    #[error("{}: the session cannot be written: {reason}", path.display())]
    Unwritable { path: PathBuf, reason: String },
}

/// Writes bytes to a file so that it is either complete or unchanged, even after a power
/// cut.
///
/// # Errors
/// [`SessionError::Io`]; no temporary file remains.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SessionError> {
    atomic_write::write_atomically(path, bytes).map_err(|source| SessionError::Io {
        path: path.to_owned(),
        source,
    })
}

/// Copies an unreadable file to the first free `NAME.unreadable-N` and returns that path.
///
/// # Errors
/// [`SessionError::Io`]; no part of a copy remains.
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
        let copy = path.with_file_name(name);
        match std::fs::File::create_new(&copy) {
            Ok(mut to) => {
                let copied = std::io::copy(&mut from, &mut to).and_then(|_| to.sync_all());
                drop(to);
                return match copied {
                    Ok(()) => Ok(copy),
                    Err(error) => {
                        // Half of a copy, as on a full disk, passes for the whole file.
                        let _ = std::fs::remove_file(&copy);
                        Err(fail(&copy, error))
                    }
                };
            }
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => n += 1,
            Err(error) => return Err(fail(&copy, error)),
        }
    }
}

/// Folder of the autosaved session and of the recent files; created if missing. The
/// environment variable `IMPACTSCOPE_DATA_DIR` names another.
pub fn data_dir() -> Option<PathBuf> {
    let folder = if cfg!(test) {
        // Tests neither read nor change the person's files.
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
