//! Recent files, and how recordings were read, stored between starts in one small TOML
//! file. It holds none of the person's work; a copy of an unreadable one is kept all the
//! same.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::atomic_write::{data_dir, keep_unreadable, write_atomically};
use crate::part_files::{PartFile, sweep_parts};
use crate::recording::Channel;
use crate::recording::csv::ImportSettings;

/// Files in the list.
const MAX_RECENT: usize = 12;
/// Recordings whose import settings are stored.
const MAX_IMPORTS: usize = 100;
/// Sensitivities of instruments that are stored.
const MAX_SENSITIVITIES: usize = 100;
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
    sensitivity: Vec<Sensitivity>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Import {
    path: PathBuf,
    settings: ImportSettings,
}

/// What one unit of an instrument stands for in the recordings of a folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    folder: PathBuf,
    /// Symbol of the channel.
    pub channel: String,
    /// Unit of the column.
    pub unit: String,
    /// For example `0.5um/V`.
    pub scale: String,
}

/// The sensitivities that `settings` give for a file of `folder`.
fn given(folder: &Path, settings: &ImportSettings) -> Vec<Sensitivity> {
    let of = |channel: Channel| {
        let choice = settings.choice(channel)?;
        let scale = choice
            .scale
            .clone()
            .filter(|_| choice.is_in_foreign_unit())?;
        Some(Sensitivity {
            folder: folder.to_owned(),
            channel: channel.symbol().to_owned(),
            unit: choice.unit.clone(),
            scale,
        })
    };
    [Channel::ProofMass, Channel::Cantilever]
        .into_iter()
        .filter_map(of)
        .collect()
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
            for own in given(path.parent().unwrap_or(Path::new("")), settings) {
                let is_other = |known: &Sensitivity| {
                    (&known.folder, &known.channel, &known.unit)
                        != (&own.folder, &own.channel, &own.unit)
                };
                self.sensitivity.retain(is_other);
                self.sensitivity.insert(0, own);
            }
            self.sensitivity.truncate(MAX_SENSITIVITIES);
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

/// The sensitivities given before for recordings of the folder of `path`.
pub fn sensitivities_for(path: &Path) -> Vec<Sensitivity> {
    let path = absolute(path);
    let (Some(folder), Some(data)) = (path.parent(), data_dir()) else {
        return Vec::new();
    };
    let mut known = RecentFiles::load(&data).sensitivity;
    known.retain(|own| own.folder == folder);
    known
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
    fn sensitivities_belong_to_a_folder_a_channel_and_a_unit() {
        use crate::recording::csv::ColumnChoice;

        let folder = tempfile::tempdir().unwrap();
        let settings = |unit: &str, scale: &str| ImportSettings {
            proof_mass: Some(ColumnChoice {
                scale: Some(scale.to_owned()),
                ..ColumnChoice::new(1, unit)
            }),
            ..ImportSettings::default()
        };
        let put = |path: &str, settings: &ImportSettings| {
            RecentFiles::change(folder.path(), |list| {
                list.put(PathBuf::from(path), Some(settings));
            });
        };
        put("/a/1.csv", &settings("V", "0.5um/V"));
        put("/a/2.csv", &settings("px", "3um/px"));
        put("/b/1.csv", &settings("V", "2um/V"));
        put("/a/3.csv", &settings("V", "0.6um/V"));
        // A displacement in metres has none.
        put("/a/4.csv", &settings("um", "7um/V"));
        let known = RecentFiles::load(folder.path()).sensitivity;
        let found: Vec<(&Path, &str, &str)> = known
            .iter()
            .map(|s| (s.folder.as_path(), s.unit.as_str(), s.scale.as_str()))
            .collect();
        let (a, b) = (Path::new("/a"), Path::new("/b"));
        assert_eq!(
            found,
            [(a, "V", "0.6um/V"), (b, "V", "2um/V"), (a, "px", "3um/px")]
        );
        assert!(known.iter().all(|s| s.channel == "xp"));
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
