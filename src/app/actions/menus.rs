//! The menu bar, made of the commands.

use eframe::egui::{Button, Ui};

use super::run::is_possible;
use crate::app::files::recent;
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::view::Picture;
use crate::app::shell::window::Shell;
use crate::app::workspaces;
use crate::model::preset::{EMBEDDED, Preset};

/// The menus, all made of commands.
pub fn menus(shell: &mut Shell, ui: &mut Ui) {
    use crate::app::setup::command::Command as C;
    ui.menu_button("File", |ui| {
        items(shell, ui, &[C::Open, C::OpenPath]);
        ui.menu_button("Open recent", |ui| {
            let recent = recent::recent();
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
                    crate::app::setup::setup::choose_preset(&mut shell.state.setup, &preset);
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
            &[
                C::DriveEditor,
                C::LoadDrive,
                C::ResetParameters,
                C::ResetAll,
            ],
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
        items(shell, ui, &workspaces::NAMES.map(C::Workspace));
        ui.separator();
        items(shell, ui, &Picture::ALL.map(C::TogglePicture));
        ui.separator();
        items(
            shell,
            ui,
            &[C::ZoomAll, C::ToggleGhost, C::SidePanel, C::ToggleTheme],
        );
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
                C::FitPanel,
                C::Identification,
                C::Validation,
            ],
        );
    });
    ui.menu_button("Diagnosis", |ui| {
        items(
            shell,
            ui,
            &[C::Diagnose, C::DiagnoseByHand, C::CancelDiagnosis],
        );
        ui.separator();
        items(
            shell,
            ui,
            &[
                C::AcceptDiagnosis,
                C::SaveDiagnosed,
                C::ExportReport,
                C::ExportDiagnosis,
            ],
        );
        ui.separator();
        items(shell, ui, &[C::Example, C::SealedTrial]);
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
            Command::Workspace(name) => shell.state.view.workspace == name,
            _ => false,
        };
        let mut button = Button::selectable(mark, name);
        if let Some(keys) = command.keys() {
            button = button.shortcut_text(keys);
        }
        let entry = ui.add_enabled(is_possible(shell, command), button);
        if entry.on_hover_text(line).clicked() {
            shell.state.ask(command);
        }
    }
}
