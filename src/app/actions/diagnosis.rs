//! What the commands of the Diagnose workspace do.

use eframe::egui::Context;

use crate::app::flows::{load_example, sealed_trial};
use crate::app::setup::command::Command;
use crate::app::setup::overlay::OverlayId;
use crate::app::shell::window::Shell;
use crate::app::state::State;

/// Runs one of them, and shows the workspace where its outcome is seen.
pub fn run(shell: &mut Shell, context: &Context, command: Command) {
    let state = &mut shell.state;
    if command != Command::AcceptDiagnosis {
        state.view.workspace = crate::app::workspaces::diagnose::NAME.to_owned();
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
        Command::AcceptDiagnosis => accept(shell),
        Command::Example => {
            if let Err(error) = load_example::load(state, &mut shell.next_overlay) {
                shell.fail(format!("The example cannot be read: {error}"));
            }
        }
        Command::SealedTrial => {
            let trial = &mut state.diagnosing.trial;
            trial.open = !trial.open || trial.sealed.is_some();
        }
        _ => {}
    }
}

/// Gives the device what was found.
fn accept(shell: &mut Shell) {
    let state = &mut shell.state;
    let Some(answer) = state.diagnosing.shown() else {
        return;
    };
    state.setup.preset.model = answer.diagnosis.model.clone();
    shell.notice(
        false,
        "The device has the diagnosed values and effects now; Ctrl+Z takes them back",
    );
}

/// Takes what the threads beside the window have brought. `last` is the number of the
/// last recording. Returns whether a diagnosis has just ended.
pub fn poll(state: &mut State, last: &mut OverlayId) -> bool {
    sealed_trial::poll(state, last);
    state.diagnosing.take()
}
