//! What diagnoses and sealed trials bring, wherever the person looks meanwhile.

use super::window::Shell;
use crate::diagnose::report::verdict_sentence;

impl Shell {
    /// Takes what diagnoses and trials have brought; says so to whoever looks elsewhere.
    pub(super) fn take_diagnosis(&mut self) {
        let ended = crate::app::actions::diagnosis::poll(&mut self.state, &mut self.next_overlay);
        if !ended || self.state.view.workspace == crate::app::workspaces::diagnose::NAME {
            return;
        }
        let diagnosing = &self.state.diagnosing;
        match (&diagnosing.error, diagnosing.shown()) {
            (Some(error), _) => self.notice(true, format!("No diagnosis: {error}")),
            (None, Some(answer)) => {
                let text = verdict_sentence(&answer.diagnosis);
                self.notice(false, format!("The diagnosis is done. {text}"));
            }
            (None, None) => {}
        }
    }
}
