//! What interrupted writings left behind: the temporary files of [`write_atomically`] of
//! processes that were killed.
//!
//! [`write_atomically`]: crate::atomic_write::write_atomically

use std::path::Path;
use std::time::Duration;

use crate::atomic_write::folder_of;

/// A temporary file that an interrupted writing may have left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartFile {
    /// The process that wrote it.
    pub process: u32,
    /// Time since its last change; `None` where the system does not say.
    pub age: Option<Duration>,
}

/// A part file that is younger may still be written, by a process that cannot be seen from
/// here: a container, or another machine with the same folder.
const MIN_ABANDONED_AGE: Duration = Duration::from_secs(60);
/// No file takes so long to be written, whichever process seems to be at it: its number may
/// be in use again.
const MAX_WRITING_TIME: Duration = Duration::from_secs(24 * 3600);

impl PartFile {
    /// Whether nobody writes to it any more: the process has ended a while ago, or the file
    /// is very old.
    pub fn is_abandoned(&self) -> bool {
        let ended = if cfg!(target_os = "linux") {
            !Path::new("/proc").join(self.process.to_string()).exists()
        } else {
            // Unknown here, so that only the age counts.
            false
        };
        self.age
            .is_some_and(|age| age > MAX_WRITING_TIME || (ended && age > MIN_ABANDONED_AGE))
    }
}

/// Removes the temporary files of `path` that `is_leftover` says nobody writes any more. Only
/// names that `write_atomically` gives are touched. Returns how many there were; what cannot
/// be removed stays.
pub fn sweep_parts(path: &Path, is_leftover: impl Fn(&PartFile) -> bool) -> usize {
    let (Some(name), Ok(entries)) = (
        path.file_name().and_then(|name| name.to_str()),
        std::fs::read_dir(folder_of(path)),
    ) else {
        return 0;
    };
    let mut removed = 0;
    for entry in entries.flatten() {
        let found = entry.file_name();
        let process = found.to_str().and_then(|found| process_of(found, name));
        let Some(process) = process else { continue };
        let changed = entry.metadata().and_then(|m| m.modified()).ok();
        let part = PartFile {
            process,
            age: changed.and_then(|time| time.elapsed().ok()),
        };
        let is_own = process == std::process::id();
        if !is_own && is_leftover(&part) && std::fs::remove_file(entry.path()).is_ok() {
            removed += 1;
        }
    }
    removed
}

/// The process in the name `found` of a temporary file of `name`; `None` for other files.
fn process_of(found: &str, name: &str) -> Option<u32> {
    let (process, turn) = found
        .strip_prefix(name)?
        .strip_prefix('.')?
        .strip_suffix(".part")?
        .split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (is_number(process) && is_number(turn))
        .then(|| process.parse().ok())
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::super::part_files::*;
    use crate::atomic_write::write_atomically;

    #[test]
    fn only_part_files_of_the_same_file_are_swept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        write_atomically(&path, b"whole").unwrap();
        let own = format!("a.toml.{}-7.part", std::process::id());
        let kept = [
            own.as_str(),
            "b.toml.4294967294-0.part",
            "a.toml.4294967294.part",
            "a.toml.x-0.part",
            "a.toml.4294967294-.part",
            "a.toml.99999999999-0.part",
            "a.toml.part",
            "a.toml",
        ];
        let swept = ["a.toml.4294967294-0.part", "a.toml.4294967293-12.part"];
        for name in kept.iter().chain(&swept).filter(|name| **name != "a.toml") {
            std::fs::write(folder.path().join(name), b"ha").unwrap();
        }
        assert_eq!(sweep_parts(&path, |_| false), 0);
        // Such a process does not exist, but it has only just written.
        assert_eq!(sweep_parts(&path, PartFile::is_abandoned), 0);
        assert_eq!(sweep_parts(&path, |_| true), swept.len());
        let mut left: Vec<String> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        let mut kept = kept.map(str::to_owned);
        kept.sort();
        assert_eq!(left, kept);
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
    }

    #[test]
    fn a_part_file_is_abandoned_when_its_process_has_ended_or_it_is_very_old() {
        let part = |process, seconds| PartFile {
            process,
            age: Some(Duration::from_secs(seconds)),
        };
        let (ended, living) = (4_294_967_294, std::process::id());
        assert!(!part(ended, 5).is_abandoned());
        assert!(!part(living, 3600).is_abandoned());
        assert!(part(living, 48 * 3600).is_abandoned());
        assert!(part(ended, 48 * 3600).is_abandoned());
        if cfg!(target_os = "linux") {
            assert!(part(ended, 3600).is_abandoned());
        }
        let unknown = PartFile {
            process: ended,
            age: None,
        };
        assert!(!unknown.is_abandoned());
    }
}
