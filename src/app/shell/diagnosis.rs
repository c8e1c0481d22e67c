//! Announces a finished diagnosis to a person who looks at another workspace.

use eframe::egui::Context;

use crate::app::actions::diagnosis::poll;
use crate::app::services::Services;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::diagnose::report::verdict_sentence;

/// Takes the results of diagnoses and sealed trials, and announces a finished diagnosis.
/// `is_reading` is whether recordings are still being read.
pub(super) fn update(services: &mut Services, is_reading: bool, context: &Context) {
    let state = &mut services.state;
    state.diagnosing.complete(&state.setup);
    // A trial puts its recordings in the place of the person's own, which must be there first:
    // those that are still being read would be added to the trial.
    if is_reading && state.diagnosing.trial.has_begun() {
        return;
    }
    state.diagnosing.trial.resume(context);
    let ended = poll(&mut services.state, &mut services.last_overlay_id);
    if !ended || services.state.view.workspace == WorkspaceId::Diagnose.name() {
        return;
    }
    let diagnosing = &services.state.diagnosing;
    match (&diagnosing.error, diagnosing.shown()) {
        (Some(error), _) => services.notice(true, format!("The diagnosis failed: {error}")),
        (None, Some(answer)) => {
            let text = verdict_sentence(&answer.diagnosis);
            services.notice(false, format!("The diagnosis is finished. {text}"));
        }
        (None, None) => {}
    }
}
