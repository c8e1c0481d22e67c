//! The frame around the workspaces: it notices changes, asks the worker, shows its news,
//! runs commands, keeps history and autosave.

use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui::{CentralPanel, Context, Frame, Ui};

use super::layout_dump::Layout;
use super::options::WindowOptions;
use super::picture::PictureOutcome;
use crate::app::dialogs::Dialogs;
use crate::app::files::open::{Files, absolute};
use crate::app::files::{built_in, session_text};
use crate::app::setup::command::Command;
use crate::app::setup::notice::{About, Notice, Refusal};
use crate::app::setup::overlay::OverlayId;
use crate::app::setup::setup::Setup;
use crate::app::setup::undo::History;
use crate::app::setup::view::{Picture, View};
use crate::app::simulation::request::SimulationRequest;
use crate::app::simulation::worker::{News, Worker};
use crate::app::state::State;
use crate::app::{theme, workspaces};
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::sim::SimError;

pub(crate) use super::reference_curve::Return;

/// The application.
pub struct Shell {
    pub(crate) state: State,
    pub(crate) history: History,
    pub(crate) files: Files,
    pub(crate) dialogs: Dialogs,
    /// File of the session, once it has one.
    pub(crate) session_path: Option<PathBuf>,
    pub(crate) restarts: u64,
    pub(crate) steps: u64,
    pub(crate) hint: bool,
    pub(crate) next_overlay: OverlayId,
    /// Recordings of the session that could not be loaded: kept in it, for when their
    /// files are back.
    pub(crate) absent: Vec<session_text::RecordingEntry>,
    /// Files in the order in which they were asked for: recordings stand in the list so,
    /// whichever is read first.
    pub(crate) order: Vec<PathBuf>,
    /// Device whose usual live speed is set.
    pub(crate) speed_of: String,
    /// How far the kept curve of a session is.
    pub(crate) kept: Return,
    worker: Worker,
    sent: Option<SimulationRequest>,
    pub(crate) recorded: Option<((OverlayId, f64), Result<Waveform, String>)>,
    pub(crate) saved: (Setup, View),
    pub(crate) changed_at: Option<f64>,
    layout: Layout,
    pub(crate) autosave: super::autosave::Autosave,
    /// Theme that the colours are set for.
    themed: Option<bool>,
    /// Whether the worker panicked over what was last sent.
    pub(crate) broken: bool,
    pub(crate) picture: Option<super::picture::Wanted>,
    /// The first thing that failed while a picture is wanted.
    pub(crate) failed: Option<String>,
    pub(crate) outcome: PictureOutcome,
}

impl Shell {
    /// Builds the window's contents.
    ///
    /// # Errors
    /// The system's, if the worker thread cannot be started.
    pub fn new(
        context: &Context,
        options: WindowOptions,
        preset: Option<Preset>,
        outcome: PictureOutcome,
    ) -> std::io::Result<Self> {
        let repaint = {
            let context = context.clone();
            move || context.request_repaint()
        };
        let worker = Worker::start(repaint.clone())?;
        let files = Files::new(repaint);
        let plain = options.files.is_empty() && preset.is_none();
        let mut notices = Vec::new();
        let restored = if plain && options.screenshot.is_none() {
            super::autosave::restore(&mut notices)
        } else {
            None
        };
        let is_restored = restored.is_some();
        let hint = plain && !is_restored;
        let (mut last_id, mut absent) = (0, Vec::new());
        let (setup, view) = match restored {
            Some(loaded) => {
                for entry in &loaded.recordings {
                    import_entry(&files, entry);
                }
                let missing = loaded.missing.iter();
                notices.extend(missing.map(|text| Notice::new(true, text.as_str())));
                last_id = loaded.last_id();
                absent = loaded.recordings;
                (loaded.setup, loaded.view)
            }
            None => {
                let setup = match preset {
                    Some(preset) => built_in::from_preset(preset),
                    None if plain => built_in::setup(),
                    None => built_in::from_preset(Preset::default()),
                };
                (setup, View::default())
            }
        };
        let mut order: Vec<PathBuf> = absent.iter().filter_map(|e| e.path.clone()).collect();
        for file in options.files {
            order.push(absolute(file.clone()));
            files.open(file);
        }
        theme::apply(context, view.dark);
        let shown = setup.overlays.iter().map(|o| o.id).max().unwrap_or(0);
        let mut state = crate::app::state::state(setup, view);
        if let Some(workspace) = options.workspace {
            state.view.workspace = workspace;
        }
        state.notices = notices;
        Ok(Self {
            history: History::new(&state.setup),
            speed_of: if is_restored {
                state.setup.preset.model.name.clone()
            } else {
                String::new()
            },
            saved: (state.setup.clone(), state.view.clone()),
            themed: Some(state.view.dark),
            state,
            files,
            dialogs: Dialogs::default(),
            session_path: None,
            restarts: 0,
            steps: 0,
            hint,
            next_overlay: last_id.max(shown),
            absent,
            order,
            kept: Return::Open,
            worker,
            sent: None,
            recorded: None,
            changed_at: None,
            layout: Layout::new(),
            autosave: super::autosave::Autosave::default(),
            broken: false,
            picture: options.screenshot.map(|path| (path, 0)),
            failed: None,
            outcome,
        })
    }

    /// Says something over the window, once.
    pub(crate) fn notice(&mut self, is_error: bool, text: impl Into<String>) {
        self.notice_of(None, is_error, text);
    }

    /// The same, about something that a button can mend.
    pub(crate) fn notice_of(
        &mut self,
        about: Option<About>,
        is_error: bool,
        text: impl Into<String>,
    ) {
        let notice = Notice {
            about,
            ..Notice::new(is_error, text)
        };
        // Said again, it is the newest.
        self.state.notices.retain(|known| !known.says(&notice));
        self.state.notices.push(notice);
    }

    /// Says that a recording of the session is gone, unless it was found meanwhile.
    pub(crate) fn lost(&mut self, id: OverlayId, message: String) {
        if self.absent.iter().any(|entry| entry.id == id) {
            self.notice_of(Some(About::Lost(id)), true, message);
        }
    }

    fn take_news(&mut self) {
        for news in self.worker.news() {
            match news {
                News::Snapshot(snapshot) => {
                    self.state.refusal = None;
                    self.state.snapshot = Some(snapshot);
                }
                News::Refused(error) => self.state.refusal = Some(refusal(&error)),
                News::Stopped(error) => {
                    self.state.paused = true;
                    self.state.refusal = Some(refusal(&error));
                    self.notice(true, format!("Live run paused: {error}"));
                }
                News::Broken(text) => {
                    self.broken = true;
                    self.notice(
                        true,
                        format!("internal error in the simulator: {text}. The window goes on; undo the last change"),
                    );
                }
            }
        }
    }

    /// Another device is watched at its own speed.
    fn set_speed(&mut self) {
        let setup = &self.state.setup;
        if self.speed_of != setup.preset.model.name {
            self.speed_of.clone_from(&setup.preset.model.name);
            self.state.view.slow_down = crate::app::workspaces::tune::usual_speed(setup);
        }
    }

    /// Sends the worker what is to be shown, if that has changed.
    fn ask_worker(&mut self) {
        let drive = match self.drive() {
            Ok(drive) => drive,
            Err(message) => {
                self.state.refusal = Some(Refusal {
                    parameter: "drive".to_owned(),
                    message,
                });
                return;
            }
        };
        let state = &self.state;
        let preview = state.fitting.preview();
        let device = preview.as_ref().unwrap_or(&state.setup.preset.model);
        if let Err(error) = device.check() {
            self.state.refusal = Some(Refusal {
                parameter: error.parameter,
                message: error.reason,
            });
            return;
        }
        let same_model = self
            .sent
            .as_ref()
            .filter(|sent| *sent.model == *device)
            .map(|sent| Arc::clone(&sent.model));
        let pictures = &state.view.pictures;
        let wish = SimulationRequest {
            model: same_model.unwrap_or_else(|| Arc::new(device.clone())),
            drive,
            duration: state.setup.duration,
            forces: pictures.contains(&Picture::Forces) || pictures.contains(&Picture::Device),
            overlays: state.setup.overlays.clone(),
            mode: state.view.mode,
            slow_down: state.view.slow_down,
            paused: state.paused,
            scrub: state.scrub,
            restarts: self.restarts,
            steps: self.steps,
        };
        if self.sent.as_ref() != Some(&wish) {
            self.broken = false;
            self.worker.send(wish.clone());
            self.sent = Some(wish);
        } else if self.state.refusal.as_ref().is_some_and(|r| {
            // The values are good again and already shown.
            self.state.snapshot.is_some() && r.parameter != "drive" && !self.refused_by_worker()
        }) {
            self.state.refusal = None;
        }
    }

    /// Whether what was sent last has not led to a picture of the same model.
    fn refused_by_worker(&self) -> bool {
        match (&self.sent, &self.state.snapshot) {
            (Some(sent), Some(shown)) => sent.model != shown.model,
            _ => true,
        }
    }

    fn shortcuts(&mut self, ui: &Ui) {
        if ui.ctx().text_edit_focused() || self.dialogs.is_open() {
            return;
        }
        for command in Command::all() {
            // The key of a command that would do nothing is left to the widgets.
            if !crate::app::actions::run::is_possible(self, command) {
                continue;
            }
            for shortcut in command.shortcuts() {
                if ui.input_mut(|input| crate::app::actions::run::pressed(input, &shortcut)) {
                    self.state.ask(command);
                }
            }
        }
    }
}

impl eframe::App for Shell {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn on_exit(&mut self) {
        self.keep_at_exit();
    }
}

impl Shell {
    /// One frame of the window.
    pub(crate) fn show(&mut self, ui: &mut Ui) {
        self.take_news();
        let idle = self.files.pending() == 0;
        // Nothing was being read, and nothing has come that may have begun to read more and be done
        // with it: the recordings are all here.
        if !crate::app::actions::intake::take(self) && idle {
            self.bring_back_kept();
        }
        self.take_diagnosis();
        if self.themed != Some(self.state.view.dark) {
            self.themed = Some(self.state.view.dark);
            theme::apply(ui.ctx(), self.state.view.dark);
        }
        self.shortcuts(ui);
        self.dropped(ui);
        self.top(ui);
        self.bottom(ui);
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            workspaces::show(ui, &mut self.state);
        });
        self.toasts(ui);
        crate::app::actions::run::dialogs(self, ui);
        crate::app::actions::run::run(self, ui);
        self.set_speed();
        self.ask_worker();
        self.keep(ui);
        self.layout.update(ui.ctx(), &self.state);
        self.picture(ui);
    }
}

/// A simulator's error at the parameter that it names.
fn refusal(error: &SimError) -> Refusal {
    Refusal {
        parameter: error.parameter().unwrap_or_default().to_owned(),
        message: error.to_string(),
    }
}

/// Starts the import of a session's recording.
pub(crate) fn import_entry(files: &Files, entry: &session_text::RecordingEntry) {
    if let Some(path) = &entry.path {
        files.import(path.clone(), entry.import.clone(), Some(entry.clone()));
    }
}
