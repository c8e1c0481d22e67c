//! Opens files without blocking the window: reading, importing and the system's file dialog
//! run on threads of their own.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use super::event::{FileEvent, Purpose, failed};
use super::jobs::{Context, Jobs, Repaint, Working};
use super::reading::{
    ask_trial, drawn_from, drive_from, import_with, open, take_known_sensitivities,
};
use super::recent::absolute;
use super::session_text::RecordingEntry;
use crate::app::analysis::job::panic_text;
use crate::recording::csv::ImportSettings;
use crate::recording::formats::FORMATS;
use crate::recording::import::preview;

/// A file dialog that closes sooner than this was never shown: nobody can answer so fast.
const MIN_DIALOG_TIME: Duration = Duration::from_millis(250);

/// File work in progress.
pub struct Files {
    send: Sender<FileEvent>,
    events: Receiver<FileEvent>,
    repaint: Repaint,
    jobs: Jobs,
    /// Whether the system's dialog is open: it blocks its thread for as long.
    asking: Arc<AtomicBool>,
}

impl Files {
    /// `repaint` is called when something is done.
    pub fn new(repaint: impl Fn() + Send + Sync + 'static) -> Self {
        let (send, events) = channel();
        Self {
            send,
            events,
            repaint: Arc::new(repaint),
            jobs: Jobs::default(),
            asking: Arc::default(),
        }
    }

    /// Number of files being worked on; an open file dialog does not count.
    pub fn pending(&self) -> usize {
        self.jobs.running().len()
    }

    /// Files being worked on, with their progress.
    pub fn working(&self) -> Vec<Working> {
        self.jobs.working()
    }

    /// Stops the imports in progress; they give no result.
    pub fn cancel(&self) {
        self.jobs.cancel();
    }

    /// Outcomes since the last call.
    pub fn poll(&self) -> Vec<FileEvent> {
        self.events.try_iter().collect()
    }

    /// Reads a file in a thread of its own.
    fn spawn(
        &self,
        path: PathBuf,
        work: impl FnOnce(&Context) -> Option<FileEvent> + Send + 'static,
    ) {
        self.work("reading", path, work);
    }

    /// Works on a file in a thread of its own. `what` names the work, for example `saving`.
    pub fn work(
        &self,
        what: &'static str,
        path: PathBuf,
        work: impl FnOnce(&Context) -> Option<FileEvent> + Send + 'static,
    ) {
        let context = Context::new(what, path, &self.jobs, &self.send, &self.repaint);
        self.thread(move || context.run(work));
    }

    fn thread(&self, work: impl FnOnce() + Send + 'static) {
        let started = std::thread::Builder::new()
            .name("file".to_owned())
            .spawn(work);
        if let Err(error) = started {
            self.fail(format!(
                "cannot start a thread for the file: {error}; close other programs"
            ));
        }
    }

    fn fail(&self, message: String) {
        // The receiver is in the same struct.
        let _ = self.send.send(FileEvent::Failed { message });
        (self.repaint)();
    }

    /// Opens a file of any kind. A recording with unambiguous columns is imported at once; a
    /// known one is imported as last time.
    pub fn open(&self, path: PathBuf) {
        let path = absolute(&path);
        self.spawn(path.clone(), move |context| open(path, context));
    }

    /// Imports a recording with given settings; `entry` is its entry in a session.
    pub fn import(&self, path: PathBuf, settings: ImportSettings, entry: Option<RecordingEntry>) {
        let path = absolute(&path);
        self.spawn(path.clone(), move |context| {
            import_with(path, settings, Vec::new(), entry, context)
        });
    }

    /// Looks at another recording of a file with several, for the import dialog.
    pub fn preview_trial(&self, path: PathBuf, trial: usize) {
        self.spawn(path.clone(), move |_| Some(ask_trial(path, trial)));
    }

    /// Imports a recording of a session, with the settings stored in it.
    pub fn import_session_recording(&self, entry: &RecordingEntry) {
        if let Some(path) = &entry.path {
            self.import(path.clone(), entry.import.clone(), Some(entry.clone()));
        }
    }

    /// Reads a drive from a CSV with time and voltage.
    pub fn drive(&self, path: PathBuf) {
        let path = absolute(&path);
        self.spawn(path.clone(), move |_| Some(drive_from(&path)));
    }

    /// Reads a drawn waveform.
    pub fn drawn(&self, path: PathBuf) {
        let path = absolute(&path);
        self.spawn(path.clone(), move |_| Some(drawn_from(&path)));
    }

    /// Previews how a recording would be read, so that the person can change the settings.
    pub fn ask(&self, path: PathBuf) {
        let path = absolute(&path);
        self.spawn(path.clone(), move |_| {
            Some(match preview(&path) {
                Ok(mut preview) => {
                    take_known_sensitivities(&path, &mut preview);
                    FileEvent::Ask {
                        path,
                        preview: Box::new(preview),
                    }
                }
                Err(error) => failed(&error),
            })
        });
    }

    /// Shows the system's dialog for opening files.
    pub fn open_dialog(&self) {
        let (send, repaint, jobs) = (
            self.send.clone(),
            Arc::clone(&self.repaint),
            self.jobs.clone(),
        );
        self.dialog(None, move || {
            let paths = rfd::FileDialog::new()
                .add_filter("recordings, presets, sessions", &extensions())
                .add_filter("all files", &["*"])
                .pick_files();
            let chosen = paths.is_some();
            for path in paths.into_iter().flatten() {
                let context = Context::new("reading", path.clone(), &jobs, &send, &repaint);
                context.run(move |context| open(path, context));
            }
            chosen
        });
    }

    /// Shows the system's dialog for saving.
    pub fn save_dialog(&self, purpose: Purpose) {
        let send = self.send.clone();
        self.dialog(Some(purpose), move || {
            let path = rfd::FileDialog::new()
                .set_file_name(purpose.file_name())
                .save_file();
            let chosen = path.is_some();
            if let Some(path) = path {
                // The window may be gone.
                let _ = send.send(FileEvent::SaveTo { purpose, path });
            }
            chosen
        });
    }

    /// Runs a file dialog of the system, one at a time; `show` returns whether a file was
    /// chosen. On a system without file dialogs the person types the path.
    fn dialog(&self, purpose: Option<Purpose>, show: impl FnOnce() -> bool + Send + 'static) {
        if self.asking.swap(true, Ordering::AcqRel) {
            return self.fail(
                "the system's file dialog is already open or not responding; use \"Open path...\" or drop the file on the window".to_owned(),
            );
        }
        let (send, repaint, asking) = (
            self.send.clone(),
            Arc::clone(&self.repaint),
            Arc::clone(&self.asking),
        );
        let started = std::thread::Builder::new()
            .name("file dialog".to_owned())
            .spawn(move || {
                let since = Instant::now();
                let outcome = catch_unwind(AssertUnwindSafe(show));
                let message = match outcome {
                    Err(panic) => Some(format!(
                        "the system's file dialog failed ({}); type the path instead",
                        panic_text(panic.as_ref())
                    )),
                    Ok(false) if since.elapsed() < MIN_DIALOG_TIME => Some(
                        "the system has no file dialog; type the path, or drop the file on the window".to_owned(),
                    ),
                    Ok(_) => None,
                };
                asking.store(false, Ordering::Release);
                if let Some(message) = message {
                    let _ = send.send(FileEvent::Failed { message });
                    let _ = send.send(FileEvent::TypePath { purpose });
                }
                repaint();
            });
        if let Err(error) = started {
            self.asking.store(false, Ordering::Release);
            self.fail(format!(
                "cannot start a thread for the file dialog: {error}; close other programs"
            ));
        }
    }
}

/// Extensions of the files that can be opened.
fn extensions() -> Vec<&'static str> {
    let text = ["csv", "txt", "dat", "tsv", "asc", "prn", "toml"];
    let known = FORMATS.iter().flat_map(|format| format.extensions());
    text.into_iter().chain(known.copied()).collect()
}

#[cfg(test)]
#[path = "open_tests.rs"]
mod tests;
