//! What a session keeps of results: the last fit with its profile, the identification, the
//! diagnoses with what is shown of them, and the sealed trial without its truth.
//!
//! Each part is a line of its own behind the setup in the session's file, so that a damaged one
//! costs neither the setup nor the others. Large results never change: their lines are written
//! once, however often the session is saved.

mod content;
mod lines;
mod panels;
mod part;
mod restore;
mod scenes;
#[cfg(test)]
mod tests;
mod thin;
mod trial;

use std::sync::{Arc, Mutex, PoisonError};

use self::content::Content;
use self::panels::{DiagnoseView, FitPanel};
use self::part::Part;
pub(crate) use self::restore::restore;
use self::trial::{StoredSetup, TrialPanel};
use super::flows::sealed_trial::suspended;
use super::setup::current_setup::Setup;
use super::state::State;
use crate::fit::paper_steps::guide::Step;

/// The results of a state. Cheap to make and to compare, so that each frame can.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kept {
    parts: Vec<(Part, Content)>,
    /// The setup of a sealed trial.
    trial_setup: Option<Setup>,
}

/// Lines of large results that were written already.
#[derive(Debug, Default)]
pub(crate) struct Memo(Mutex<Vec<(Content, Arc<str>)>>);

impl Kept {
    /// The results of a state. A job that runs is none; what was finished before it is.
    pub(crate) fn of(state: &State) -> Self {
        let mut kept = Self {
            parts: Vec::new(),
            trial_setup: None,
        };
        let (fitting, diagnosing) = (&state.fitting, &state.diagnosing);
        kept.push(Part::Fit, fitting.finished().map(Content::Fit));
        kept.push_small(Part::FitPanel, &FitPanel::of(fitting));
        kept.push_small(Part::Guide, &state.identification.stored());
        for (id, found) in &state.identification.findings {
            if let (Some(step), Ok(found)) = (Step::find(id), found) {
                kept.push(Part::Found(step), Some(Content::Step(found.clone())));
            }
        }
        let (own, own_by_hand) = match &diagnosing.trial.sealed {
            Some(sealed) => (&sealed.own.automatic, &sealed.own.by_hand),
            None => (&diagnosing.automatic, &diagnosing.by_hand),
        };
        let answer = |answer: &Option<_>| answer.clone().map(Content::Answer);
        kept.push(Part::Answer, answer(own));
        kept.push(Part::AnswerByHand, answer(own_by_hand));
        kept.push_small(Part::DiagnoseView, &DiagnoseView::of(diagnosing));
        let suspended = suspended(state);
        let panel = TrialPanel::of(&diagnosing.trial, suspended.as_ref());
        kept.push_small(Part::Trial, &panel);
        if let Some(suspended) = suspended {
            kept.push(Part::TrialAnswer, answer(&suspended.automatic));
            kept.push(Part::TrialAnswerByHand, answer(&suspended.by_hand));
            kept.trial_setup = suspended.setup;
        }
        if !state.learning.pupil.is_new() {
            kept.push_small(Part::Lessons, &state.learning.pupil);
        }
        if !state.scenes.is_empty() {
            kept.push_small(Part::Scenes, &scenes::stored(&state.scenes));
        }
        kept
    }

    fn push(&mut self, part: Part, content: Option<Content>) {
        self.parts.extend(content.map(|content| (part, content)));
    }

    fn push_small(&mut self, part: Part, value: &impl serde::Serialize) {
        self.push(part, content::bytes(value).map(Content::Small));
    }

    /// The lines of a session's file.
    pub(crate) fn text(&self, memo: &Memo) -> String {
        let mut known = memo.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut large: Vec<(Content, Arc<str>)> = Vec::new();
        let mut text = Vec::new();
        for (part, content) in &self.parts {
            if let Content::Small(bytes) = content {
                text.push(lines::line(part.id(), bytes));
                continue;
            }
            let before = known.iter().find(|(written, _)| written == content);
            let data = before.map(|(_, data)| Arc::clone(data)).or_else(|| {
                let bytes = content.bytes()?;
                Some(Arc::from(lines::data(&bytes)))
            });
            if let Some(data) = data {
                text.push(lines::with_id(part.id(), &data));
                large.push((content.clone(), data));
            }
        }
        *known = large;
        let setup = self.trial_setup.as_ref().map(StoredSetup::of);
        if let Some(bytes) = setup.as_ref().and_then(content::bytes) {
            text.push(lines::line(Part::TrialSetup.id(), &bytes));
        }
        lines::joined(&text)
    }
}
