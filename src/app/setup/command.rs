//! The list of commands. Menus, keys, the palette and the help are made from it.

use eframe::egui::{Key, KeyboardShortcut, ModifierNames, Modifiers};

use super::drive_choice::Mode;
use super::explore::ExplorePanel;
use super::view::Picture;
use super::workspace_id::WorkspaceId;

/// Everything a person can do apart from setting a value.
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
    /// Exports the visible plots as SVG.
    ExportSvg,
    /// Exports the visible plots as PNG.
    ExportPng,
    /// Exports the simulated trace.
    ExportTrace,
    /// Exports the events.
    ExportEvents,
    /// Undoes the last change.
    Undo,
    /// Redoes it.
    Redo,
    /// Back to the preset's values.
    ResetParameters,
    /// Back to the first start.
    ResetAll,
    /// Whole span or live.
    SetMode(Mode),
    /// The whole span from the steady response on, or from rest.
    SteadyState,
    /// Live: pauses or continues.
    TogglePause,
    /// Live: advances one step while paused.
    Step,
    /// Live: starts again at t = 0.
    Restart,
    /// Keeps the present curve, to compare later ones with.
    KeepCurve,
    /// Shows or hides the table of the kept curves.
    KeptCurves,
    /// Shows or hides a picture.
    TogglePicture(Picture),
    /// The whole time span.
    ZoomAll,
    /// The residual as a length, or in units of the noise.
    ResidualUnit,
    /// Fixes the residual's scale in units of the noise.
    FixResidual,
    /// Several recordings in one picture, or in a panel each.
    SmallMultiples,
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
    /// Shows what each slider changes in the residual.
    Sensitivity,
    /// Shifts the selected recording onto the simulation.
    AutoAlign,
    /// Puts the focus into the field that finds a slider.
    FindSlider,
    /// The command palette.
    Palette,
    /// Ends the program.
    Quit,
    /// Changes how the selected recording was read.
    ImportSettings,
    /// Removes the selected recording.
    RemoveRecording,
    /// Simulates with the voltage of the selected recording.
    UseRecordedDrive,
    /// Shows the workspace of that name.
    Workspace(WorkspaceId),
    /// Searches for effects that the model is missing.
    Diagnose,
    /// Fits the effects ticked by hand and checks them on the held-out recordings.
    DiagnoseByHand,
    /// Stops the running diagnosis and keeps its result so far.
    CancelDiagnosis,
    /// Takes the diagnosed values and effects over into the device.
    AcceptDiagnosis,
    /// Saves the diagnosed device as a preset.
    SaveDiagnosed,
    /// Writes the report of the diagnosis.
    ExportReport,
    /// Writes the diagnosis as JSON.
    ExportDiagnosis,
    /// Loads the example's recordings.
    Example,
    /// Shows or hides the sealed trial.
    SealedTrial,
    /// Shows a panel of the Explore workspace.
    Explore(ExplorePanel),
    /// The drawn waveform becomes the drive.
    UseDrawnDrive,
    /// The drive becomes the drawn waveform.
    DrawTuneDrive,
    /// Reads a drawn waveform from its file.
    LoadWaveform,
    /// Writes the drawn waveform to its file.
    SaveWaveform,
    /// Writes one period of the drawn waveform for a function generator.
    ExportWaveform,
    /// Writes the map.
    ExportMap,
    /// Writes the contacts of the gait.
    ExportGait,
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
            Command::SetMode(Mode::WholeSpan),
            Command::SetMode(Mode::Live),
            Command::SteadyState,
            Command::TogglePause,
            Command::Step,
            Command::Restart,
            Command::KeepCurve,
            Command::KeptCurves,
            Command::ZoomAll,
            Command::ResidualUnit,
            Command::FixResidual,
            Command::SmallMultiples,
            Command::DriveEditor,
            Command::LoadDrive,
            Command::Validation,
            Command::FitPanel,
            Command::Identification,
            Command::Sensitivity,
            Command::AutoAlign,
            Command::ToggleTheme,
            Command::SidePanel,
            Command::FindSlider,
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
            Command::UseDrawnDrive,
            Command::DrawTuneDrive,
            Command::LoadWaveform,
            Command::SaveWaveform,
            Command::ExportWaveform,
            Command::ExportMap,
            Command::ExportGait,
        ]);
        all.extend(ExplorePanel::ALL.map(Command::Explore));
        all.extend(WorkspaceId::ALL.map(Command::Workspace));
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
                "Save parameters, drive, recordings, kept curves, view and results",
            ),
            Command::SaveSessionAs => ("Save session as...", "Save the session under a new name"),
            Command::SavePreset => (
                "Save as preset...",
                "Save the current device as a preset file",
            ),
            Command::ExportSvg => (
                "Export plots as SVG...",
                "Write the visible plots as a vector image",
            ),
            Command::ExportPng => (
                "Export plots as PNG...",
                "Write the visible plots as a PNG image",
            ),
            Command::ExportTrace => (
                "Export trace as CSV...",
                "Write the simulated trace with velocities and forces; it opens as a recording",
            ),
            Command::ExportEvents => (
                "Export events as CSV...",
                "Write all events: impacts, sticks, releases and drive steps",
            ),
            Command::Undo => ("Undo", "Undo the last change"),
            Command::Redo => ("Redo", "Redo the change"),
            Command::ResetParameters => ("Reset parameters", "Return to the values of the preset"),
            Command::ResetAll => (
                "Reset everything",
                "Return to the state of the first start. Undo restores device, drive, recordings and kept curves.",
            ),
            Command::SetMode(Mode::WholeSpan) => (
                "Whole span",
                "Simulate the whole time span and show all of it",
            ),
            Command::SetMode(Mode::Live) => ("Live mode", "Run the device in slow motion"),
            Command::TogglePause => ("Pause / run", "Live mode: pause or continue"),
            Command::Step => ("Step", "Live mode: advance one step while paused"),
            Command::Restart => ("Restart", "Live mode: start again at t = 0"),
            Command::KeepCurve => (
                "Keep the curve",
                "Keep the current curve under a name, to compare later ones with",
            ),
            Command::KeptCurves => (
                "Kept curves",
                "Show or hide the kept curves with their misfits and features",
            ),
            Command::ZoomAll => (
                "Zoom to all",
                "Show the whole time span and all values; fixed scales stay",
            ),
            Command::ResidualUnit => (
                "Residual in units of the noise",
                "Draw each recording's residual divided by its own noise, or as a length",
            ),
            Command::FixResidual => (
                "Fix the residual's scale at \u{b1}5 x noise",
                "The scale then stays as it is while a slider is dragged",
            ),
            Command::SmallMultiples => (
                "Small multiples",
                "Draw one panel for each recording, or all in one picture",
            ),
            Command::Sensitivity => (
                "Sensitivity",
                "Show what each slider changes in the residual, and which one to take",
            ),
            Command::DriveEditor => ("Drive editor", "Edit waveform, frequency and amplitude"),
            Command::FitPanel => ("Fit", "Fit parameters to the recordings"),
            Command::Identification => (
                "Identification, step by step",
                "The paper's steps: drive, restitution, adhesion, film, sensitivity",
            ),
            Command::Validation => (
                "Table A.1",
                "Compare this device with all 16 published experiments",
            ),
            Command::AutoAlign => (
                "Auto-align",
                "Shift the recordings onto the simulation by cross-correlation",
            ),
            Command::ToggleTheme => ("Dark / light", "Switch between dark and light theme"),
            Command::FindSlider => (
                "Find a slider",
                "Type a symbol or a name, Enter; then the arrow keys change the value",
            ),
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
                ("Plot: residual", "Show or hide simulation minus recording")
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
                ("Plot: device", "Show or hide the animated device")
            }
            Command::ImportSettings => (
                "Import settings...",
                "Change how the selected recording is read: columns, units, sign",
            ),
            Command::RemoveRecording => (
                "Remove recording",
                "Remove the selected recording from the list",
            ),
            Command::UseRecordedDrive => (
                "Use recorded voltage",
                "Simulate with the voltage of the selected recording",
            ),
            Command::LoadDrive => (
                "Load drive...",
                "Use the voltage of a CSV file with t and V as the drive",
            ),
            Command::SidePanel => (
                "Side panel",
                "Show or hide the panel with recordings and readouts",
            ),
            Command::Workspace(id) => (id.title(), id.help()),
            Command::Diagnose => (
                "Diagnose",
                "Find the effects that the model is missing, from the recordings",
            ),
            Command::DiagnoseByHand => (
                "Test ticked effects",
                "Fit exactly the ticked effects and check them on the held-out recordings",
            ),
            Command::CancelDiagnosis => (
                "Cancel the diagnosis",
                "Stop and keep the best result so far",
            ),
            Command::AcceptDiagnosis => (
                "Apply to the device",
                "Use the diagnosed values and effects for the device; can be undone",
            ),
            Command::SaveDiagnosed => (
                "Save diagnosed device as preset...",
                "Save the device with the diagnosed effects as a preset file",
            ),
            Command::ExportReport => (
                "Export report...",
                "Write the diagnosis with its figures as one page (HTML)",
            ),
            Command::ExportDiagnosis => (
                "Export diagnosis as JSON...",
                "Write the diagnosis as JSON, for other programs",
            ),
            Command::Example => (
                "Try the example",
                "Load synthetic recordings of a device that differs slightly from the paper's",
            ),
            Command::SealedTrial => (
                "Sealed trial",
                "The program conceals an effect; guess it, and see whether the diagnosis finds it",
            ),
            Command::SteadyState => (
                "Jump to steady state",
                "Show the whole span from the steady response on, without the transient",
            ),
            Command::Explore(panel) => (panel.command_name(), panel.help()),
            Command::UseDrawnDrive => (
                "Use as the drive in Tune",
                "Simulate with the drawn waveform in the Tune workspace",
            ),
            Command::DrawTuneDrive => (
                "Draw the drive of Tune",
                "Take the drive of the Tune workspace as handles; it can be undone",
            ),
            Command::LoadWaveform => (
                "Load waveform...",
                "Open a drawn waveform that was saved before",
            ),
            Command::SaveWaveform => (
                "Save waveform...",
                "Save handles, frequency, offset, bursts, grid and limits to a file",
            ),
            Command::ExportWaveform => (
                "Export one period...",
                "Write one period as the file of a function generator",
            ),
            Command::ExportMap => (
                "Export map as CSV...",
                "Write the points of the map with all measures, one row each",
            ),
            Command::ExportGait => (
                "Export contacts as CSV...",
                "Write when each foot is down over the cycle",
            ),
            Command::Quit => ("Quit", "Quit the program; the session is saved"),
        }
    }

    /// All its keys, the usual one first.
    pub fn shortcuts(self) -> impl Iterator<Item = KeyboardShortcut> {
        // A second key for redo, usual in other programs.
        let also =
            (self == Command::Redo).then_some(KeyboardShortcut::new(Modifiers::COMMAND, Key::Y));
        self.shortcut().into_iter().chain(also)
    }

    /// Its keys as people read them, if it has any: `Ctrl+Shift+Z or Ctrl+Y`, `?`.
    pub fn keys(self) -> Option<String> {
        let text = |keys: KeyboardShortcut| {
            let is_mac = cfg!(target_os = "macos");
            let text = keys.format(&ModifierNames::NAMES, is_mac);
            // Punctuation is shown as the character itself.
            text.replace("Questionmark", "?")
                .replace("Period", ".")
                .replace("Slash", "/")
        };
        let all: Vec<String> = self.shortcuts().map(text).collect();
        (!all.is_empty()).then(|| all.join(" or "))
    }

    /// A text with its keys in brackets, if it has any.
    pub fn with_keys(self, text: &str) -> String {
        match self.keys() {
            Some(keys) => format!("{text} ({keys})"),
            None => text.to_owned(),
        }
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
            Command::SetMode(Mode::WholeSpan) => plain(Key::W),
            Command::SetMode(Mode::Live) => plain(Key::L),
            Command::TogglePause => plain(Key::Space),
            Command::Step => plain(Key::Period),
            Command::Restart => plain(Key::R),
            Command::KeepCurve => plain(Key::G),
            Command::ZoomAll => plain(Key::A),
            Command::DriveEditor => plain(Key::D),
            Command::Validation => plain(Key::T),
            Command::FitPanel => plain(Key::F),
            Command::Identification => plain(Key::I),
            Command::Sensitivity => plain(Key::S),
            Command::ResidualUnit => plain(Key::U),
            Command::SmallMultiples => plain(Key::M),
            Command::ToggleTheme => plain(Key::N),
            Command::SidePanel => plain(Key::P),
            Command::Help => plain(Key::Questionmark),
            Command::FindSlider => plain(Key::Slash),
            Command::Workspace(WorkspaceId::Tune) => ctrl(Key::Num1),
            Command::Workspace(WorkspaceId::Diagnose) => ctrl(Key::Num2),
            Command::Workspace(WorkspaceId::Explore) => ctrl(Key::Num3),
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
