//! Writes files so that a crash or power cut never leaves half a file, and keeps copies of
//! files that cannot be read.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use thiserror::Error;

use super::session_text::FORMAT_VERSION;

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
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let mut name = path.file_name().unwrap_or_default().to_owned();
    // Two programs, or two threads, must not write into the same temporary file.
    let turn = COUNT.fetch_add(1, Ordering::Relaxed);
    name.push(format!(".{}-{turn}.part", std::process::id()));
    let temporary = path.with_file_name(name);
    let write = || {
        let mut file = std::fs::File::create(&temporary)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        drop(file);
        std::fs::rename(&temporary, path)
    };
    write().map_err(|source| {
        // The temporary file may not exist.
        let _ = std::fs::remove_file(&temporary);
        SessionError::Io {
            path: path.to_owned(),
            source,
        }
    })?;
    // The folder holds the file's name and has its own cache. Not every system can flush
    // it; the file is complete either way.
    #[cfg(unix)]
    if let Ok(folder) = std::fs::File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// The folder of a file; the current one for a bare name.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
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
        let copy = path.with_file_name(name);
        match std::fs::File::create_new(&copy) {
            Ok(mut to) => {
                std::io::copy(&mut from, &mut to).map_err(|e| fail(&copy, e))?;
                to.sync_all().map_err(|e| fail(&copy, e))?;
                return Ok(copy);
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
