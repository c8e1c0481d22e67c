//! The commands of the Diagnose workspace, and the results of its threads.

use eframe::egui::Context;

use crate::app::flows::{load_example, sealed_trial};
use crate::app::services::Services;
use crate::app::setup::command::Command;
use crate::app::setup::overlay::OverlayId;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::state::State;

/// Runs a command of the Diagnose workspace and shows that workspace, where the outcome
/// is seen.
pub fn run(services: &mut Services, context: &Context, command: Command) {
    let state = &mut services.state;
    if command != Command::AcceptDiagnosis {
        state.view.workspace = WorkspaceId::Diagnose.name().to_owned();
    }
    match command {
        Command::Diagnose => state.diagnosing.start(&state.setup, None, context),
        Command::DiagnoseByHand => {
            let picked = state.diagnosing.picked();
            state.diagnosing.start(&state.setup, Some(picked), context);
        }
        Command::CancelDiagnosis => {
            if let Some(running) = &state.diagnosing.running {
                running.job.cancel();
            }
        }
        Command::AcceptDiagnosis => accept(services),
        Command::Example => {
            if let Err(error) = load_example::load(state, &mut services.last_overlay_id) {
                services.fail(format!("The example recordings cannot be read: {error}"));
            }
        }
        Command::SealedTrial => {
            let trial = &mut state.diagnosing.trial;
            trial.open = !trial.open || trial.sealed.is_some();
        }
        _ => {}
    }
}

/// Takes the diagnosed values and effects over into the device.
fn accept(services: &mut Services) {
    let state = &mut services.state;
    let Some(answer) = state.diagnosing.shown() else {
        return;
    };
    state.setup.preset.model = answer.diagnosis.model.clone();
    let text = "The device now has the diagnosed values and effects; this can be undone";
    services.notice(false, Command::Undo.with_keys(text));
}

/// Takes the results of diagnoses and sealed trials. `last` is the highest recording number
/// given out. Returns whether a diagnosis has just ended.
pub fn poll(state: &mut State, last: &mut OverlayId) -> bool {
    sealed_trial::poll(state, last);
    state.diagnosing.take()
}
