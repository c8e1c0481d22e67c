//! The frame around the workspaces: it notices changes, asks the worker, shows its news,
//! runs commands, keeps history and autosave.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::{self, CentralPanel, Context, Frame, Panel, RichText, Ui, ViewportCommand};

use crate::model::drive::{VoltageTable, Waveform};
use crate::model::preset::Preset;
use crate::sim::SimError;

use super::command::Command;
use super::dialogs::Dialogs;
use super::files::Files;
use super::history::History;
use super::layout::Layout;
use super::setup::{DriveChoice, Mode, OverlayId, Picture, Setup, View};
use super::state::{Notice, Refusal, State};
use super::worker::{News, Wish, Worker};
use super::{WindowOptions, first_start, session, theme, workspaces};

/// Quiet time before the session is autosaved [s].
const AUTOSAVE_AFTER: f64 = 2.0;
/// Quiet frames before the picture of `--screenshot` is taken.
const SETTLED_FRAMES: u32 = 12;

/// Outcome of `--screenshot`, handed out of the event loop.
pub type PictureOutcome = Arc<Mutex<Option<Result<(), String>>>>;

/// The application.
pub struct Shell {
    pub(super) state: State,
    pub(super) history: History,
    pub(super) files: Files,
    pub(super) dialogs: Dialogs,
    /// File of the session, once it has one.
    pub(super) session_path: Option<PathBuf>,
    pub(super) restarts: u64,
    pub(super) steps: u64,
    pub(super) hint: bool,
    pub(super) next_overlay: OverlayId,
    /// Recordings of the session that could not be loaded: kept in it, for when their
    /// files are back.
    pub(super) absent: Vec<session::RecordingEntry>,
    workspace: String,
    worker: Worker,
    sent: Option<Wish>,
    recorded: Option<(OverlayId, Result<Waveform, String>)>,
    saved: (Setup, View),
    changed_at: Option<f64>,
    layout: Layout,
    picture: Option<(PathBuf, u32)>,
    outcome: PictureOutcome,
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
            restore(&mut notices)
        } else {
            None
        };
        let hint = plain && restored.is_none();
        let (mut last_id, mut absent) = (0, Vec::new());
        let (setup, view) = match restored {
            Some(loaded) => {
                for entry in &loaded.recordings {
                    import_entry(&files, entry);
                }
                notices.extend(loaded.missing.iter().map(|text| Notice {
                    is_error: true,
                    text: text.clone(),
                }));
                last_id = loaded.last_id();
                absent = loaded.recordings;
                (loaded.setup, loaded.view)
            }
            None => {
                let setup = match preset {
                    Some(preset) => first_start::from_preset(preset),
                    None if plain => first_start::setup(),
                    None => first_start::from_preset(Preset::default()),
                };
                (setup, View::default())
            }
        };
        for file in options.files {
            files.open(file);
        }
        theme::apply(context, view.dark);
        let shown = setup.overlays.iter().map(|o| o.id).max().unwrap_or(0);
        let mut state = first_start::state(setup, view);
        state.notices = notices;
        Ok(Self {
            history: History::new(&state.setup),
            saved: (state.setup.clone(), state.view.clone()),
            state,
            files,
            dialogs: Dialogs::default(),
            session_path: None,
            restarts: 0,
            steps: 0,
            hint,
            next_overlay: last_id.max(shown),
            absent,
            workspace: options
                .workspace
                .unwrap_or_else(|| workspaces::NAMES[0].to_owned()),
            worker,
            sent: None,
            recorded: None,
            changed_at: None,
            layout: Layout::new(),
            picture: options.screenshot.map(|path| (path, 0)),
            outcome,
        })
    }

    /// Adds a line at the top of the window, once.
    pub(super) fn notice(&mut self, is_error: bool, text: impl Into<String>) {
        let notice = Notice {
            is_error,
            text: text.into(),
        };
        if !self.state.notices.contains(&notice) {
            self.state.notices.push(notice);
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
                News::Broken(text) => self.notice(
                    true,
                    format!("internal error in the simulator: {text}. The window goes on; undo the last change"),
                ),
            }
        }
    }

    /// The drive with a recording's voltage resolved; made once per recording.
    fn drive(&mut self) -> Result<Waveform, String> {
        let id = match &self.state.setup.drive {
            DriveChoice::Waveform(waveform) => return Ok(waveform.clone()),
            DriveChoice::Recorded(id) => *id,
        };
        let overlay = self.state.setup.overlays.iter().find(|o| o.id == id);
        let Some(overlay) = overlay else {
            return Err("the recording that drives is gone; choose another drive".to_owned());
        };
        if let Some((known, drive)) = &self.recorded
            && *known == id
        {
            return drive.clone();
        }
        let name = overlay.recording.name.clone();
        let drive = match overlay.recording.drive_table() {
            None => Err(format!("{name} has no voltage; choose another drive")),
            Some((time, voltage)) => VoltageTable::from_recording(name, time, voltage)
                .map(|table| Waveform::Table(Arc::new(table)))
                .map_err(|error| error.to_string()),
        };
        self.recorded = Some((id, drive.clone()));
        drive
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
        if let Err(error) = state.setup.preset.model.check() {
            self.state.refusal = Some(Refusal {
                parameter: error.parameter,
                message: error.reason,
            });
            return;
        }
        let same_model = self
            .sent
            .as_ref()
            .filter(|sent| *sent.model == state.setup.preset.model)
            .map(|sent| Arc::clone(&sent.model));
        let pictures = &state.view.pictures;
        let wish = Wish {
            model: same_model.unwrap_or_else(|| Arc::new(state.setup.preset.model.clone())),
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

    fn top(&mut self, ui: &mut Ui) {
        Panel::top("menu").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                super::actions::menus(self, ui);
                ui.separator();
                for name in workspaces::NAMES {
                    let title = workspaces::title(name);
                    if ui.selectable_label(self.workspace == name, title).clicked() {
                        self.workspace = name.to_owned();
                    }
                }
            });
        });
        if self.state.notices.is_empty() && !self.hint {
            return;
        }
        Panel::top("notices").show(ui, |ui| {
            let dark = ui.visuals().dark_mode;
            let mut dismissed = None;
            for (i, notice) in self.state.notices.iter().enumerate().take(6) {
                ui.horizontal_wrapped(|ui| {
                    let mut text = RichText::new(&notice.text);
                    if notice.is_error {
                        text = text.color(theme::error(dark));
                    }
                    if ui.small_button("Dismiss").clicked() {
                        dismissed = Some(i);
                    }
                    ui.label(text);
                });
            }
            let more = self.state.notices.len().saturating_sub(6);
            if more > 0 {
                ui.weak(format!("and {more} more"));
            }
            if let Some(i) = dismissed {
                self.state.notices.remove(i);
            }
            if self.hint {
                ui.horizontal(|ui| {
                    ui.vertical(|ui| {
                        for line in first_start::HINT {
                            ui.label(line);
                        }
                    });
                    if ui.button("Got it").clicked() {
                        self.hint = false;
                    }
                });
            }
        });
    }

    fn bottom(&self, ui: &mut Ui) {
        Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                let Some(snapshot) = &self.state.snapshot else {
                    ui.weak("computing");
                    return;
                };
                let trace = &snapshot.trace;
                if let Some(live) = snapshot.live {
                    let speed = crate::model::unit::format_number(live.speed, 2);
                    ui.weak(format!("live: {speed} simulated seconds per second"));
                } else {
                    ui.weak(format!(
                        "{} samples, {} steps, {} events in {:.1} ms",
                        trace.len(),
                        trace.steps,
                        trace.events.len(),
                        snapshot.cost.as_secs_f64() * 1e3
                    ));
                }
                if self.files.pending() > 0 {
                    ui.separator();
                    ui.spinner();
                    for work in self.files.working() {
                        let name = work.path.file_name().unwrap_or_default();
                        let percent = 100.0 * work.fraction;
                        ui.label(format!("reading {} {percent:.0} %", name.to_string_lossy()));
                    }
                    if ui.small_button("Cancel").clicked() {
                        self.files.cancel();
                    }
                }
                if let Some(refusal) = &self.state.refusal {
                    ui.separator();
                    let color = theme::error(ui.visuals().dark_mode);
                    ui.colored_label(color, format!("not shown: {}", refusal.message));
                }
            });
        });
    }

    fn shortcuts(&mut self, ui: &Ui) {
        if ui.ctx().text_edit_focused() || self.dialogs.is_open() {
            return;
        }
        for command in Command::all() {
            let Some(shortcut) = command.shortcut() else {
                continue;
            };
            // The key of a command that would do nothing is left to the widgets.
            if !super::actions::is_possible(self, command) {
                continue;
            }
            if ui.input_mut(|input| super::actions::pressed(input, &shortcut)) {
                self.state.ask(command);
            }
        }
    }

    fn dropped(&mut self, ui: &mut Ui) {
        let (dropped, hovering) = ui.input(|input| {
            let paths: Vec<PathBuf> = input
                .raw
                .dropped_files
                .iter()
                .map(|file| file.path().to_path_buf())
                .collect();
            (paths, !input.raw.hovered_files.is_empty())
        });
        for path in dropped {
            self.files.open(path);
        }
        if hovering {
            let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop"));
            let rect = ui.ctx().content_rect();
            let painter = ui.ctx().layer_painter(layer);
            painter.rect_filled(rect, 0.0, egui::Color32::from_black_alpha(160));
            painter.text(
                rect.center(),
                egui::Align2::CENTER_CENTER,
                "Drop recordings, a preset or a session",
                egui::FontId::proportional(26.0),
                egui::Color32::WHITE,
            );
        }
    }

    fn keep(&mut self, ui: &Ui) {
        let now = ui.input(|input| input.time);
        let busy =
            ui.input(|input| input.pointer.any_down()) || ui.ctx().egui_wants_keyboard_input();
        if self.history.observe(&self.state.setup, busy, now) {
            ui.ctx()
                .request_repaint_after(std::time::Duration::from_millis(350));
        }
        let current = (&self.state.setup, &self.state.view);
        if current != (&self.saved.0, &self.saved.1) && self.picture.is_none() {
            self.saved = (self.state.setup.clone(), self.state.view.clone());
            self.changed_at = Some(now);
        }
        if let Some(changed) = self.changed_at {
            if now - changed >= AUTOSAVE_AFTER {
                self.changed_at = None;
                self.autosave();
            } else {
                ui.ctx()
                    .request_repaint_after(std::time::Duration::from_secs_f64(
                        AUTOSAVE_AFTER - (now - changed) + 0.01,
                    ));
            }
        }
    }

    fn autosave(&mut self) {
        let Some(path) = session::autosave_path() else {
            return;
        };
        if let Err(error) = session::save(&path, &self.state.setup, &self.state.view, &self.absent)
        {
            self.notice(true, format!("autosave: {error}"));
        }
    }

    /// Takes the picture of `--screenshot` once nothing moves any more.
    fn picture(&mut self, ui: &Ui) {
        let live = self.state.view.mode == Mode::Live;
        let busy = self.state.snapshot.is_none()
            || self.files.pending() > 0
            || (!live
                && self
                    .state
                    .snapshot
                    .as_ref()
                    .is_some_and(|s| s.features.is_none()));
        let Some((path, frames)) = &mut self.picture else {
            return;
        };
        ui.ctx().request_repaint();
        if busy {
            *frames = 0;
            return;
        }
        *frames += 1;
        if *frames != SETTLED_FRAMES {
            return;
        }
        let (path, outcome, context) = (path.clone(), Arc::clone(&self.outcome), ui.ctx().clone());
        let callback = egui::ScreenshotCallback::new(move |image| {
            let [width, height] = image.size;
            let result = image::save_buffer(
                &path,
                image.as_raw(),
                width as u32,
                height as u32,
                image::ColorType::Rgba8,
            )
            .map_err(|error| format!("{}: {error}", path.display()));
            *outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            context.send_viewport_cmd(ViewportCommand::Close);
        });
        ui.ctx()
            .send_viewport_cmd(ViewportCommand::Screenshot(callback));
    }
}

impl eframe::App for Shell {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.take_news();
        super::actions::take_files(self);
        self.shortcuts(ui);
        self.dropped(ui);
        self.top(ui);
        self.bottom(ui);
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            workspaces::show(&self.workspace, ui, &mut self.state);
        });
        super::actions::dialogs(self, ui);
        super::actions::run(self, ui);
        self.ask_worker();
        self.keep(ui);
        self.layout.update(ui.ctx(), &self.state);
        self.picture(ui);
    }

    fn on_exit(&mut self) {
        if self.outcome.lock().is_ok_and(|outcome| outcome.is_none()) {
            self.autosave();
        }
    }
}

/// A simulator's error at the parameter that it names.
fn refusal(error: &SimError) -> Refusal {
    Refusal {
        parameter: error.parameter().unwrap_or_default().to_owned(),
        message: error.to_string(),
    }
}

/// The autosaved session, if there is one that can be read; one that cannot is kept.
fn restore(notices: &mut Vec<Notice>) -> Option<session::Loaded> {
    let path = session::autosave_path()?;
    if !path.exists() {
        return None;
    }
    match session::load(&path) {
        Ok(loaded) => Some(loaded),
        Err(error) => {
            let kept = match session::keep_unreadable(&path) {
                Ok(kept) => format!("it was kept as {}", kept.display()),
                Err(error) => error.to_string(),
            };
            notices.push(Notice {
                is_error: true,
                text: format!("The last session could not be opened: {error}; {kept}"),
            });
            None
        }
    }
}

/// Starts the import of a session's recording.
pub(super) fn import_entry(files: &Files, entry: &session::RecordingEntry) {
    if let Some(path) = &entry.path {
        files.import(path.clone(), entry.import.clone(), Some(entry.clone()));
    }
}
