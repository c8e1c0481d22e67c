//! What is kept without being asked for: undo steps and the autosaved session.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use eframe::egui::Ui;

use super::window::Shell;
use crate::app::files::atomic_write::SessionError;
use crate::app::files::session;
use crate::app::files::session_text::RecordingEntry;
use crate::app::flows::sealed_trial::own_setup;
use crate::app::setup::notice::Notice;
use crate::app::setup::setup::Setup;
use crate::app::setup::view::View;

/// Quiet time before the session is autosaved [s].
const AUTOSAVE_AFTER: f64 = 2.0;

/// Writes the session beside the window: a slow disk must not hold it up. The newest
/// state wins, whichever thread comes first.
#[derive(Debug, Default)]
pub(crate) struct Autosave {
    asked: u64,
    /// Number of the state that was written last, and why it could not be.
    written: Arc<Mutex<(u64, Option<String>)>>,
}

impl Autosave {
    /// Starts writing; `done` is called at the end.
    fn start(&mut self, path: PathBuf, kept: Kept, done: impl FnOnce() + Send + 'static) {
        self.asked += 1;
        let (number, written) = (self.asked, Arc::clone(&self.written));
        let started = std::thread::Builder::new()
            .name("autosave".to_owned())
            .spawn(move || {
                write(&written, number, &path, &kept);
                done();
            });
        if let Err(error) = started {
            log::warn!("autosave: {error}");
        }
    }

    /// Writes at once.
    fn finish(&mut self, path: &Path, kept: &Kept) {
        self.asked += 1;
        write(&self.written, self.asked, path, kept);
    }

    /// Why the last one could not be written; said once.
    fn problem(&self) -> Option<String> {
        // While it writes there is nothing to say yet.
        self.written.try_lock().ok()?.1.take()
    }
}

/// The parts of a session.
struct Kept {
    setup: Setup,
    view: View,
    absent: Vec<RecordingEntry>,
}

impl Kept {
    fn save(&self, path: &Path) -> Result<(), SessionError> {
        session::save(path, &self.setup, &self.view, &self.absent)
    }
}

fn write(written: &Mutex<(u64, Option<String>)>, number: u64, path: &Path, kept: &Kept) {
    let mut written = written.lock().unwrap_or_else(PoisonError::into_inner);
    if number > written.0 {
        *written = (number, kept.save(path).err().map(|error| error.to_string()));
    }
}

impl Shell {
    /// Notices what changed in this frame.
    pub(super) fn keep(&mut self, ui: &Ui) {
        let now = ui.input(|input| input.time);
        let busy =
            ui.input(|input| input.pointer.any_down()) || ui.ctx().egui_wants_keyboard_input();
        if self.history.observe(&self.state.setup, busy, now) {
            ui.ctx().request_repaint_after(Duration::from_millis(350));
        }
        if let Some(problem) = self.autosave.problem() {
            self.notice(
                true,
                format!("The session is not saved by itself: {problem}"),
            );
        }
        let current = (own_setup(&self.state), &self.state.view);
        if current != (&self.saved.0, &self.saved.1) && self.picture.is_none() {
            self.saved = (current.0.clone(), current.1.clone());
            self.changed_at = Some(now);
        }
        let Some(changed) = self.changed_at else {
            return;
        };
        let wait = changed + AUTOSAVE_AFTER - now;
        if wait > 0.0 {
            let wait = Duration::from_secs_f64(wait + 0.01);
            return ui.ctx().request_repaint_after(wait);
        }
        self.changed_at = None;
        if let Some(path) = session::autosave_path() {
            let context = ui.ctx().clone();
            let kept = self.kept();
            self.autosave
                .start(path, kept, move || context.request_repaint());
        }
    }

    fn kept(&self) -> Kept {
        Kept {
            setup: own_setup(&self.state).clone(),
            view: self.state.view.clone(),
            absent: self.absent.clone(),
        }
    }

    /// Saves the session at the end; not that of a window opened for its picture.
    pub(super) fn keep_at_exit(&mut self) {
        if self.picture.is_none()
            && let Some(path) = session::autosave_path()
        {
            let kept = self.kept();
            self.autosave.finish(&path, &kept);
            if let Some(problem) = self.autosave.problem() {
                log::error!("the session is not saved: {problem}");
            }
        }
    }
}

/// The autosaved session, if there is one that can be read; one that cannot is kept.
pub(super) fn restore(
    notices: &mut Vec<Notice>,
) -> Option<crate::app::files::session_text::Loaded> {
    let path = session::autosave_path()?;
    if !path.exists() {
        return None;
    }
    match session::load(&path) {
        Ok(loaded) => Some(loaded),
        Err(error) => {
            let kept = match crate::app::files::atomic_write::keep_unreadable(&path) {
                Ok(kept) => format!("a copy was kept as {}", kept.display()),
                Err(error) => format!("no copy could be kept: {error}"),
            };
            let text =
                format!("The last session could not be opened, a new one begins; {kept}. {error}");
            notices.push(Notice::new(true, text));
            None
        }
    }
}
