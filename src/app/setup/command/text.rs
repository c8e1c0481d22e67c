//! What commands are called, and a line of help for each.

use super::{Command, LearnCommand};
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::view::Picture;

impl Command {
    /// Name in menus and palette, and one line of help.
    pub fn text(self) -> (&'static str, &'static str) {
        match self {
            Command::Open => ("Open...", "Open a recording, a preset or a session"),
            Command::OpenPath => ("Open path...", "Open a file by typing its path"),
            Command::NewDevice => (
                "New device...",
                "Describe a device by its geometry, or as a mass on a spring, a pendulum or a free mass",
            ),
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
            Command::LessMotion => (
                "Less motion",
                "Lessons and presenter show a run whole instead of playing it, and nothing glides or zooms",
            ),
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
            Command::Learn(LearnCommand::Next) => ("Next step", "Go on with the lesson"),
            Command::Learn(LearnCommand::Back) => ("Back", "The step before"),
            Command::Learn(LearnCommand::Predict) => {
                ("Predict", "Commit the prediction and play the run (Enter)")
            }
            Command::Learn(LearnCommand::Reset) => (
                "Start the lesson again",
                "Forget the answers to this lesson and begin it again",
            ),
            Command::Learn(LearnCommand::NextLesson) => {
                ("Next lesson", "Open the next lesson of the list")
            }
            Command::Learn(LearnCommand::PreviousLesson) => {
                ("Previous lesson", "Open the lesson before in the list")
            }
            Command::Learn(LearnCommand::OpenLesson) => (
                "Open a lesson...",
                "Open a lesson of your own; docs/lessons.md says how to write one",
            ),
            Command::Learn(LearnCommand::ExportAnswers) => (
                "Export answers...",
                "Write all answers with their scores as CSV; no names are in it",
            ),
            Command::Present => (
                "Present",
                "Fill the screen with the moving device, for a lecture; H lists its keys",
            ),
            Command::ExportFilm => (
                "Export film...",
                "Write what moves as GIF, or as PNG pictures; in Tune from cursor 1 to cursor 2",
            ),
            Command::Quit => ("Quit", "Quit the program; the session is saved"),
        }
    }
}
