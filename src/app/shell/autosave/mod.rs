//! The autosaved session: written soon after a change, however steadily one edits, and at
//! the end. Each window has a file of its own.

mod slot;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use eframe::egui::Ui;

pub(super) use self::slot::{Slot, Start, claim};

use crate::app::files::atomic_write::{SessionError, keep_unreadable};
use crate::app::files::session;
use crate::app::files::session_text::{Loaded, RecordingEntry};
use crate::app::flows::sealed_trial::own_setup;
use crate::app::kept::{Kept, Memo};
use crate::app::services::Services;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::notice::Notice;
use crate::app::setup::view::View;
use crate::app::state::State;

/// Time without a change after which the session is written. It spares the disk while a
/// slider is dragged.
const QUIET_TIME: Duration = Duration::from_secs(2);
/// Longest time from a change to the beginning of writing. Two of the five seconds that may
/// be lost are left for a busy machine and a slow disk.
const MAX_UNSAVED_TIME: Duration = Duration::from_secs(3);
/// Time after which a session that could not be written is tried again.
const RETRY_TIME: Duration = Duration::from_secs(30);
/// Time after which a disk that is still busy with the last session is looked at again.
const BUSY_TIME: Duration = Duration::from_millis(200);

/// Writes the session on a thread of its own, because a disk may be slow. The newest
/// session wins, whichever thread finishes first.
#[derive(Debug)]
pub(super) struct Autosave {
    /// The window's own file; `None` if it has none, and nothing is written.
    slot: Option<Slot>,
    /// The setup, view and results seen last.
    seen: (Setup, View, Kept),
    /// Lines of results that were written already: they are not made again with every change of
    /// a slider.
    memo: Arc<Memo>,
    /// What is not written yet.
    unsaved: Option<Unsaved>,
    /// Number of the session written last or being written.
    requested: u64,
    /// Number of the session that was written last, and why it could not be.
    written: Arc<Mutex<(u64, Option<String>)>>,
}

/// A change that is not written yet.
#[derive(Debug, Clone, Copy)]
struct Unsaved {
    /// When the first change after the last writing was seen.
    since: Instant,
    /// When it is written.
    due: Instant,
}

/// The parts of a session.
struct SessionParts {
    setup: Setup,
    view: View,
    missing: Vec<RecordingEntry>,
    results: Kept,
}

impl SessionParts {
    fn of(services: &Services) -> Self {
        Self {
            setup: own_setup(&services.state).clone(),
            view: services.state.view.clone(),
            missing: services.missing_recordings.clone(),
            results: Kept::of(&services.state),
        }
    }

    fn save(&self, path: &Path, memo: &Memo) -> Result<(), SessionError> {
        let results = self.results.text(memo);
        session::save_with_results(path, &self.setup, &self.view, &self.missing, &results)
    }
}

fn write(
    written: &Mutex<(u64, Option<String>)>,
    number: u64,
    path: &Path,
    (parts, memo): (&SessionParts, &Memo),
) {
    let mut written = written.lock().unwrap_or_else(PoisonError::into_inner);
    if number > written.0 {
        *written = (
            number,
            parts.save(path, memo).err().map(|error| error.to_string()),
        );
    }
}

impl Autosave {
    /// Autosave of a window that starts with `state`, to its own file.
    pub(super) fn new(state: &State, slot: Option<Slot>) -> Self {
        Self {
            slot,
            seen: (state.setup.clone(), state.view.clone(), Kept::of(state)),
            memo: Arc::default(),
            unsaved: None,
            requested: 0,
            written: Arc::default(),
        }
    }

    /// Called once a frame: notices changes and writes them after a while.
    pub(super) fn update(&mut self, services: &mut Services, ui: &Ui) {
        let context = ui.ctx().clone();
        let done = move || context.request_repaint();
        if let Some(wait) = self.look(services, Instant::now(), done) {
            ui.ctx()
                .request_repaint_after(wait + Duration::from_millis(10));
        }
    }

    /// Notices changes and starts writing them when they are due; `done` is called when they
    /// are written. Returns after what time to look again, if anything is unsaved.
    fn look(
        &mut self,
        services: &mut Services,
        now: Instant,
        done: impl FnOnce() + Send + 'static,
    ) -> Option<Duration> {
        let path = self.slot.as_ref()?.path().to_owned();
        if let Some(problem) = self.problem() {
            services.notice(true, format!("Autosave failed: {problem}"));
            // What could not be written is not lost: it is tried again.
            self.unsaved.get_or_insert(Unsaved {
                since: now,
                due: now + RETRY_TIME,
            });
        }
        let current = (own_setup(&services.state), &services.state.view);
        let results = Kept::of(&services.state);
        if current != (&self.seen.0, &self.seen.1) || results != self.seen.2 {
            self.seen = (current.0.clone(), current.1.clone(), results);
            let since = self.unsaved.map_or(now, |unsaved| unsaved.since);
            self.unsaved = Some(Unsaved {
                since,
                due: (now + QUIET_TIME).min(since + MAX_UNSAVED_TIME),
            });
        }
        let due = self.unsaved?.due;
        if due > now {
            return Some(due - now);
        }
        // One thread at a time, however slow the disk is.
        if matches!(self.written.try_lock(), Err(TryLockError::WouldBlock)) {
            return Some(BUSY_TIME);
        }
        self.unsaved = None;
        let parts = SessionParts::of(services);
        if let Err(error) = self.start(path, parts, done) {
            services.notice(true, format!("Autosave failed: {error}"));
            self.unsaved = Some(Unsaved {
                since: now,
                due: now + RETRY_TIME,
            });
        }
        self.unsaved.map(|unsaved| unsaved.due - now)
    }

    /// Starts writing; `done` is called at the end.
    fn start(
        &mut self,
        path: PathBuf,
        parts: SessionParts,
        done: impl FnOnce() + Send + 'static,
    ) -> std::io::Result<()> {
        self.requested += 1;
        let (number, written) = (self.requested, Arc::clone(&self.written));
        let memo = Arc::clone(&self.memo);
        std::thread::Builder::new()
            .name("autosave".to_owned())
            .spawn(move || {
                write(&written, number, &path, (&parts, &memo));
                done();
            })
            .map(|_| ())
    }

    /// Saves the session when the window closes.
    pub(super) fn save_at_exit(&mut self, services: &Services) {
        if let Some(slot) = &self.slot {
            self.requested += 1;
            let parts = SessionParts::of(services);
            let parts = (&parts, &*self.memo);
            write(&self.written, self.requested, slot.path(), parts);
            if let Some(problem) = self.problem() {
                log::error!("the session is not saved: {problem}");
            }
        }
    }

    /// Why the last session could not be written; reported once.
    fn problem(&self) -> Option<String> {
        // While a thread writes, the lock is taken and there is nothing to report yet.
        self.written.try_lock().ok()?.1.take()
    }
}

/// The window's own file, for the folder of the program's files. What the person should know
/// of it is added to `notices`.
pub(super) fn own_slot(start: Start, notices: &mut Vec<Notice>) -> Option<Slot> {
    let Some(folder) = session::autosave_folder() else {
        let text = "This session is not autosaved: the folder of the program's own files cannot be made; set IMPACTSCOPE_DATA_DIR to one that can be written";
        notices.push(Notice::new(true, text));
        return None;
    };
    match claim(&folder, start) {
        Ok(claimed) => {
            notices.extend(claimed.words.map(|words| Notice::new(false, words)));
            Some(claimed.slot)
        }
        Err(error) => {
            let text = format!("This session is not autosaved: {error}");
            notices.push(Notice::new(true, text));
            None
        }
    }
}

/// The session in the window's own file, if there is one that can be read. A copy of an
/// unreadable one is kept.
pub(super) fn restore(slot: &Slot, notices: &mut Vec<Notice>) -> Option<Loaded> {
    let path = slot.path();
    if !path.exists() {
        return None;
    }
    match session::load(path) {
        Ok(loaded) => Some(loaded),
        Err(error) => {
            let copy = match keep_unreadable(path) {
                Ok(copy) => format!("a copy was saved as {}", copy.display()),
                Err(error) => format!("no copy could be saved: {error}"),
            };
            let text = format!(
                "The last session could not be opened, so a new one was started; {copy}. {error}"
            );
            notices.push(Notice::new(true, text));
            None
        }
    }
}
