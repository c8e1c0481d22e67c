//! The commands of the Explore workspace.

use std::path::Path;

use crate::app::analysis::explore::drawing::from_drive;
use crate::app::analysis::explore::source::drive_of;
use crate::app::dialogs::Target;
use crate::app::export::map_csv;
use crate::app::files::atomic_write::write_atomically;
use crate::app::files::event::Purpose;
use crate::app::flows::open_case;
use crate::app::services::Services;
use crate::app::setup::command::Command;
use crate::app::setup::explore::{DriveSource, ExplorePanel};
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::state::State;
use crate::app::workspaces::explore::gait_of;
use crate::explore::gait::contacts_csv;
use crate::explore::waveform::export::export_file;
use crate::explore::waveform::{EditableWaveform, save};

/// Runs a command of the workspace.
pub fn run(services: &mut Services, command: Command) {
    let state = &mut services.state;
    match command {
        Command::Explore(panel) => show(state, panel),
        Command::UseDrawnDrive => match state.setup.explore.drawn.waveform() {
            Ok(drive) => {
                open_case::open(state, None, drive);
                services.notice(
                    false,
                    Command::Undo
                        .with_keys("The drawn waveform is the drive now; this can be undone"),
                );
            }
            Err(error) => services.fail(format!("The drawn waveform is no drive: {error}")),
        },
        Command::DrawTuneDrive => {
            show(state, ExplorePanel::Waveform);
            let drawn = drive_of(&state.setup, DriveSource::Tune).and_then(|drive| {
                from_drive(&drive, &state.setup.explore.drawn).map_err(|error| error.to_string())
            });
            match drawn {
                Ok(drawn) => take_drawn(state, drawn),
                Err(error) => services.fail(format!("The drive cannot be drawn: {error}")),
            }
        }
        Command::LoadWaveform => services.dialogs.ask_file(Target::Waveform),
        Command::SaveWaveform => services.dialogs.ask_path(Some(Purpose::Waveform)),
        Command::ExportWaveform => {
            let format = state.exploring.drawing.format;
            services.dialogs.ask_path(Some(Purpose::Generator(format)));
        }
        Command::ExportMap => services.dialogs.ask_path(Some(Purpose::Map)),
        Command::ExportGait => services.dialogs.ask_path(Some(Purpose::GaitContacts)),
        _ => {}
    }
}

/// Shows a panel of the workspace.
fn show(state: &mut State, panel: ExplorePanel) {
    state.view.workspace = WorkspaceId::Explore.name().to_owned();
    state.view.explore_panel = panel;
}

/// Puts a waveform in the place of the drawn one.
pub fn take_drawn(state: &mut State, drawn: EditableWaveform) {
    state.setup.explore.drawn = drawn;
    state.exploring.drawing.selected = None;
    state.exploring.drawing.refusal = None;
}

/// Takes a waveform that was read from a file.
pub fn opened(services: &mut Services, drawn: EditableWaveform) {
    show(&mut services.state, ExplorePanel::Waveform);
    take_drawn(&mut services.state, drawn);
}

/// Writes a file of the workspace.
///
/// # Errors
/// What cannot be written, and why.
pub fn write(state: &State, purpose: Purpose, path: &Path) -> Result<(), String> {
    let drawn = &state.setup.explore.drawn;
    match purpose {
        Purpose::Waveform => save(path, drawn).map_err(|error| error.to_string()),
        Purpose::Generator(format) => {
            let drive = drawn.waveform().map_err(|error| error.to_string())?;
            let samples = state.exploring.drawing.samples;
            export_file(path, &drive, format, samples).map_err(|error| error.to_string())
        }
        Purpose::GaitContacts => {
            let text = contacts_csv(&gait_of(state)?);
            write_atomically(path, text.as_bytes()).map_err(|error| error.to_string())
        }
        Purpose::Map => {
            let run = &state.exploring.map.run;
            let (Some(request), Some(growing)) = (run.asked(), run.growing()) else {
                return Err("there is no map yet; open the Map panel".to_owned());
            };
            let text = map_csv::text(request, &growing.lock().answer);
            write_atomically(path, text.as_bytes()).map_err(|error| error.to_string())
        }
        _ => Err("this is written elsewhere".to_owned()),
    }
}
