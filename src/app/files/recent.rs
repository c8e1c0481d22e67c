//! Recent files, and how recordings were read, stored between starts in one small TOML
//! file. It holds none of the person's work; a copy of an unreadable one is kept all the
//! same.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::atomic_write::{data_dir, keep_unreadable, write_atomically};
use crate::part_files::{PartFile, sweep_parts};
use crate::recording::csv::ImportSettings;

/// Files in the list.
const MAX_RECENT: usize = 12;
/// Recordings whose import settings are stored.
const MAX_IMPORTS: usize = 100;
/// The file in the data folder.
const FILE_NAME: &str = "memory.toml";

/// Held while the file is read, changed and written, so that threads do not overwrite each
/// other's changes.
static FILE_LOCK: Mutex<()> = Mutex::new(());

#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct RecentFiles {
    recent: Vec<PathBuf>,
    import: Vec<Import>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Import {
    path: PathBuf,
    settings: ImportSettings,
}

impl RecentFiles {
    /// What the file holds; nothing if it is missing or cannot be read.
    fn load(folder: &Path) -> Self {
        std::fs::read_to_string(folder.join(FILE_NAME))
            .ok()
            .and_then(|text| toml::from_str(&text).ok())
            .unwrap_or_default()
    }

    /// Changes what the file holds; keeps a copy of a file that cannot be read.
    fn change(folder: &Path, change: impl FnOnce(&mut Self)) {
        let _lock = FILE_LOCK.lock().unwrap_or_else(PoisonError::into_inner);
        let _other_windows = lock_for_all_windows(folder);
        let path = folder.join(FILE_NAME);
        let mut list = match std::fs::read(&path) {
            Err(_) => Self::default(),
            Ok(bytes) => {
                let known = std::str::from_utf8(&bytes)
                    .ok()
                    .and_then(|text| toml::from_str(text).ok());
                known.unwrap_or_else(|| {
                    match keep_unreadable(&path) {
                        Ok(copy) => log::warn!(
                            "unreadable list of recent files, copied to {}",
                            copy.display()
                        ),
                        Err(error) => log::warn!("{error}"),
                    }
                    Self::default()
                })
            }
        };
        change(&mut list);
        let written = toml::to_string(&list)
            .map_err(|error| error.to_string())
            .and_then(|text| {
                write_atomically(&path, text.as_bytes()).map_err(|error| error.to_string())
            });
        if let Err(error) = written {
            log::warn!("the list of recent files was not saved: {error}");
        }
    }

    fn put(&mut self, path: PathBuf, settings: Option<&ImportSettings>) {
        self.recent.retain(|known| *known != path);
        self.recent.insert(0, path.clone());
        self.recent.truncate(MAX_RECENT);
        if let Some(settings) = settings {
            self.import.retain(|known| known.path != path);
            let settings = settings.clone();
            self.import.insert(0, Import { path, settings });
            self.import.truncate(MAX_IMPORTS);
        }
    }
}

/// Held while the file is changed, so that windows do not overwrite each other's changes. The
/// system frees it when its process ends. `None` on a system without locks, where the last
/// change wins.
fn lock_for_all_windows(folder: &Path) -> Option<std::fs::File> {
    let lock = std::fs::File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(folder.join(format!("{FILE_NAME}.lock")));
    let locked = lock.and_then(|file| file.lock().map(|()| file));
    locked
        .inspect_err(|error| log::debug!("the list of recent files is not locked: {error}"))
        .ok()
}

/// Removes what interrupted writings left of the file in a data folder.
pub(super) fn sweep(folder: &Path) {
    sweep_parts(&folder.join(FILE_NAME), PartFile::is_abandoned);
}

/// The absolute path, which stays the same when the current folder changes.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Recent files, newest first; at most 12.
pub fn recent() -> Vec<PathBuf> {
    data_dir().map_or_else(Vec::new, |folder| RecentFiles::load(&folder).recent)
}

/// Puts a file at the top of the recent ones and stores its import settings.
pub fn remember(path: &Path, settings: Option<&ImportSettings>) {
    if let Some(folder) = data_dir() {
        let path = absolute(path);
        RecentFiles::change(&folder, |list| list.put(path, settings));
    }
}

/// The settings with which a recording was read last time.
pub fn import_settings_for(path: &Path) -> Option<ImportSettings> {
    let path = absolute(path);
    RecentFiles::load(&data_dir()?)
        .import
        .into_iter()
        .find(|known| known.path == path)
        .map(|known| known.settings)
}

#[cfg(test)]
mod tests {
    use super::super::recent::*;

    #[test]
    fn the_last_files_come_back_newest_first() {
        let folder = tempfile::tempdir().unwrap();
        let settings = ImportSettings {
            time_offset: -0.25,
            ..ImportSettings::default()
        };
        for i in 0..15 {
            let path = PathBuf::from(format!("/data/{i}.csv"));
            RecentFiles::change(folder.path(), |list| list.put(path, Some(&settings)));
        }
        RecentFiles::change(folder.path(), |list| {
            list.put(PathBuf::from("/data/7.csv"), None)
        });
        let list = RecentFiles::load(folder.path());
        assert_eq!(list.recent.len(), MAX_RECENT);
        assert_eq!(list.recent[0], Path::new("/data/7.csv"));
        assert_eq!(list.recent[1], Path::new("/data/14.csv"));
        assert_eq!(list.import.len(), 15);
        assert!(list.import.iter().all(|i| i.settings == settings));
    }

    #[test]
    fn an_unreadable_list_is_ignored_and_kept() {
        let folder = tempfile::tempdir().unwrap();
        for damaged in [&b"recent = [\"/a"[..], &[0xff, 0xfe, 0x00]] {
            std::fs::write(folder.path().join(FILE_NAME), damaged).unwrap();
            assert_eq!(RecentFiles::load(folder.path()), RecentFiles::default());
            RecentFiles::change(folder.path(), |list| {
                list.put(PathBuf::from("/b.csv"), None)
            });
            assert_eq!(RecentFiles::load(folder.path()).recent.len(), 1);
        }
        for (n, damaged) in [(1, &b"recent = [\"/a"[..]), (2, &[0xff, 0xfe, 0x00])] {
            let kept = folder.path().join(format!("{FILE_NAME}.unreadable-{n}"));
            assert_eq!(std::fs::read(kept).unwrap(), damaged);
        }
    }
}
