//! What the commands do; menus and keys that ask for them.

use std::path::{Path, PathBuf};

use eframe::egui::{Button, InputState, KeyboardShortcut, Ui, ViewportCommand};

use crate::model::preset::{EMBEDDED, Preset};
use crate::recording::align::auto_align;
use crate::recording::{Channel, Grid, TimeAxis};

use super::command::Command;
use super::dialogs::Answer;
use super::files::{FileEvent, Purpose};
use super::session::{self, write_atomically};
use super::setup::{DriveChoice, Mode, Overlay, Picture};
use super::shell::{Shell, import_entry};
use super::state::{Cursors, State};
use super::workspaces::tune;
use super::{export, first_start, theme};

/// Whether a shortcut was pressed. Letters and signs must match their modifiers, but
/// for Shift where the sign itself needs it (`?`).
pub fn pressed(input: &mut InputState, shortcut: &KeyboardShortcut) -> bool {
    let exact = input.modifiers.matches_exact(shortcut.modifiers);
    let sign = shortcut.logical_key == eframe::egui::Key::Questionmark;
    (exact || sign) && input.consume_shortcut(shortcut)
}

/// The menus, all made of commands.
pub fn menus(shell: &mut Shell, ui: &mut Ui) {
    use Command as C;
    ui.menu_button("File", |ui| {
        items(shell, ui, &[C::Open, C::OpenPath]);
        ui.menu_button("Open recent", |ui| {
            let recent = session::recent();
            if recent.is_empty() {
                ui.weak("nothing yet");
            }
            for path in recent {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let entry = ui.button(name).on_hover_text(path.to_string_lossy());
                if entry.clicked() {
                    shell.files.open(path);
                }
            }
        });
        ui.menu_button("Open preset", |ui| {
            for (name, _) in EMBEDDED {
                if ui.button(name).clicked()
                    && let Some(preset) = Preset::embedded(name)
                {
                    tune::choose_preset(&mut shell.state.setup, &preset);
                }
            }
        });
        ui.separator();
        items(
            shell,
            ui,
            &[C::SaveSession, C::SaveSessionAs, C::SavePreset],
        );
        ui.separator();
        items(
            shell,
            ui,
            &[C::ExportSvg, C::ExportPng, C::ExportTrace, C::ExportEvents],
        );
        ui.separator();
        items(shell, ui, &[C::Quit]);
    });
    ui.menu_button("Edit", |ui| {
        items(shell, ui, &[C::Undo, C::Redo]);
        ui.separator();
        items(
            shell,
            ui,
            &[C::DriveEditor, C::ResetParameters, C::ResetAll],
        );
    });
    ui.menu_button("Recording", |ui| {
        items(
            shell,
            ui,
            &[
                C::AutoAlign,
                C::UseRecordedDrive,
                C::ImportSettings,
                C::RemoveRecording,
            ],
        );
    });
    ui.menu_button("View", |ui| {
        items(shell, ui, &Picture::ALL.map(C::TogglePicture));
        ui.separator();
        items(shell, ui, &[C::ZoomAll, C::ToggleGhost, C::ToggleTheme]);
    });
    ui.menu_button("Run", |ui| {
        items(
            shell,
            ui,
            &[
                C::SetMode(Mode::Window),
                C::SetMode(Mode::Live),
                C::TogglePause,
                C::Step,
                C::Restart,
            ],
        );
    });
    ui.menu_button("Help", |ui| {
        items(shell, ui, &[C::Help, C::Palette]);
        if ui.button("About").clicked() {
            shell.dialogs.open_about();
        }
    });
}

fn items(shell: &mut Shell, ui: &mut Ui, commands: &[Command]) {
    for &command in commands {
        let (name, line) = command.text();
        let mark = match command {
            Command::TogglePicture(picture) => shell.state.view.pictures.contains(&picture),
            Command::SetMode(mode) => shell.state.view.mode == mode,
            _ => false,
        };
        let mut button = Button::selectable(mark, name);
        if let Some(keys) = command.shortcut() {
            button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
        }
        let entry = ui.add_enabled(is_possible(shell, command), button);
        if entry.on_hover_text(line).clicked() {
            shell.state.ask(command);
        }
    }
}

/// Whether a command would do anything now.
pub fn is_possible(shell: &Shell, command: Command) -> bool {
    let state = &shell.state;
    let live = state.view.mode == Mode::Live;
    match command {
        Command::Undo => shell.history.can_undo(),
        Command::Redo => shell.history.can_redo(),
        Command::TogglePause | Command::Restart => live,
        Command::Step => live && state.paused,
        Command::AutoAlign => !state.setup.overlays.is_empty() && state.snapshot.is_some(),
        Command::RemoveRecording | Command::UseRecordedDrive => selected(state).is_some(),
        Command::ImportSettings => selected(state).is_some_and(|o| o.recording.path.is_some()),
        Command::ExportSvg
        | Command::ExportPng
        | Command::ExportTrace
        | Command::ExportEvents
        | Command::ToggleGhost => state.snapshot.is_some(),
        _ => true,
    }
}

fn selected(state: &State) -> Option<&Overlay> {
    let overlays = &state.setup.overlays;
    overlays
        .iter()
        .find(|overlay| Some(overlay.id) == state.selected)
}

/// Runs the commands asked for in this frame.
pub fn run(shell: &mut Shell, ui: &Ui) {
    for command in std::mem::take(&mut shell.state.commands) {
        if is_possible(shell, command) {
            run_one(shell, ui, command);
        }
    }
}

fn run_one(shell: &mut Shell, ui: &Ui, command: Command) {
    let state = &mut shell.state;
    match command {
        Command::Open => shell.files.open_dialog(),
        Command::OpenPath => shell.dialogs.ask_path(None),
        Command::SaveSession => match shell.session_path.clone() {
            Some(path) => save(shell, Purpose::Session, &path),
            None => shell.dialogs.ask_path(Some(Purpose::Session)),
        },
        Command::SaveSessionAs => shell.dialogs.ask_path(Some(Purpose::Session)),
        Command::SavePreset => shell.dialogs.ask_path(Some(Purpose::Preset)),
        Command::ExportSvg => shell.dialogs.ask_path(Some(Purpose::Svg)),
        Command::ExportPng => shell.dialogs.ask_path(Some(Purpose::Png)),
        Command::ExportTrace => shell.dialogs.ask_path(Some(Purpose::Trace)),
        Command::ExportEvents => shell.dialogs.ask_path(Some(Purpose::Events)),
        Command::Undo => {
            shell.history.undo(&mut state.setup);
        }
        Command::Redo => {
            shell.history.redo(&mut state.setup);
        }
        Command::ResetParameters => {
            let name = state.setup.preset.model.name.clone();
            if let Some(preset) = Preset::embedded(&name) {
                state.setup.preset = preset;
            }
            state.setup.locked.clear();
        }
        Command::ResetAll => {
            state.setup = first_start::setup();
            state.view = super::setup::View::default();
            state.ghost = None;
            state.cursors = Cursors::default();
            state.selected = state.setup.overlays.first().map(|o| o.id);
            theme::apply(ui.ctx(), state.view.dark);
            shell.hint = true;
        }
        Command::SetMode(mode) => {
            state.view.mode = mode;
            state.scrub = None;
            state.cursors = Cursors::default();
        }
        Command::TogglePause => {
            state.paused = !state.paused;
            if !state.paused {
                state.scrub = None;
            }
        }
        Command::Step => shell.steps += 1,
        Command::Restart => {
            shell.restarts += 1;
            state.scrub = None;
            state.paused = false;
        }
        Command::ToggleGhost => {
            state.ghost = match state.ghost.take() {
                Some(_) => None,
                None => state.snapshot.clone(),
            };
        }
        Command::TogglePicture(picture) => {
            if !state.view.pictures.remove(&picture) {
                state.view.pictures.insert(picture);
            }
        }
        Command::ZoomAll => state.view.time_range = None,
        Command::ToggleTheme => {
            state.view.dark = !state.view.dark;
            theme::apply(ui.ctx(), state.view.dark);
        }
        Command::Help => shell.dialogs.toggle_help(),
        Command::DriveEditor => state.drive_editor_open = !state.drive_editor_open,
        Command::AutoAlign => align(shell),
        Command::ImportSettings => {
            if let Some(path) = selected(state).and_then(|o| o.recording.path.clone()) {
                shell.files.ask(path);
            }
        }
        Command::RemoveRecording => {
            if let Some(id) = state.selected {
                tune::remove_recording(state, id);
            }
        }
        Command::UseRecordedDrive => {
            if let Some(overlay) = selected(state) {
                state.setup.drive = DriveChoice::Recorded(overlay.id);
            }
        }
        Command::Palette => shell.dialogs.open_palette(),
        Command::Quit => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
    }
}

/// Shifts the selected recording, or all if none is selected, onto the simulation.
fn align(shell: &mut Shell) {
    let Some(snapshot) = shell.state.snapshot.clone() else {
        return;
    };
    let grid = Grid {
        t0: snapshot.trace.t0,
        dt: snapshot.trace.dt,
        values: &snapshot.trace.proof_mass,
        slopes: Some(&snapshot.trace.proof_mass_velocity),
    };
    let only = shell.state.selected;
    let mut problems = Vec::new();
    for overlay in &mut shell.state.setup.overlays {
        if only.is_some_and(|id| id != overlay.id) {
            continue;
        }
        match auto_align(&overlay.recording, Channel::ProofMass, grid, None) {
            Ok(found) => overlay.alignment.time_shift = found.time_shift,
            Err(error) => problems.push(format!("{}: {error}", overlay.recording.name)),
        }
    }
    for problem in problems {
        shell.notice(true, problem);
    }
}

/// Saves what is asked for to a path.
fn save(shell: &mut Shell, purpose: Purpose, path: &Path) {
    let state = &shell.state;
    let trace = state.snapshot.as_ref().map(|snapshot| &snapshot.trace);
    let result: Result<(), String> = match (purpose, trace) {
        (Purpose::Session, _) => {
            session::save(path, &state.setup, &state.view, &shell.absent).map_err(|e| e.to_string())
        }
        (Purpose::Preset, _) => {
            let mut preset = state.setup.preset.clone();
            if let DriveChoice::Waveform(waveform) = &state.setup.drive {
                let text = waveform.to_string();
                // A table has no form on one line: the preset keeps its own drive.
                if !text.starts_with("table:") {
                    preset.drive = text;
                }
            }
            preset.duration = state.setup.duration;
            write_atomically(path, preset.to_toml().as_bytes()).map_err(|e| e.to_string())
        }
        (Purpose::Svg, Some(_)) => export::svg(path, state).map_err(|e| e.to_string()),
        (Purpose::Png, Some(_)) => export::png(path, state).map_err(|e| e.to_string()),
        (Purpose::Trace, Some(trace)) => {
            let mut bytes = Vec::new();
            let axis = TimeAxis::Samples(&trace.times());
            let cantilever = (!trace.cantilever.is_empty()).then_some(trace.cantilever.as_slice());
            crate::recording::csv::write_csv(
                &mut bytes,
                axis,
                Some(&trace.voltage),
                &trace.proof_mass,
                cantilever,
            )
            .map_err(|e| e.to_string())
            .and_then(|()| write_atomically(path, &bytes).map_err(|e| e.to_string()))
        }
        (Purpose::Events, Some(trace)) => crate::recording::events_file::write(path, &trace.events)
            .map_err(|e| format!("{}: {e}", path.display())),
        (_, None) => Err("there is no simulated run yet".to_owned()),
    };
    match result {
        Ok(()) => {
            if purpose == Purpose::Session {
                shell.session_path = Some(path.to_owned());
                session::remember(path, None);
            }
            shell.notice(false, format!("Saved {}", path.display()));
        }
        Err(reason) => shell.notice(true, format!("Not saved: {reason}")),
    }
}

/// Draws the dialogs and does what they answer.
pub fn dialogs(shell: &mut Shell, ui: &mut Ui) {
    match shell.dialogs.show(ui) {
        None => {}
        Some(Answer::Command(command)) => shell.state.ask(command),
        Some(Answer::Open(path)) => shell.files.open(path),
        Some(Answer::Save(purpose, path)) => save(shell, purpose, &path),
        Some(Answer::Import(path, settings)) => shell.files.import(path, settings, None),
        Some(Answer::Browse(None)) => shell.files.open_dialog(),
        Some(Answer::Browse(Some(purpose))) => shell.files.save_dialog(purpose),
    }
}

/// Takes over what has become of files.
pub fn take_files(shell: &mut Shell) {
    for event in shell.files.poll() {
        match event {
            FileEvent::Recording {
                path,
                settings,
                recording,
                entry,
            } => {
                session::remember(&path, Some(&settings));
                for warning in &recording.warnings {
                    shell.notice(false, format!("{}: {}", recording.name, warning.message));
                }
                add_recording(shell, path, settings, recording, entry);
            }
            FileEvent::Ask { path, preview } => {
                let known = shell
                    .state
                    .setup
                    .overlays
                    .iter()
                    .find(|o| o.recording.path.as_ref() == Some(&path))
                    .map(|o| o.import.clone());
                shell.dialogs.ask_import(path, preview, known);
            }
            FileEvent::Preset { preset } => tune::choose_preset(&mut shell.state.setup, &preset),
            FileEvent::Session { path, loaded } => {
                session::remember(&path, None);
                shell.next_overlay = shell.next_overlay.max(loaded.last_id());
                for text in &loaded.missing {
                    shell.notice(true, text.clone());
                }
                shell.absent = loaded.recordings.clone();
                shell.state.setup = loaded.setup;
                shell.state.view = loaded.view;
                shell.session_path = Some(path);
                for entry in &loaded.recordings {
                    import_entry(&shell.files, entry);
                }
            }
            FileEvent::Failed { message } => shell.notice(true, message),
            FileEvent::SaveTo { purpose, path } => save(shell, purpose, &path),
        }
    }
}

/// Adds a recording; one read again from the same file replaces its former self.
fn add_recording(
    shell: &mut Shell,
    path: PathBuf,
    settings: crate::recording::csv::ImportSettings,
    recording: std::sync::Arc<crate::recording::Recording>,
    entry: Option<session::RecordingEntry>,
) {
    let overlays = &mut shell.state.setup.overlays;
    let former = overlays
        .iter()
        .position(|o| o.recording.path.as_deref() == Some(&path));
    let (alignment, color, visible) = match (&entry, former) {
        (Some(entry), _) => (entry.alignment, entry.color, entry.visible),
        (None, Some(i)) => (overlays[i].alignment, overlays[i].color, true),
        (None, None) => {
            let color = (0..)
                .find(|c| overlays.iter().all(|o| o.color != *c))
                .unwrap_or(0);
            (crate::recording::align::Alignment::default(), color, true)
        }
    };
    if let Some(entry) = &entry {
        shell.absent.retain(|absent| absent.id != entry.id);
    }
    // Data that changed take a new number: what was computed for the old one is void.
    let id = match &entry {
        Some(entry) => entry.id,
        None => {
            shell.next_overlay += 1;
            shell.next_overlay
        }
    };
    let overlay = Overlay {
        id,
        recording,
        import: settings,
        alignment,
        visible,
        color,
        made_up: false,
    };
    match former {
        Some(i) => {
            if shell.state.setup.drive == DriveChoice::Recorded(overlays[i].id) {
                shell.state.setup.drive = DriveChoice::Recorded(id);
            }
            overlays[i] = overlay;
        }
        None => overlays.push(overlay),
    }
    shell.state.selected = Some(id);
}
