//! The menu bar, made of the commands.

use eframe::egui::{Button, Ui};

use super::run::is_possible;
use crate::app::files::recent;
use crate::app::services::Services;
use crate::app::setup::command::{Command, LearnCommand};
use crate::app::setup::current_setup::choose_preset;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::explore::ExplorePanel;
use crate::app::setup::view::{Picture, RecordingLayout, ResidualUnit};
use crate::app::setup::workspace_id::WorkspaceId;
use crate::model::preset::{EMBEDDED, Preset};

/// A menu: its title and its entries in groups.
type Menu = (&'static str, &'static [&'static [Command]]);

/// The menus that hold commands alone. "File", "View" and
/// "Help" have entries of their own.
const MENUS: [Menu; 6] = [
    (
        "Edit",
        &[
            &[Command::Undo, Command::Redo],
            &[
                Command::DriveEditor,
                Command::LoadDrive,
                Command::ResetParameters,
                Command::ResetAll,
            ],
        ],
    ),
    (
        "Recording",
        &[&[
            Command::AutoAlign,
            Command::UseRecordedDrive,
            Command::ImportSettings,
            Command::RemoveRecording,
        ]],
    ),
    (
        "Run",
        &[&[
            Command::SetMode(Mode::WholeSpan),
            Command::SetMode(Mode::Live),
            Command::SteadyState,
            Command::TogglePause,
            Command::Step,
            Command::Restart,
            Command::FitPanel,
            Command::Identification,
            Command::Sensitivity,
            Command::Validation,
        ]],
    ),
    (
        "Diagnosis",
        &[
            &[
                Command::Diagnose,
                Command::DiagnoseByHand,
                Command::CancelDiagnosis,
            ],
            &[
                Command::AcceptDiagnosis,
                Command::SaveDiagnosed,
                Command::ExportReport,
                Command::ExportDiagnosis,
            ],
            &[Command::Example, Command::SealedTrial],
        ],
    ),
    (
        "Explore",
        &[
            &[
                Command::Explore(ExplorePanel::Map),
                Command::Explore(ExplorePanel::Orbit),
                Command::Explore(ExplorePanel::Basins),
                Command::Explore(ExplorePanel::Robustness),
                Command::Explore(ExplorePanel::Waveform),
                Command::Explore(ExplorePanel::Gait),
            ],
            &[
                Command::DrawTuneDrive,
                Command::UseDrawnDrive,
                Command::LoadWaveform,
                Command::SaveWaveform,
                Command::ExportWaveform,
                Command::ExportMap,
                Command::ExportGait,
            ],
        ],
    ),
    (
        "Lessons",
        &[
            &[
                Command::Learn(LearnCommand::Next),
                Command::Learn(LearnCommand::Back),
                Command::Learn(LearnCommand::Predict),
                Command::Learn(LearnCommand::Reset),
            ],
            &[
                Command::Learn(LearnCommand::NextLesson),
                Command::Learn(LearnCommand::PreviousLesson),
                Command::Learn(LearnCommand::OpenLesson),
                Command::Learn(LearnCommand::ExportAnswers),
            ],
            &[Command::Present, Command::ExportFilm],
        ],
    ),
];

/// Draws the menus.
pub fn menus(services: &mut Services, ui: &mut Ui) {
    let [edit, recording, run, diagnosis, explore, lessons] = MENUS;
    ui.menu_button("File", |ui| file_menu(services, ui));
    menu(services, ui, edit);
    menu(services, ui, recording);
    ui.menu_button("View", |ui| view_menu(services, ui));
    menu(services, ui, run);
    menu(services, ui, diagnosis);
    menu(services, ui, explore);
    menu(services, ui, lessons);
    ui.menu_button("Help", |ui| {
        items(services, ui, &[Command::Help, Command::Palette]);
        if ui.button("About").clicked() {
            services.dialogs.open_about();
        }
    });
}

fn menu(services: &mut Services, ui: &mut Ui, (title, groups): Menu) {
    ui.menu_button(title, |ui| {
        for (i, commands) in groups.iter().enumerate() {
            if i > 0 {
                ui.separator();
            }
            items(services, ui, commands);
        }
    });
}

fn file_menu(services: &mut Services, ui: &mut Ui) {
    items(
        services,
        ui,
        &[Command::Open, Command::OpenPath, Command::NewDevice],
    );
    ui.menu_button("Open recent", |ui| {
        let recent = recent::recent();
        if recent.is_empty() {
            ui.weak("no recent files");
        }
        for path in recent {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let entry = ui.button(name).on_hover_text(path.to_string_lossy());
            if entry.clicked() {
                services.files.open(path);
            }
        }
    });
    ui.menu_button("Open preset", |ui| {
        for (name, _) in EMBEDDED {
            if ui.button(name).clicked()
                && let Some(preset) = Preset::embedded(name)
            {
                choose_preset(&mut services.state.setup, &preset);
            }
        }
    });
    ui.separator();
    let save = [
        Command::SaveSession,
        Command::SaveSessionAs,
        Command::SavePreset,
    ];
    items(services, ui, &save);
    ui.separator();
    let export = [
        Command::ExportSvg,
        Command::ExportPng,
        Command::ExportTrace,
        Command::ExportEvents,
    ];
    items(services, ui, &export);
    ui.separator();
    items(services, ui, &[Command::Quit]);
}

fn view_menu(services: &mut Services, ui: &mut Ui) {
    items(services, ui, &WorkspaceId::ALL.map(Command::Workspace));
    ui.separator();
    items(services, ui, &Picture::ALL.map(Command::TogglePicture));
    ui.separator();
    let view = [
        Command::ZoomAll,
        Command::ResidualUnit,
        Command::FixResidual,
        Command::SmallMultiples,
        Command::KeepCurve,
        Command::KeptCurves,
        Command::SidePanel,
        Command::FindSlider,
        Command::ToggleTheme,
        Command::LessMotion,
    ];
    items(services, ui, &view);
}

/// Entries for commands; one that would do nothing now is disabled.
fn items(services: &mut Services, ui: &mut Ui, commands: &[Command]) {
    for &command in commands {
        let (name, line) = command.text();
        let is_on = match command {
            Command::TogglePicture(picture) => services.state.view.pictures.contains(&picture),
            Command::ResidualUnit => services.state.view.residual_unit == ResidualUnit::Noise,
            Command::SmallMultiples => {
                services.state.view.recording_layout == RecordingLayout::SmallMultiples
            }
            Command::SetMode(mode) => services.state.view.mode == mode,
            Command::SteadyState => services.state.view.from_steady,
            Command::LessMotion => services.state.view.less_motion,
            Command::Workspace(id) => services.state.view.workspace == id.name(),
            _ => false,
        };
        let mut button = Button::selectable(is_on, name);
        if let Some(keys) = command.keys() {
            button = button.shortcut_text(keys);
        }
        let entry = ui.add_enabled(is_possible(services, command), button);
        if entry.on_hover_text(line).clicked() {
            services.state.ask(command);
        }
    }
}
