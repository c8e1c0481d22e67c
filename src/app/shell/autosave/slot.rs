//! The file of a window's autosaved session. Windows that are open at the same time have
//! different ones, and a new session never replaces one that nobody opened again.
//!
//! A window holds a lock of the system on a file next to its own. The system gives it back
//! when the process ends, however it ends, so that no lock outlives its window.

use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::app::files::session::autosave_file;
use crate::part_files::sweep_parts;

/// Most files of autosaved sessions. The oldest is replaced where there are more.
const MAX_SLOTS: usize = 32;
/// Held while a window looks for its file, so that two do not find each other's locks.
const CLAIM_LOCK: &str = "autosave.claim.lock";

/// What a window begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::app::shell) enum Start {
    /// The last session that no other window has open.
    LastSession,
    /// Files named by the person: the last session stays as it is.
    Files,
}

/// The file of one window's session, locked as long as this lives.
#[derive(Debug)]
pub(in crate::app::shell) struct Slot {
    path: PathBuf,
    lock: Lock,
}

/// A lock that is held as long as this lives.
#[derive(Debug)]
struct Lock(File);

impl Drop for Lock {
    fn drop(&mut self) {
        // Closing the file is not enough while a process that was just started still has a
        // copy of it. Where this fails, the end of the process frees the lock.
        let _ = self.0.unlock();
    }
}

impl Slot {
    /// The session's file; it may not exist yet.
    pub(in crate::app::shell) fn path(&self) -> &Path {
        &self.path
    }
}

/// A file found for a window.
#[derive(Debug)]
pub(in crate::app::shell) struct Claimed {
    /// The file.
    pub(in crate::app::shell) slot: Slot,
    /// What the person should know.
    pub(in crate::app::shell) words: Option<String>,
}

/// Finds the file of a new window in `folder` and sweeps what an interrupted writing left of
/// it.
///
/// # Errors
/// Why there is none, and what to do.
pub(in crate::app::shell) fn claim(folder: &Path, start: Start) -> Result<Claimed, String> {
    let fail = |error: std::io::Error| {
        format!(
            "{}: {error}; check that the folder can be written",
            folder.display()
        )
    };
    let turn = open_lock(&folder.join(CLAIM_LOCK)).map_err(fail)?;
    // Some file systems have no locks. A session is autosaved there all the same.
    let mut has_locks = turn.lock().is_ok();
    let _turn = Lock(turn);
    // Free files with a session, when each was written; and the first that has none.
    let mut kept: Vec<(SystemTime, Slot)> = Vec::new();
    let mut unused = None;
    let mut in_use = 0;
    for number in 1..=MAX_SLOTS {
        let path = folder.join(autosave_file(number));
        let written = path.metadata().and_then(|m| m.modified()).ok();
        if written.is_none() && unused.is_some() {
            continue;
        }
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".lock");
        let lock = open_lock(&folder.join(name)).map_err(fail)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                in_use += 1;
                continue;
            }
            Err(TryLockError::Error(error)) => {
                log::warn!("{}: {error}", folder.display());
                has_locks = false;
            }
        }
        let slot = Slot {
            path,
            lock: Lock(lock),
        };
        match written {
            Some(time) => kept.push((time, slot)),
            None => unused = Some(slot),
        }
    }
    kept.sort_by_key(|(time, _)| *time);
    let mut words = Vec::new();
    let last = match start {
        Start::LastSession => kept.pop(),
        Start::Files => None,
    };
    let slot = match (last, unused, kept.is_empty()) {
        (Some((_, last)), ..) => last,
        (None, Some(unused), _) => unused,
        (None, None, false) => {
            let (_, oldest) = kept.swap_remove(0);
            words.push(format!(
                "There are {MAX_SLOTS} autosaved sessions; the oldest, {}, will be replaced by this one.",
                oldest.path.display()
            ));
            oldest
        }
        (None, None, true) => {
            return Err(format!(
                "{MAX_SLOTS} windows are open, each with its own file in {}; close one and start again",
                folder.display()
            ));
        }
    };
    if in_use > 0 {
        words.push(format!(
            "Another window is open. This one autosaves its own session, to {}.",
            slot.path.display()
        ));
    }
    if !has_locks {
        words.push(format!(
            "The file system of {} has no locks: two windows at once would autosave to the same file there. Set IMPACTSCOPE_DATA_DIR to another folder for the second.",
            folder.display()
        ));
    }
    note_process(&slot);
    // Nobody else writes to a file whose lock is held here.
    sweep_parts(&slot.path, |part| has_locks || part.is_abandoned());
    let words = (!words.is_empty()).then(|| words.join(" "));
    Ok(Claimed { slot, words })
}

/// The file of a lock; made if it is missing.
fn open_lock(path: &Path) -> std::io::Result<File> {
    File::options()
        .create(true)
        .truncate(false)
        .read(true)
        .write(true)
        .open(path)
}

/// Notes in the lock's file which process holds it, for a person who wonders.
fn note_process(slot: &Slot) {
    let mut file = &slot.lock.0;
    let noted = file
        .set_len(0)
        .and_then(|()| writeln!(file, "{}", std::process::id()));
    if let Err(error) = noted {
        log::debug!("{}: {error}", slot.path.display());
    }
}
