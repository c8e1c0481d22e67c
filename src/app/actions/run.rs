//! Runs the commands asked for in a frame: which of them are possible now, and what each
//! one does.

use std::sync::Arc;

use eframe::egui::{Event, InputState, Key, KeyboardShortcut, Ui, ViewportCommand};

use super::save::save;
use super::{kept_curves, learn};
use crate::app::analysis::diagnosis;
use crate::app::analysis::explore::source::drive_of;
use crate::app::dialogs::{Answer, Target};
use crate::app::files::built_in;
use crate::app::files::event::{FileEvent, Purpose};
use crate::app::services::Services;
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::choose_preset;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::setup::explore::DriveSource;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::{Picture, View};
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::state::{Cursors, State};
use crate::app::widgets::slider_search;
use crate::app::workspaces::tune::recordings::remove as remove_recording;
use crate::recording::align::auto_align;
use crate::recording::{Channel, Grid};

/// Whether a shortcut was pressed; consumes the key press.
///
/// The modifiers are those of the press itself: on a slow display they are released before
/// the frame is drawn. They must match exactly, except that Shift is ignored for `?` and `/`,
/// which need it on many keyboards.
pub fn pressed(input: &mut InputState, shortcut: &KeyboardShortcut) -> bool {
    let sign = matches!(shortcut.logical_key, Key::Questionmark | Key::Slash);
    let before = input.events.len();
    input.events.retain(|event| {
        let Event::Key {
            key,
            pressed: true,
            modifiers,
            ..
        } = event
        else {
            return true;
        };
        let mut modifiers = *modifiers;
        modifiers.shift &= !sign;
        *key != shortcut.logical_key || !modifiers.matches_exact(shortcut.modifiers)
    });
    input.events.len() < before
}

/// Whether a command would do anything now.
pub fn is_possible(services: &Services, command: Command) -> bool {
    let state = &services.state;
    let live = state.view.mode == Mode::Live;
    let diagnosing = &state.diagnosing;
    match command {
        Command::Undo => services.history.can_undo(),
        Command::Redo => services.history.can_redo(),
        Command::TogglePause | Command::Restart | Command::Step if learn::takes_keys(state) => {
            state.presenting.is_none() && state.learning.open.is_some()
        }
        Command::TogglePause | Command::Restart => live,
        Command::Step => live && state.paused,
        Command::Learn(command) => learn::is_possible(state, command),
        Command::LoadDrive | Command::UseDrawnDrive => state.setup.preset.model.piezo.is_some(),
        Command::AutoAlign => !state.setup.overlays.is_empty() && state.snapshot.is_some(),
        Command::SmallMultiples => state.setup.overlays.iter().filter(|o| o.visible).count() > 1,
        Command::RemoveRecording => selected(state).is_some(),
        Command::UseRecordedDrive => {
            state.setup.preset.model.piezo.is_some()
                && selected(state).is_some_and(|o| o.recording.voltage.is_some())
        }
        Command::ImportSettings => selected(state).is_some_and(|o| o.recording.path.is_some()),
        Command::ExportSvg
        | Command::ExportPng
        | Command::ExportTrace
        | Command::ExportEvents
        | Command::KeepCurve => state.snapshot.is_some(),
        Command::Diagnose | Command::DiagnoseByHand => {
            diagnosing.running.is_none() && diagnosis::obstacle(&state.setup).is_none()
        }
        Command::CancelDiagnosis => diagnosing.running.is_some(),
        Command::AcceptDiagnosis => {
            diagnosing.shown().is_some() && diagnosing.why_not_applied(&state.setup).is_none()
        }
        Command::SaveDiagnosed | Command::ExportReport | Command::ExportDiagnosis => {
            diagnosing.shown().is_some()
        }
        Command::SteadyState => {
            state.view.from_steady || drive_of(&state.setup, DriveSource::Tune).is_ok()
        }
        Command::ExportMap => state.exploring.map.run.growing().is_some(),
        Command::ExportGait => state.exploring.gait.feet.asked().is_some(),
        Command::Example => diagnosing.running.is_none() && diagnosing.trial.sealed.is_none(),
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
pub fn run(services: &mut Services, ui: &Ui) {
    for command in std::mem::take(&mut services.state.commands) {
        // The change is drawn in the next frame, which nothing else may request.
        ui.ctx().request_repaint();
        if is_possible(services, command) {
            run_one(services, ui, command);
        }
    }
}

fn run_one(services: &mut Services, ui: &Ui, command: Command) {
    let state = &mut services.state;
    match command {
        Command::Open => services.files.open_dialog(),
        Command::OpenPath => services.dialogs.ask_path(None),
        Command::NewDevice => services.dialogs.ask_device(),
        Command::SaveSession => save_session(services),
        Command::SaveSessionAs
        | Command::SavePreset
        | Command::ExportSvg
        | Command::ExportPng
        | Command::ExportTrace
        | Command::ExportEvents
        | Command::SaveDiagnosed
        | Command::ExportReport
        | Command::ExportDiagnosis => services.dialogs.ask_path(purpose(command)),
        Command::Undo | Command::Redo => go_in_history(services, command),
        Command::ResetParameters => {
            state.setup.preset = state.setup.original.as_ref().clone();
            state.setup.locked.clear();
        }
        Command::ResetAll => reset_all(services),
        Command::SetMode(mode) => set_mode(state, mode),
        Command::SteadyState => {
            state.view.from_steady = !state.view.from_steady;
            set_mode(state, Mode::WholeSpan);
        }
        Command::TogglePause | Command::Restart | Command::Step if learn::takes_keys(state) => {
            learn::play(state, command);
        }
        Command::TogglePause => toggle_pause(state),
        Command::Step => services.steps += 1,
        Command::Restart => {
            services.restarts += 1;
            state.scrub = None;
            state.paused = false;
        }
        Command::KeepCurve => kept_curves::keep(services),
        Command::Help => services.dialogs.toggle_help(),
        Command::AutoAlign => align(services),
        Command::ImportSettings => {
            if let Some(path) = selected(state).and_then(|o| o.recording.path.clone()) {
                services.files.ask(path);
            }
        }
        Command::RemoveRecording => {
            if let Some(id) = state.selected {
                remove_recording(state, id);
            }
        }
        Command::UseRecordedDrive => {
            if let Some(overlay) = selected(state) {
                state.setup.drive = DriveChoice::Recorded(overlay.id);
            }
        }
        Command::LoadDrive => services.dialogs.ask_file(Target::Drive),
        Command::Workspace(id) => state.view.workspace = id.name().to_owned(),
        Command::Diagnose
        | Command::DiagnoseByHand
        | Command::CancelDiagnosis
        | Command::AcceptDiagnosis
        | Command::Example
        | Command::SealedTrial => super::diagnosis::run(services, ui.ctx(), command),
        Command::Explore(_)
        | Command::UseDrawnDrive
        | Command::DrawTuneDrive
        | Command::LoadWaveform
        | Command::SaveWaveform
        | Command::ExportWaveform
        | Command::ExportMap
        | Command::ExportGait => super::explore::run(services, command),
        Command::Learn(_) | Command::Present | Command::ExportFilm => {
            learn::run(services, ui, command);
        }
        Command::FindSlider => {
            state.view.workspace = WorkspaceId::Tune.name().to_owned();
            slider_search::ask(ui.ctx());
        }
        Command::Palette => services.dialogs.open_palette(),
        Command::KeptCurves
        | Command::TogglePicture(_)
        | Command::ZoomAll
        | Command::ResidualUnit
        | Command::FixResidual
        | Command::SmallMultiples
        | Command::ToggleTheme
        | Command::LessMotion
        | Command::SidePanel
        | Command::Identification
        | Command::Sensitivity
        | Command::FitPanel
        | Command::Validation
        | Command::DriveEditor => change_view(state, command),
        Command::Quit => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
    }
}

/// Saves the session where it was saved before, or asks where.
fn save_session(services: &mut Services) {
    match services.session_path.clone() {
        Some(path) => save(services, Purpose::Session, path),
        None => services.dialogs.ask_path(Some(Purpose::Session)),
    }
}

fn go_in_history(services: &mut Services, command: Command) {
    let setup = &mut services.state.setup;
    if command == Command::Undo {
        services.history.undo(setup);
    } else {
        services.history.redo(setup);
    }
}

/// What a command writes whose path is asked for; `None` for the others.
fn purpose(command: Command) -> Option<Purpose> {
    Some(match command {
        Command::SaveSessionAs => Purpose::Session,
        Command::SavePreset => Purpose::Preset,
        Command::ExportSvg => Purpose::Svg,
        Command::ExportPng => Purpose::Png,
        Command::ExportTrace => Purpose::Trace,
        Command::ExportEvents => Purpose::Events,
        Command::SaveDiagnosed => Purpose::Diagnosed,
        Command::ExportReport => Purpose::Report,
        Command::ExportDiagnosis => Purpose::Diagnosis,
        _ => return None,
    })
}

fn toggle_pause(state: &mut State) {
    state.paused = !state.paused;
    if !state.paused {
        state.scrub = None;
    }
}

fn toggle_picture(state: &mut State, picture: Picture) {
    if !state.view.pictures.remove(&picture) {
        state.view.pictures.insert(picture);
        state.reveal = Some(picture);
    }
}

/// What is shown, and how.
fn change_view(state: &mut State, command: Command) {
    match command {
        Command::KeptCurves => state.kept_open = !state.kept_open,
        Command::TogglePicture(picture) => toggle_picture(state, picture),
        Command::ZoomAll => zoom_all(state),
        Command::ResidualUnit => state.view.switch_residual_unit(),
        Command::FixResidual => state.view.fix_residual_in_noise(),
        Command::SmallMultiples => state.view.switch_recording_layout(),
        Command::ToggleTheme => {
            state.view.dark = !state.view.dark;
        }
        Command::LessMotion => state.view.less_motion = !state.view.less_motion,
        Command::SidePanel => state.view.side_panel = !state.view.side_panel,
        Command::Identification => state.identification.open = !state.identification.open,
        Command::Sensitivity => state.sensing.open = !state.sensing.open,
        Command::FitPanel => state.fitting.open = !state.fitting.open,
        Command::Validation => state.validation_open = !state.validation_open,
        Command::DriveEditor => state.drive_editor_open = !state.drive_editor_open,
        _ => {}
    }
}

/// Back to the first start, in the present workspace.
fn reset_all(services: &mut Services) {
    let state = &mut services.state;
    state.setup = built_in::setup();
    state.view = View {
        workspace: state.view.workspace.clone(),
        ..View::default()
    };
    state.cursors = Cursors::default();
    state.selected = state.setup.overlays.first().map(|o| o.id);
    // A recording that is opened later must not take the number of one of these.
    let shown = state.setup.overlays.iter().map(|o| o.id).max();
    services.last_overlay_id = services.last_overlay_id.max(shown.unwrap_or(0));
    services.shows_hint = true;
}

/// Shows the whole span in time, and all values of each picture whose scale is not fixed.
fn zoom_all(state: &mut State) {
    state.view.time_range = None;
    state.view.zoom_out_values();
}

fn set_mode(state: &mut State, mode: Mode) {
    if mode == Mode::Live && state.view.mode != mode {
        // A person who starts the live mode wants to see it run, even if an earlier live
        // run was paused.
        state.paused = false;
    }
    if mode == Mode::WholeSpan {
        zoom_all(state);
    }
    state.view.mode = mode;
    state.scrub = None;
    state.cursors = Cursors::default();
}

/// Shifts the selected recording, or all if none is selected, onto the simulation.
fn align(services: &mut Services) {
    let Some(snapshot) = services.state.snapshot.clone() else {
        return;
    };
    let only = services.state.selected;
    for overlay in &services.state.setup.overlays {
        if only.is_some_and(|id| id != overlay.id) {
            continue;
        }
        let (id, recording) = (overlay.id, Arc::clone(&overlay.recording));
        let trace = Arc::clone(&snapshot.trace);
        let name = recording.name.clone();
        let scale = overlay.alignment.xp_scale;
        services.files.work("aligning", name.into(), move |_| {
            let grid = Grid {
                t0: trace.t0,
                dt: trace.dt,
                values: &trace.proof_mass,
                slopes: Some(&trace.proof_mass_velocity),
            };
            Some(
                match auto_align(&recording, Channel::ProofMass, scale, grid, None) {
                    Ok(found) => FileEvent::Aligned { id, found },
                    Err(error) => FileEvent::Failed {
                        message: format!("{} could not be aligned: {error}", recording.name),
                    },
                },
            )
        });
    }
}

/// Draws the dialogs and carries out their answers.
pub fn dialogs(services: &mut Services, ui: &mut Ui) {
    match services.dialogs.show(ui) {
        None => {}
        Some(Answer::Command(command)) => services.state.ask(command),
        Some(Answer::Open(path)) => services.files.open(path),
        Some(Answer::Drive(path)) => services.files.drive(path),
        Some(Answer::Waveform(path)) => services.files.drawn(path),
        Some(Answer::Found(id, path)) => {
            if let Some(entry) = services
                .missing_recordings
                .iter()
                .find(|entry| entry.id == id)
            {
                let settings = entry.import.clone();
                services.files.import(path, settings, Some(entry.clone()));
            }
        }
        Some(Answer::Save(purpose, path)) => save(services, purpose, path),
        Some(Answer::Import(path, settings)) => services.files.import(path, *settings, None),
        Some(Answer::Device(preset)) => choose_preset(&mut services.state.setup, &preset),
        Some(Answer::Trial(path, trial)) => services.files.preview_trial(path, trial),
        Some(Answer::Browse(None)) => services.files.open_dialog(),
        Some(Answer::Browse(Some(purpose))) => services.files.save_dialog(purpose),
    }
}

#[cfg(test)]
mod tests {
    use super::super::run::*;
    use crate::app::files::open::Files;
    use crate::model::preset::Preset;
    use eframe::egui::Modifiers;

    fn press(key: Key, modifiers: Modifiers) -> InputState {
        let mut input = InputState::default();
        input.events.push(Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers,
        });
        input
    }

    #[test]
    fn a_recorded_voltage_drives_a_device_that_has_a_drive() {
        let state = State::new(built_in::setup(), View::default());
        let mut services = Services::new(state, Files::new(|| {}));
        let possible = |services: &Services| is_possible(services, Command::UseRecordedDrive);
        assert!(possible(&services));
        services.state.setup.preset = Preset::embedded("oscillator").unwrap();
        assert!(!possible(&services), "the device has no drive");
        services.state.setup = built_in::setup();
        let overlay = &mut services.state.setup.overlays[0];
        Arc::make_mut(&mut overlay.recording).voltage = None;
        assert!(!possible(&services), "no voltage was recorded");
    }

    #[test]
    fn each_press_asks_for_one_command_and_no_other() {
        let with_shift = Modifiers::COMMAND | Modifiers::SHIFT;
        let cases = [
            (Key::Z, Modifiers::COMMAND, Some(Command::Undo)),
            (Key::Z, with_shift, Some(Command::Redo)),
            (Key::Y, Modifiers::COMMAND, Some(Command::Redo)),
            (Key::Z, Modifiers::NONE, None),
            (Key::Questionmark, Modifiers::SHIFT, Some(Command::Help)),
            (Key::Slash, Modifiers::NONE, Some(Command::FindSlider)),
            (Key::Slash, Modifiers::SHIFT, Some(Command::FindSlider)),
            (Key::G, Modifiers::NONE, Some(Command::KeepCurve)),
            (Key::G, Modifiers::SHIFT, None),
            (Key::O, Modifiers::COMMAND, Some(Command::Open)),
            (Key::O, with_shift, Some(Command::OpenPath)),
        ];
        for (key, modifiers, expected) in cases {
            let mut input = press(key, modifiers);
            let asked: Vec<Command> = Command::all()
                .into_iter()
                .filter(|c| c.shortcuts().any(|s| pressed(&mut input, &s)))
                .collect();
            assert_eq!(asked, Vec::from_iter(expected), "{key:?} {modifiers:?}");
        }
    }
}
