//! The autosaved session: written when nothing has changed for a while, and at the end.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use eframe::egui::Ui;

use crate::app::files::atomic_write::{SessionError, keep_unreadable};
use crate::app::files::session;
use crate::app::files::session_text::{Loaded, RecordingEntry};
use crate::app::flows::sealed_trial::own_setup;
use crate::app::services::Services;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::notice::Notice;
use crate::app::setup::view::View;
use crate::app::state::State;

/// Time without a change before the session is autosaved \[s\]. It spares the disk while a
/// slider is dragged.
const AUTOSAVE_DELAY: f64 = 2.0;

/// Writes the session on a thread of its own, because a disk may be slow. The newest
/// session wins, whichever thread finishes first.
#[derive(Debug)]
pub(super) struct Autosave {
    /// The setup and view seen last.
    seen: (Setup, View),
    /// When they changed, on the window's clock \[s\]; `None` once they are written.
    changed_at: Option<f64>,
    /// Number of the session written last or being written.
    requested: u64,
    /// Number of the session that was written last, and why it could not be.
    written: Arc<Mutex<(u64, Option<String>)>>,
}

/// The parts of a session.
struct SessionParts {
    setup: Setup,
    view: View,
    missing: Vec<RecordingEntry>,
}

impl SessionParts {
    fn of(services: &Services) -> Self {
        Self {
            setup: own_setup(&services.state).clone(),
            view: services.state.view.clone(),
            missing: services.missing_recordings.clone(),
        }
    }

    fn save(&self, path: &Path) -> Result<(), SessionError> {
        session::save(path, &self.setup, &self.view, &self.missing)
    }
}

fn write(written: &Mutex<(u64, Option<String>)>, number: u64, path: &Path, parts: &SessionParts) {
    let mut written = written.lock().unwrap_or_else(PoisonError::into_inner);
    if number > written.0 {
        *written = (
            number,
            parts.save(path).err().map(|error| error.to_string()),
        );
    }
}

impl Autosave {
    /// Autosave of a window that starts with `state`.
    pub(super) fn new(state: &State) -> Self {
        Self {
            seen: (state.setup.clone(), state.view.clone()),
            changed_at: None,
            requested: 0,
            written: Arc::default(),
        }
    }

    /// Called once a frame: notices changes and writes them after a while. Without
    /// `is_enabled` new changes are not written: a window opened for a screenshot leaves
    /// the session alone.
    pub(super) fn update(&mut self, services: &mut Services, ui: &Ui, is_enabled: bool) {
        let now = ui.input(|input| input.time);
        if let Some(problem) = self.problem() {
            services.notice(true, format!("Autosave failed: {problem}"));
        }
        let current = (own_setup(&services.state), &services.state.view);
        if current != (&self.seen.0, &self.seen.1) && is_enabled {
            self.seen = (current.0.clone(), current.1.clone());
            self.changed_at = Some(now);
        }
        let Some(changed) = self.changed_at else {
            return;
        };
        let wait = changed + AUTOSAVE_DELAY - now;
        if wait > 0.0 {
            let wait = Duration::from_secs_f64(wait + 0.01);
            return ui.ctx().request_repaint_after(wait);
        }
        self.changed_at = None;
        if let Some(path) = session::autosave_path() {
            let context = ui.ctx().clone();
            let parts = SessionParts::of(services);
            self.start(path, parts, move || context.request_repaint());
        }
    }

    /// Starts writing; `done` is called at the end.
    fn start(&mut self, path: PathBuf, parts: SessionParts, done: impl FnOnce() + Send + 'static) {
        self.requested += 1;
        let (number, written) = (self.requested, Arc::clone(&self.written));
        let started = std::thread::Builder::new()
            .name("autosave".to_owned())
            .spawn(move || {
                write(&written, number, &path, &parts);
                done();
            });
        if let Err(error) = started {
            log::warn!("autosave: {error}");
        }
    }

    /// Saves the session when the window closes.
    pub(super) fn save_at_exit(&mut self, services: &Services) {
        if let Some(path) = session::autosave_path() {
            self.requested += 1;
            let parts = SessionParts::of(services);
            write(&self.written, self.requested, &path, &parts);
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

/// The autosaved session, if there is one that can be read. A copy of an unreadable one is
/// kept.
pub(super) fn restore(notices: &mut Vec<Notice>) -> Option<Loaded> {
    let path = session::autosave_path()?;
    if !path.exists() {
        return None;
    }
    match session::load(&path) {
        Ok(loaded) => Some(loaded),
        Err(error) => {
            let copy = match keep_unreadable(&path) {
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
