//! The window: owns the services, draws bars, workspace, notices and dialogs, and runs the
//! commands asked for in a frame.

use std::path::PathBuf;
use std::time::Duration;

use eframe::egui::{CentralPanel, Context, Frame, Ui};

use super::autosave::{self, Autosave, Slot, Start};
use super::kept_curves::KeptCurves;
use super::layout_dump::Layout;
use super::options::WindowOptions;
use super::screenshot::{PictureOutcome, Screenshot};
use super::simulator::{self, Simulator};
use super::{bars, diagnosis, toasts};
use crate::app::actions::{intake, learn, run};
use crate::app::files::built_in;
use crate::app::files::open::Files;
use crate::app::files::recent::absolute;
use crate::app::flows::open_case;
use crate::app::kept;
use crate::app::services::Services;
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::notice::Notice;
use crate::app::setup::view::View;
use crate::app::state::State;
use crate::app::{theme, workspaces};
use crate::model::preset::Preset;

/// Time after which a change in progress is looked at again \[s\]: a little more than the
/// undo history needs to take it as finished.
const UNDO_RECHECK: Duration = Duration::from_millis(350);

/// The application.
pub struct Shell {
    pub(crate) services: Services,
    simulator: Simulator,
    kept_curves: KeptCurves,
    autosave: Autosave,
    layout: Layout,
    /// The theme whose colours are set.
    applied_dark: Option<bool>,
    /// Whether things glide, as it is set.
    applied_motion: Option<bool>,
    screenshot: Option<Screenshot>,
}

impl Shell {
    /// Builds the window's contents.
    ///
    /// # Errors
    /// The system's, if the simulator thread cannot be started.
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
        let simulator = Simulator::start(repaint.clone())?;
        let files = Files::new(repaint.clone());
        let (services, slot) = first_services(&options, preset, files);
        theme::apply(context, services.state.view.dark);
        Ok(Self {
            simulator,
            kept_curves: KeptCurves::new(repaint),
            autosave: Autosave::new(&services.state, slot),
            layout: Layout::new(),
            applied_dark: Some(services.state.view.dark),
            applied_motion: None,
            screenshot: options
                .screenshot
                .map(|path| Screenshot::new(path, outcome)),
            services,
        })
    }

    /// One frame of the window.
    pub(crate) fn show(&mut self, ui: &mut Ui) {
        let services = &mut self.services;
        self.simulator.receive(services);
        let idle = services.files.pending() == 0;
        // No file was being read before, and none has arrived since that could have started
        // another: all recordings are there.
        let is_reading = intake::receive(services) || !idle;
        self.kept_curves.update(services, !is_reading);
        diagnosis::update(services, is_reading, ui.ctx());
        // Results are taken whichever workspace and panel is open.
        let state = &mut services.state;
        state.fitting.poll(&state.setup);
        if state.diagnosing.trial.suspended.is_none() {
            // The results of a suspended trial's device wait for that device.
            state.identification.collect(&state.setup);
        }
        if self.applied_dark != Some(services.state.view.dark) {
            self.applied_dark = Some(services.state.view.dark);
            theme::apply(ui.ctx(), services.state.view.dark);
        }
        let is_still = services.state.view.less_motion;
        if self.applied_motion != Some(is_still) {
            self.applied_motion = Some(is_still);
            theme::set_motion(ui.ctx(), is_still);
        }
        open_case::advance(&mut services.state, ui.ctx());
        shortcuts(services, ui);
        bars::dropped_files(services, ui);
        if services.state.presenting.is_some() {
            workspaces::present::show(ui, &mut services.state);
        } else {
            bars::menu_bar(services, ui);
            bars::status_bar(services, ui);
            CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
                workspaces::show(ui, &mut services.state);
            });
        }
        toasts::show(services, ui);
        run::dialogs(services, ui);
        run::run(services, ui);
        simulator::set_usual_speed(services);
        self.simulator.request(services);
        record_history(services, ui);
        self.autosave.update(services, ui);
        self.layout.update(ui.ctx(), &services.state);
        if let Some(screenshot) = &mut self.screenshot {
            screenshot.update(services, ui, self.simulator.is_broken);
        }
    }
}

impl eframe::App for Shell {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn on_exit(&mut self) {
        self.autosave.save_at_exit(&self.services);
    }
}

/// What the window starts with: the given files and preset, else the autosaved session,
/// else the first start's device and recording. And the file of its own autosaved session;
/// a window opened for a screenshot has none and leaves the sessions alone.
fn first_services(
    options: &WindowOptions,
    preset: Option<Preset>,
    files: Files,
) -> (Services, Option<Slot>) {
    let has_no_input = options.files.is_empty() && preset.is_none();
    let mut notices = Vec::new();
    let start = if has_no_input {
        Start::LastSession
    } else {
        Start::Files
    };
    let slot = if options.screenshot.is_none() {
        autosave::own_slot(start, &mut notices)
    } else {
        None
    };
    let restored = slot
        .as_ref()
        .filter(|_| has_no_input)
        .and_then(|slot| autosave::restore(slot, &mut notices));
    let is_restored = restored.is_some();
    let (mut last_id, mut missing_recordings) = (0, Vec::new());
    let mut results = String::new();
    let (setup, view) = match restored {
        Some(loaded) => {
            for entry in &loaded.recordings {
                files.import_session_recording(entry);
            }
            let missing = loaded.missing.iter();
            notices.extend(missing.map(|text| Notice::new(true, text.as_str())));
            last_id = loaded.last_id();
            missing_recordings = loaded.recordings;
            results = loaded.results;
            (loaded.setup, loaded.view)
        }
        None => (first_setup(preset, has_no_input), View::default()),
    };
    let entries = missing_recordings.iter();
    let mut requested_files: Vec<PathBuf> = entries.filter_map(|e| e.path.clone()).collect();
    for file in &options.files {
        requested_files.push(absolute(file));
        files.open(file.clone());
    }
    let shown = setup.overlays.iter().map(|o| o.id).max().unwrap_or(0);
    let mut state = State::new(setup, view);
    let lost = kept::restore(&mut state, &results);
    notices.extend(lost.map(|text| Notice::new(true, text)));
    if let Some(workspace) = &options.workspace {
        state.view.workspace.clone_from(workspace);
    }
    state.notices = notices;
    let mut services = Services::new(state, files);
    if is_restored {
        // A restored session keeps the live speed that was set in it.
        let name = &services.state.setup.preset.model.name;
        services.speed_set_for.clone_from(name);
    }
    services.shows_hint = has_no_input && !is_restored;
    services.last_overlay_id = last_id.max(shown);
    services.missing_recordings = missing_recordings;
    services.requested_files = requested_files;
    (services, slot)
}

fn first_setup(preset: Option<Preset>, has_no_input: bool) -> Setup {
    match preset {
        Some(preset) => built_in::from_preset(preset),
        None if has_no_input => built_in::setup(),
        None => built_in::from_preset(Preset::default()),
    }
}

/// Asks for the commands whose keys were pressed.
fn shortcuts(services: &mut Services, ui: &Ui) {
    if ui.ctx().text_edit_focused() || services.dialogs.is_open() {
        return;
    }
    // The presenter has keys of its own.
    if services.state.presenting.is_some() {
        return;
    }
    for command in Command::all() {
        if learn::takes_keys(&services.state) && !is_for_lessons(ui, command) {
            continue;
        }
        // The key of a command that would do nothing goes to the widgets.
        if !run::is_possible(services, command) {
            continue;
        }
        for shortcut in command.shortcuts() {
            if ui.input_mut(|input| run::pressed(input, &shortcut)) {
                services.state.ask(command);
            }
        }
    }
}

/// Whether a command takes its key in the lessons: their own do, and what is held with Ctrl. A key
/// that a focused control uses is left to it.
fn is_for_lessons(ui: &Ui, command: Command) -> bool {
    let has_focus = ui.memory(|memory| memory.focused().is_some());
    match command {
        Command::TogglePause | Command::Restart | Command::Step => !has_focus,
        Command::Learn(_) => true,
        Command::Help | Command::ToggleTheme | Command::Present => true,
        _ => command
            .shortcut()
            .is_some_and(|keys| keys.modifiers.command),
    }
}

/// Lets the undo history see the setup of this frame.
fn record_history(services: &mut Services, ui: &Ui) {
    let now = ui.input(|input| input.time);
    let busy = ui.input(|input| input.pointer.any_down()) || ui.ctx().egui_wants_keyboard_input();
    if services.history.observe(&services.state.setup, busy, now) {
        ui.ctx().request_repaint_after(UNDO_RECHECK);
    }
}
