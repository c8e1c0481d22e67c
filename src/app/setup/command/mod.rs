//! The list of commands. Menus, keys, the palette and the help are made from it.

mod keys;
mod text;

use crate::app::setup::drive_choice::Mode;
use crate::app::setup::explore::ExplorePanel;
use crate::app::setup::view::Picture;
use crate::app::setup::workspace_id::WorkspaceId;

/// What a person can do in the lessons.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LearnCommand {
    /// The next step.
    Next,
    /// The step before.
    Back,
    /// Commits the prediction and plays the run.
    Predict,
    /// Begins the lesson again.
    Reset,
    /// The next lesson of the list.
    NextLesson,
    /// The one before.
    PreviousLesson,
    /// Opens a teacher's lesson.
    OpenLesson,
    /// Writes all answers.
    ExportAnswers,
}

impl LearnCommand {
    /// All, in the order of the menu.
    pub const ALL: [LearnCommand; 8] = [
        LearnCommand::Next,
        LearnCommand::Back,
        LearnCommand::Predict,
        LearnCommand::Reset,
        LearnCommand::NextLesson,
        LearnCommand::PreviousLesson,
        LearnCommand::OpenLesson,
        LearnCommand::ExportAnswers,
    ];
}

/// Everything a person can do apart from setting a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Opens a recording, preset or session through the file dialog.
    Open,
    /// Opens a file by a typed path.
    OpenPath,
    /// Describes a device of one's own.
    NewDevice,
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
    /// Runs shown whole instead of played.
    LessMotion,
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
    /// In the lessons.
    Learn(LearnCommand),
    /// Fills the screen with the device, or gives it back.
    Present,
    /// Writes a film of what moves.
    ExportFilm,
}

impl Command {
    /// All commands, in the order of the menus.
    pub fn all() -> Vec<Command> {
        let mut all = vec![
            Command::Open,
            Command::OpenPath,
            Command::NewDevice,
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
            Command::LessMotion,
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
            Command::Present,
            Command::ExportFilm,
        ]);
        all.extend(LearnCommand::ALL.map(Command::Learn));
        all.extend(ExplorePanel::ALL.map(Command::Explore));
        all.extend(WorkspaceId::ALL.map(Command::Workspace));
        all.extend(Picture::ALL.map(Command::TogglePicture));
        all
    }
}
