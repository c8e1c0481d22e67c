//! Opening files without holding up the window: reading, importing and the system's
//! file dialog run on threads of their own.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::recording::csv::{ImportSettings, Preview, import, preview};

use super::session::{self, Loaded, RecordingEntry};
use super::worker::panic_text;

/// What became of a file.
#[derive(Debug)]
pub enum FileEvent {
    /// A recording, and how its columns were read.
    Recording {
        path: PathBuf,
        settings: ImportSettings,
        recording: Arc<Recording>,
        /// What a session remembers of it, if it came from one.
        entry: Option<RecordingEntry>,
    },
    /// A recording whose columns the person must name.
    Ask { path: PathBuf, preview: Preview },
    /// A preset.
    Preset { preset: Box<Preset> },
    /// A session, its recordings still to come.
    Session { path: PathBuf, loaded: Box<Loaded> },
    /// It could not be opened: what, where, what to do.
    Failed { message: String },
    /// A place to save to was chosen.
    SaveTo { purpose: Purpose, path: PathBuf },
}

/// What a file is saved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The session.
    Session,
    /// The device as a preset.
    Preset,
    /// The visible plots.
    Svg,
    /// The visible plots.
    Png,
    /// The simulated trace.
    Trace,
    /// The events.
    Events,
}

impl Purpose {
    /// Suggested file name.
    pub fn file_name(self) -> &'static str {
        match self {
            Purpose::Session => "session.impactscope.toml",
            Purpose::Preset => "device.toml",
            Purpose::Svg => "plots.svg",
            Purpose::Png => "plots.png",
            Purpose::Trace => "trace.csv",
            Purpose::Events => "events.csv",
        }
    }
}

/// File work in progress.
pub struct Files {
    send: Sender<FileEvent>,
    events: Receiver<FileEvent>,
    repaint: Arc<dyn Fn() + Send + Sync>,
    jobs: Arc<()>,
}

impl Files {
    /// `repaint` is called when something is done.
    pub fn new(repaint: impl Fn() + Send + Sync + 'static) -> Self {
        let (send, events) = channel();
        Self {
            send,
            events,
            repaint: Arc::new(repaint),
            jobs: Arc::new(()),
        }
    }

    /// Number of files being worked on.
    pub fn pending(&self) -> usize {
        Arc::strong_count(&self.jobs) - 1
    }

    /// What has become of files since the last call.
    pub fn poll(&self) -> Vec<FileEvent> {
        self.events.try_iter().collect()
    }

    fn spawn(&self, work: impl FnOnce() -> Option<FileEvent> + Send + 'static) {
        let (send, repaint, job) = (
            self.send.clone(),
            Arc::clone(&self.repaint),
            Arc::clone(&self.jobs),
        );
        let started = std::thread::Builder::new()
            .name("file".to_owned())
            .spawn(move || {
                let event = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
                    let text = panic_text(panic.as_ref());
                    Some(FileEvent::Failed {
                        message: format!("internal error while working on a file: {text}"),
                    })
                });
                if let Some(event) = event {
                    // The window may be gone.
                    let _ = send.send(event);
                }
                drop(job);
                repaint();
            });
        if let Err(error) = started {
            let message =
                format!("cannot start a thread for the file: {error}; close other programs");
            let _ = self.send.send(FileEvent::Failed { message });
        }
    }

    /// Opens a file of any kind.
    pub fn open(&self, path: PathBuf) {
        self.spawn(move || Some(open(path)));
    }

    /// Imports a recording with given settings; `entry` is what a session remembers of it.
    pub fn import(&self, path: PathBuf, settings: ImportSettings, entry: Option<RecordingEntry>) {
        self.spawn(move || Some(import_with(path, settings, entry)));
    }

    /// Shows how a recording would be read, to be changed by the person.
    pub fn ask(&self, path: PathBuf) {
        self.spawn(move || {
            Some(match preview(&path) {
                Ok(preview) => FileEvent::Ask { path, preview },
                Err(error) => failed(&error),
            })
        });
    }

    /// Shows the system's dialog for opening files.
    pub fn open_dialog(&self) {
        let send = self.send.clone();
        let repaint = Arc::clone(&self.repaint);
        self.spawn(move || {
            let paths = rfd::FileDialog::new()
                .add_filter(
                    "recordings, presets, sessions",
                    &["csv", "txt", "dat", "tsv", "toml"],
                )
                .add_filter("all files", &["*"])
                .pick_files()?;
            for path in paths {
                let _ = send.send(open(path));
                repaint();
            }
            None
        });
    }

    /// Shows the system's dialog for saving.
    pub fn save_dialog(&self, purpose: Purpose) {
        self.spawn(move || {
            let path = rfd::FileDialog::new()
                .set_file_name(purpose.file_name())
                .save_file()?;
            Some(FileEvent::SaveTo { purpose, path })
        });
    }
}

fn failed(error: &dyn std::error::Error) -> FileEvent {
    FileEvent::Failed {
        message: error.to_string(),
    }
}

fn open(path: PathBuf) -> FileEvent {
    let name = path.to_string_lossy().to_lowercase();
    if name.ends_with(".toml") {
        return open_toml(path);
    }
    let remembered = session::import_settings_for(&path);
    let preview = match preview(&path) {
        Ok(preview) => preview,
        Err(error) => return failed(&error),
    };
    match remembered {
        Some(settings) => import_with(path, settings, None),
        None if preview.needs_dialog() => FileEvent::Ask { path, preview },
        None => import_with(path, preview.settings, None),
    }
}

fn open_toml(path: PathBuf) -> FileEvent {
    if session::is_session(&path) {
        return match session::load(&path) {
            Ok(loaded) => FileEvent::Session {
                path,
                loaded: Box::new(loaded),
            },
            Err(error) => failed(&error),
        };
    }
    match Preset::load(&path.to_string_lossy()) {
        Ok(preset) => FileEvent::Preset {
            preset: Box::new(preset),
        },
        Err(error) => failed(&error),
    }
}

fn import_with(
    path: PathBuf,
    settings: ImportSettings,
    entry: Option<RecordingEntry>,
) -> FileEvent {
    match import(&path, &settings, None) {
        Ok(recording) => {
            let expected = entry.as_ref().and_then(|entry| entry.sha256.as_ref());
            if expected.is_some() && expected != recording.sha256.as_ref() {
                return changed(&path);
            }
            FileEvent::Recording {
                path,
                settings,
                recording: Arc::new(recording),
                entry,
            }
        }
        Err(error) => failed(&error),
    }
}

fn changed(path: &Path) -> FileEvent {
    FileEvent::Failed {
        message: format!(
            "{}: the file has changed since the session was saved; it was not loaded. Open it anew if the change is meant",
            path.display()
        ),
    }
}
