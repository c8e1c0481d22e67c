//! Files opened last and how recordings were read, remembered between starts in one
//! small TOML file. Losing it loses nothing of the person's work; one that cannot be
//! read is kept all the same.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::atomic_write::{data_dir, keep_unreadable, write_atomically};
use crate::recording::csv::ImportSettings;

/// Files kept in the list.
const RECENT: usize = 12;
/// Recordings whose import is remembered.
const IMPORTS: usize = 100;
/// The file in the data folder.
const FILE: &str = "memory.toml";

/// Reading and writing again is one step, whichever thread does it.
static TURN: Mutex<()> = Mutex::new(());

#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Memory {
    recent: Vec<PathBuf>,
    import: Vec<Import>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Import {
    path: PathBuf,
    settings: ImportSettings,
}

impl Memory {
    /// What is remembered; nothing if the file is missing or cannot be read.
    fn load(folder: &Path) -> Self {
        std::fs::read_to_string(folder.join(FILE))
            .ok()
            .and_then(|text| toml::from_str(&text).ok())
            .unwrap_or_default()
    }

    /// Changes what is remembered; keeps a file that cannot be read beside the new one.
    fn change(folder: &Path, change: impl FnOnce(&mut Self)) {
        let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let path = folder.join(FILE);
        let mut memory = match std::fs::read(&path) {
            Err(_) => Self::default(),
            Ok(bytes) => {
                let known = std::str::from_utf8(&bytes)
                    .ok()
                    .and_then(|text| toml::from_str(text).ok());
                known.unwrap_or_else(|| {
                    match keep_unreadable(&path) {
                        Ok(kept) => log::warn!("unreadable, kept as {}", kept.display()),
                        Err(error) => log::warn!("{error}"),
                    }
                    Self::default()
                })
            }
        };
        change(&mut memory);
        let written = toml::to_string(&memory)
            .map_err(|error| error.to_string())
            .and_then(|text| {
                write_atomically(&path, text.as_bytes()).map_err(|error| error.to_string())
            });
        if let Err(error) = written {
            log::warn!("recent files are not remembered: {error}");
        }
    }

    fn put(&mut self, path: PathBuf, settings: Option<&ImportSettings>) {
        self.recent.retain(|known| *known != path);
        self.recent.insert(0, path.clone());
        self.recent.truncate(RECENT);
        if let Some(settings) = settings {
            self.import.retain(|known| known.path != path);
            let settings = settings.clone();
            self.import.insert(0, Import { path, settings });
            self.import.truncate(IMPORTS);
        }
    }
}

/// The same file has the same name, whatever the current folder.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Files opened last, newest first; at most 12.
pub fn recent() -> Vec<PathBuf> {
    data_dir().map_or_else(Vec::new, |folder| Memory::load(&folder).recent)
}

/// Puts a file at the top of the recent ones, and remembers how it was read.
pub fn remember(path: &Path, settings: Option<&ImportSettings>) {
    if let Some(folder) = data_dir() {
        let path = absolute(path);
        Memory::change(&folder, |memory| memory.put(path, settings));
    }
}

/// How a recording was read last time.
pub fn import_settings_for(path: &Path) -> Option<ImportSettings> {
    let path = absolute(path);
    Memory::load(&data_dir()?)
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
            Memory::change(folder.path(), |m| m.put(path, Some(&settings)));
        }
        Memory::change(folder.path(), |m| m.put(PathBuf::from("/data/7.csv"), None));
        let memory = Memory::load(folder.path());
        assert_eq!(memory.recent.len(), RECENT);
        assert_eq!(memory.recent[0], Path::new("/data/7.csv"));
        assert_eq!(memory.recent[1], Path::new("/data/14.csv"));
        assert_eq!(memory.import.len(), 15);
        assert!(memory.import.iter().all(|i| i.settings == settings));
    }

    #[test]
    fn an_unreadable_list_is_ignored_and_kept() {
        let folder = tempfile::tempdir().unwrap();
        for damaged in [&b"recent = [\"/a"[..], &[0xff, 0xfe, 0x00]] {
            std::fs::write(folder.path().join(FILE), damaged).unwrap();
            assert_eq!(Memory::load(folder.path()), Memory::default());
            Memory::change(folder.path(), |m| m.put(PathBuf::from("/b.csv"), None));
            assert_eq!(Memory::load(folder.path()).recent.len(), 1);
        }
        for (n, damaged) in [(1, &b"recent = [\"/a"[..]), (2, &[0xff, 0xfe, 0x00])] {
            let kept = folder.path().join(format!("{FILE}.unreadable-{n}"));
            assert_eq!(std::fs::read(kept).unwrap(), damaged);
        }
    }
}
