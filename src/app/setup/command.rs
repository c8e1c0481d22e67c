//! One list of commands, from which menus, keys, the palette and the help derive.

use eframe::egui::{Key, KeyboardShortcut, ModifierNames, Modifiers};

use super::drive_choice::Mode;
use super::view::Picture;
use crate::app::workspaces;

/// Everything a person can ask for that is not a value in a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Opens a recording, preset or session through the file dialog.
    Open,
    /// Opens a file by a typed path.
    OpenPath,
    /// Saves the session.
    SaveSession,
    /// Saves the session under a new name.
    SaveSessionAs,
    /// Saves the present device as a preset.
    SavePreset,
    /// Exports the visible plots.
    ExportSvg,
    /// Exports the visible plots.
    ExportPng,
    /// Exports the simulated trace.
    ExportTrace,
    /// Exports the events.
    ExportEvents,
    /// Takes the last change back.
    Undo,
    /// Makes it again.
    Redo,
    /// Back to the preset's values.
    ResetParameters,
    /// Back to the first start.
    ResetAll,
    /// Window or Live.
    SetMode(Mode),
    /// Live: stands still or goes on.
    TogglePause,
    /// Live: one step on while paused.
    Step,
    /// Live: starts again at t = 0.
    Restart,
    /// Keeps the present curve for comparison, or drops it.
    ToggleGhost,
    /// Shows or hides a picture.
    TogglePicture(Picture),
    /// The whole time span.
    ZoomAll,
    /// Dark or light.
    ToggleTheme,
    /// Shows or hides the panel on the right.
    SidePanel,
    /// Shows the keyboard shortcuts.
    Help,
    /// Shows the drive editor.
    DriveEditor,
    /// Reads the drive from a file.
    LoadDrive,
    /// Shows all cases of Table A.1.
    Validation,
    /// Shows the fit panel.
    FitPanel,
    /// Shows the guided identification.
    Identification,
    /// Shifts the selected recording onto the simulation.
    AutoAlign,
    /// The command palette.
    Palette,
    /// Ends the program.
    Quit,
    /// Changes how the selected recording was read.
    ImportSettings,
    /// Takes the selected recording off the list.
    RemoveRecording,
    /// Simulates with the voltage of the selected recording.
    UseRecordedDrive,
    /// Shows the workspace of that name.
    Workspace(&'static str),
    /// Looks for what the model leaves out.
    Diagnose,
    /// Fits and proves the effects ticked by hand.
    DiagnoseByHand,
    /// Ends the diagnosis in work with what it has found.
    CancelDiagnosis,
    /// Gives the device what the diagnosis found.
    AcceptDiagnosis,
    /// Saves the diagnosed device as a preset.
    SaveDiagnosed,
    /// Writes the report of the diagnosis.
    ExportReport,
    /// Writes the answer of the diagnosis for programs.
    ExportDiagnosis,
    /// Loads the example's recordings.
    Example,
    /// Shows or hides the sealed trial.
    SealedTrial,
}

impl Command {
    /// All commands, in the order of the menus.
    pub fn all() -> Vec<Command> {
        let mut all = vec![
            Command::Open,
            Command::OpenPath,
            Command::SaveSession,
            Command::SaveSessionAs,
            Command::SavePreset,
            Command::ExportSvg,
            Command::ExportPng,
            Command::ExportTrace,
            Command::ExportEvents,
            Command::Quit,
            Command::Undo,
            Command::Redo,
            Command::ResetParameters,
            Command::ResetAll,
            Command::SetMode(Mode::Window),
            Command::SetMode(Mode::Live),
            Command::TogglePause,
            Command::Step,
            Command::Restart,
            Command::ToggleGhost,
            Command::ZoomAll,
            Command::DriveEditor,
            Command::LoadDrive,
            Command::Validation,
            Command::FitPanel,
            Command::Identification,
            Command::AutoAlign,
            Command::ToggleTheme,
            Command::SidePanel,
            Command::Palette,
            Command::Help,
            Command::ImportSettings,
            Command::RemoveRecording,
            Command::UseRecordedDrive,
        ];
        all.extend([
            Command::Diagnose,
            Command::DiagnoseByHand,
            Command::CancelDiagnosis,
            Command::AcceptDiagnosis,
            Command::SaveDiagnosed,
            Command::ExportReport,
            Command::ExportDiagnosis,
            Command::Example,
            Command::SealedTrial,
        ]);
        all.extend(workspaces::NAMES.map(Command::Workspace));
        all.extend(Picture::ALL.map(Command::TogglePicture));
        all
    }

    /// Name in menus and palette, and one line of help.
    pub fn text(self) -> (&'static str, &'static str) {
        match self {
            Command::Open => ("Open...", "Open a recording, a preset or a session"),
            Command::OpenPath => ("Open path...", "Open a file by typing its path"),
            Command::SaveSession => (
                "Save session",
                "Save parameters, drive, recordings and view",
            ),
            Command::SaveSessionAs => ("Save session as...", "Save the session under a new name"),
            Command::SavePreset => (
                "Save as preset...",
                "Save the present device as a preset file",
            ),
            Command::ExportSvg => (
                "Export plots as SVG...",
                "Write the visible plots as a vector picture",
            ),
            Command::ExportPng => (
                "Export plots as PNG...",
                "Write the visible plots as a pixel picture",
            ),
            Command::ExportTrace => (
                "Export trace as CSV...",
                "Write the simulated trace; it can be loaded as a recording",
            ),
            Command::ExportEvents => (
                "Export events as CSV...",
                "Write impacts, sticks and releases",
            ),
            Command::Undo => ("Undo", "Take the last change back"),
            Command::Redo => ("Redo", "Make the change again"),
            Command::ResetParameters => ("Reset parameters", "Back to the values of the preset"),
            Command::ResetAll => ("Reset everything", "Back to the first start; can be undone"),
            Command::SetMode(Mode::Window) => (
                "Window mode",
                "Show the whole span for the current parameters at once",
            ),
            Command::SetMode(Mode::Live) => ("Live mode", "Let the device run in slow motion"),
            Command::TogglePause => ("Pause / run", "Live mode: stand still or go on"),
            Command::Step => ("Step", "Live mode: one step on while paused"),
            Command::Restart => ("Restart", "Live mode: start again at t = 0"),
            Command::ToggleGhost => (
                "Keep curve (A/B)",
                "Keep the present curve to compare with, or drop it",
            ),
            Command::ZoomAll => ("Zoom to all", "Show the whole time span"),
            Command::DriveEditor => ("Drive editor", "Edit waveform, frequency, amplitude"),
            Command::FitPanel => ("Fit", "Find parameters from the recordings"),
            Command::Identification => (
                "Identification, step by step",
                "The paper's steps: drive, restitution, adhesion, film, sensitivity",
            ),
            Command::Validation => (
                "Table A.1",
                "All 16 published experiments beside this device",
            ),
            Command::AutoAlign => (
                "Auto-align",
                "Shift the recordings onto the simulation by cross-correlation",
            ),
            Command::ToggleTheme => ("Dark / light", "Change the colours"),
            Command::Palette => ("Command palette", "Find a command by name"),
            Command::Help => (
                "Keyboard shortcuts",
                "List the shortcuts and mouse gestures",
            ),
            Command::TogglePicture(Picture::Voltage) => {
                ("Plot: voltage", "Show or hide the drive voltage")
            }
            Command::TogglePicture(Picture::Trajectory) => {
                ("Plot: trajectory", "Show or hide the trajectories")
            }
            Command::TogglePicture(Picture::Residual) => {
                ("Plot: residual", "Show or hide recording minus simulation")
            }
            Command::TogglePicture(Picture::Forces) => ("Plot: forces", "Show or hide the forces"),
            Command::TogglePicture(Picture::PhasePortrait) => (
                "Plot: phase portrait",
                "Show or hide velocity against displacement",
            ),
            Command::TogglePicture(Picture::DriveLoop) => (
                "Plot: drive loop",
                "Show or hide displacement against voltage",
            ),
            Command::TogglePicture(Picture::Device) => {
                ("Plot: device", "Show or hide the drawn device")
            }
            Command::ImportSettings => (
                "Import settings...",
                "Change how the selected recording is read: columns, units, sign",
            ),
            Command::RemoveRecording => (
                "Remove recording",
                "Take the selected recording off the list",
            ),
            Command::UseRecordedDrive => (
                "Use recorded voltage",
                "Simulate with the voltage of the selected recording",
            ),
            Command::LoadDrive => (
                "Load drive...",
                "Drive with the voltage of a CSV file that has t and V",
            ),
            Command::SidePanel => (
                "Side panel",
                "Show or hide the panel with recordings and readouts",
            ),
            Command::Workspace(name) => workspaces::ALL
                .iter()
                .find(|workspace| workspace.name == name)
                .map_or((name, ""), |workspace| (workspace.title, workspace.help)),
            Command::Diagnose => (
                "Diagnose",
                "Find what the model leaves out, from the recordings",
            ),
            Command::DiagnoseByHand => (
                "Diagnose by hand",
                "Fit and prove exactly the effects that are ticked",
            ),
            Command::CancelDiagnosis => (
                "Cancel the diagnosis",
                "Stop soon and keep what was found so far",
            ),
            Command::AcceptDiagnosis => (
                "Accept into the model",
                "Give the device the diagnosed values and effects; undo takes it back",
            ),
            Command::SaveDiagnosed => (
                "Save diagnosed device as preset...",
                "Save the device with what was left out as a preset file",
            ),
            Command::ExportReport => (
                "Export report...",
                "Write the diagnosis with its figures as one page (HTML)",
            ),
            Command::ExportDiagnosis => (
                "Export diagnosis as JSON...",
                "Write the diagnosis for programs",
            ),
            Command::Example => (
                "Try the example",
                "Load made-up recordings of a device that is not quite the paper's",
            ),
            Command::SealedTrial => (
                "Sealed trial",
                "Let the program conceal an effect, guess it, and see whether it is found",
            ),
            Command::Quit => ("Quit", "End the program; the session is kept"),
        }
    }

    /// All its keys, the usual one first.
    pub fn shortcuts(self) -> impl Iterator<Item = KeyboardShortcut> {
        // What other programs have taught.
        let also =
            (self == Command::Redo).then_some(KeyboardShortcut::new(Modifiers::COMMAND, Key::Y));
        self.shortcut().into_iter().chain(also)
    }

    /// Its keys as people read them, if it has any: `Ctrl+Shift+Z or Ctrl+Y`, `?`.
    pub fn keys(self) -> Option<String> {
        let text = |keys: KeyboardShortcut| {
            let is_mac = cfg!(target_os = "macos");
            let text = keys.format(&ModifierNames::NAMES, is_mac);
            // Signs are known by their looks, not by their names.
            text.replace("Questionmark", "?").replace("Period", ".")
        };
        let all: Vec<String> = self.shortcuts().map(text).collect();
        (!all.is_empty()).then(|| all.join(" or "))
    }

    /// Its usual key, if it has one.
    pub fn shortcut(self) -> Option<KeyboardShortcut> {
        let ctrl = |key| Some(KeyboardShortcut::new(Modifiers::COMMAND, key));
        let ctrl_shift = |key| {
            Some(KeyboardShortcut::new(
                Modifiers::COMMAND | Modifiers::SHIFT,
                key,
            ))
        };
        let plain = |key| Some(KeyboardShortcut::new(Modifiers::NONE, key));
        match self {
            Command::Open => ctrl(Key::O),
            Command::OpenPath => ctrl_shift(Key::O),
            Command::SaveSession => ctrl(Key::S),
            Command::SaveSessionAs => ctrl_shift(Key::S),
            Command::ExportSvg => ctrl(Key::E),
            Command::ExportPng => ctrl_shift(Key::E),
            Command::Undo => ctrl(Key::Z),
            Command::Redo => ctrl_shift(Key::Z),
            Command::Palette => ctrl(Key::K),
            Command::Quit => ctrl(Key::Q),
            Command::SetMode(Mode::Window) => plain(Key::W),
            Command::SetMode(Mode::Live) => plain(Key::L),
            Command::TogglePause => plain(Key::Space),
            Command::Step => plain(Key::Period),
            Command::Restart => plain(Key::R),
            Command::ToggleGhost => plain(Key::G),
            Command::ZoomAll => plain(Key::A),
            Command::DriveEditor => plain(Key::D),
            Command::Validation => plain(Key::T),
            Command::FitPanel => plain(Key::F),
            Command::Identification => plain(Key::I),
            Command::ToggleTheme => plain(Key::N),
            Command::SidePanel => plain(Key::P),
            Command::Help => plain(Key::Questionmark),
            Command::Workspace(name) => {
                let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num4];
                let place = workspaces::NAMES.iter().position(|known| *known == name)?;
                ctrl(*keys.get(place)?)
            }
            Command::TogglePicture(picture) => {
                let number = [
                    Key::Num1,
                    Key::Num2,
                    Key::Num3,
                    Key::Num4,
                    Key::Num5,
                    Key::Num6,
                    Key::Num7,
                ];
                plain(number[picture as usize])
            }
            _ => None,
        }
    }
}
