//! What commands act on: the state that panels see, and the services behind it (undo,
//! files, dialogs). Commands take `&mut Services`; the window owns it.

use std::path::PathBuf;

use super::dialogs::Dialogs;
use super::export::film::FilmRequest;
use super::files::open::Files;
use super::files::session_text::RecordingEntry;
use super::setup::notice::{About, Notice};
use super::setup::overlay::OverlayId;
use super::setup::undo::History;
use super::simulation::recorded_drive::RecordedDriveCache;
use super::state::State;

/// The state and all that commands change besides it.
pub struct Services {
    /// What panels draw and change.
    pub state: State,
    /// Undo and redo.
    pub history: History,
    /// File work in progress.
    pub files: Files,
    /// Open dialogs.
    pub dialogs: Dialogs,
    /// File of the session, once it has one.
    pub session_path: Option<PathBuf>,
    /// Recordings of the session that could not be loaded. They stay in the session, so
    /// that they come back with their files.
    pub missing_recordings: Vec<RecordingEntry>,
    /// Files in the order in which they were requested. Recordings are listed in this
    /// order, whichever is read first.
    pub requested_files: Vec<PathBuf>,
    /// The highest recording number given out so far.
    pub last_overlay_id: OverlayId,
    /// How often the live run was restarted; a new count starts it again at t = 0.
    pub restarts: u64,
    /// How many single live steps were requested.
    pub steps: u64,
    /// Whether the hint of the first start is shown.
    pub shows_hint: bool,
    /// Name of the device whose usual live speed is set.
    pub speed_set_for: String,
    /// The drive taken from a recording.
    pub recorded_drive: RecordedDriveCache,
    /// The film that is to be written next.
    pub film: Option<FilmRequest>,
    /// The first failure since the start. A screenshot then ends with an error.
    pub first_failure: Option<String>,
}

impl Services {
    /// Services around a state, with nothing opened yet.
    pub fn new(state: State, files: Files) -> Self {
        Self {
            history: History::new(&state.setup),
            state,
            files,
            dialogs: Dialogs::default(),
            session_path: None,
            missing_recordings: Vec::new(),
            requested_files: Vec::new(),
            last_overlay_id: 0,
            restarts: 0,
            steps: 0,
            shows_hint: false,
            speed_set_for: String::new(),
            recorded_drive: RecordedDriveCache::default(),
            film: None,
            first_failure: None,
        }
    }

    /// Shows a notice over the window.
    pub fn notice(&mut self, is_error: bool, text: impl Into<String>) {
        self.notice_about(None, is_error, text);
    }

    /// Shows a notice about something that its button can put right.
    pub fn notice_about(&mut self, about: Option<About>, is_error: bool, text: impl Into<String>) {
        let notice = Notice {
            about,
            ..Notice::new(is_error, text)
        };
        // A repeated notice moves to the end of the list.
        self.state.notices.retain(|known| !known.says(&notice));
        self.state.notices.push(notice);
    }

    /// Shows a failure.
    pub fn fail(&mut self, message: String) {
        self.first_failure.get_or_insert_with(|| message.clone());
        self.notice(true, message);
    }

    /// Takes recordings off the list of missing ones, and their notices off the window.
    pub fn forget_missing(&mut self, is_meant: impl Fn(&RecordingEntry) -> bool) {
        let notices = &mut self.state.notices;
        self.missing_recordings.retain(|entry| {
            let is_meant = is_meant(entry);
            if is_meant {
                let lost = Some(About::Lost(entry.id));
                notices.retain(|notice| notice.about != lost);
            }
            !is_meant
        });
    }

    /// Reports that the file of a session's recording is missing, unless it was found
    /// meanwhile.
    pub fn report_missing(&mut self, id: OverlayId, message: String) {
        if self.missing_recordings.iter().any(|entry| entry.id == id) {
            self.notice_about(Some(About::Lost(id)), true, message);
        }
    }
}
