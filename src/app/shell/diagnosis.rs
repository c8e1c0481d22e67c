//! Announces a finished diagnosis to a person who looks at another workspace.

use crate::app::actions::diagnosis::poll;
use crate::app::services::Services;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::diagnose::report::verdict_sentence;

/// Takes the results of diagnoses and sealed trials, and announces a finished diagnosis.
pub(super) fn update(services: &mut Services) {
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
