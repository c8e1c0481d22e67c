//! Results that come back from a session's file.

use std::sync::Arc;

use super::content::value;
use super::lines::{self, Extent, Line};
use super::panels::{DiagnoseView, FitPanel};
use super::part::Part;
use super::scenes;
use super::scenes::StoredScene;
use super::trial::{StoredSetup, TrialPanel};
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::analysis::fit::{Asked, Finished};
use crate::app::analysis::identification::{Identification, Stored};
use crate::app::state::State;
use crate::diagnose::Diagnosis;
use crate::diagnose::report::words::listed;
use crate::fit::FitResult;
use crate::fit::paper_steps::guide::Step;
use crate::fit::paper_steps::outcome::StepResult;
use crate::learn::pupil::Pupil;

/// The parts of a file that could be read, and what could not.
struct Parts<'a> {
    lines: Vec<Line<'a>>,
    lost: Vec<&'static str>,
    is_damaged: bool,
}

impl Parts<'_> {
    /// What `read` makes of a part; `None` if the file has none of it. A part that cannot be
    /// read is noted.
    fn take<T>(&mut self, part: Part, read: impl FnOnce(&[u8]) -> Option<T>) -> Option<T> {
        let line = self.lines.iter().find(|line| line.id == part.id())?;
        let found = line.bytes.as_deref().and_then(read);
        self.is_damaged |= line.bytes.is_none();
        if found.is_none() && !self.lost.contains(&part.text()) {
            self.lost.push(part.text());
        }
        found
    }

    /// What could not be read, in a sentence.
    fn sentence(&self) -> Option<String> {
        let reason = if self.is_damaged {
            "the file is damaged there"
        } else {
            "another version of the program wrote it"
        };
        (!self.lost.is_empty()).then(|| {
            format!(
                "Of the results in this session, {} cannot be read: {reason}. The setup and all other results are there; compute it again",
                listed(&self.lost)
            )
        })
    }
}

/// Gives a state that has the session's setup the results in the session's file. Returns what
/// could not be read, in a sentence.
pub(crate) fn restore(state: &mut State, text: &str) -> Option<String> {
    let (lines, extent) = lines::read(text);
    let mut parts = Parts {
        lost: Vec::new(),
        is_damaged: extent == Extent::Cut,
        lines,
    };
    match extent {
        Extent::Whole => {}
        Extent::Cut => parts.lost.push("those at the end of the file"),
        Extent::OtherVersion => parts.lost.push("all"),
    }
    if parts.lines.iter().any(|line| Part::find(line.id).is_none()) {
        parts.lost.push("those that this version does not have");
    }
    if let Some((result, asked)) = parts.take(Part::Fit, fit) {
        let (result, asked) = (Arc::new(result), Arc::new(asked));
        state.fitting.adopt(Finished { result, asked });
    }
    if let Some(panel) = parts.take(Part::FitPanel, value::<FitPanel>) {
        panel.restore(&mut state.fitting);
    }
    let found: Vec<(Step, StepResult)> = Step::ALL
        .into_iter()
        .filter_map(|step| Some((step, parts.take(Part::Found(step), |b| result_of(step, b))?)))
        .collect();
    // Without the guide it is not known what device the steps belong to.
    if let Some(stored) = parts.take(Part::Guide, value::<Stored>) {
        state.identification = Identification::restored(stored, found);
    }
    state.diagnosing.automatic = parts.take(Part::Answer, answer);
    state.diagnosing.by_hand = parts.take(Part::AnswerByHand, answer);
    if let Some(view) = parts.take(Part::DiagnoseView, value::<DiagnoseView>) {
        view.restore(&mut state.diagnosing);
    }
    let trial = &mut state.diagnosing.trial;
    let suspended = parts
        .take(Part::Trial, value::<TrialPanel>)
        .and_then(|panel| panel.restore(trial));
    if let Some(mut suspended) = suspended {
        let setup = |bytes: &[u8]| value::<StoredSetup>(bytes)?.read();
        suspended.setup = parts.take(Part::TrialSetup, setup);
        suspended.automatic = parts.take(Part::TrialAnswer, answer);
        suspended.by_hand = parts.take(Part::TrialAnswerByHand, answer);
        trial.suspended = Some(Box::new(suspended));
    }
    if let Some(pupil) = parts.take(Part::Lessons, value::<Pupil>) {
        state.learning.pupil = pupil;
    }
    if let Some(stored) = parts.take(Part::Scenes, value::<Vec<StoredScene>>) {
        state.scenes = scenes::read(stored);
    }
    state.diagnosing.complete(&state.setup);
    parts.sentence()
}

/// A fit, if its numbers belong together.
fn fit(bytes: &[u8]) -> Option<(FitResult, Asked)> {
    let (result, asked): (FitResult, Asked) = value(bytes)?;
    let is_sound = is_sound_fit(&result) && asked.start.check().is_ok();
    is_sound.then_some((result, asked))
}

fn is_sound_fit(result: &FitResult) -> bool {
    let count = result.parameters.len();
    let square = (count, count);
    result.model.check().is_ok()
        && result.correlations.shape() == square
        && result.fisher_vectors.shape() == square
        && result.fisher_values.len() == count
}

/// The result of a step, if its numbers belong together.
fn result_of(step: Step, bytes: &[u8]) -> Option<StepResult> {
    let found: StepResult = value(bytes)?;
    let is_sound = match (step, &found) {
        (Step::Modal, StepResult::Modal(_))
        | (Step::Drive, StepResult::Drive(_))
        | (Step::Restitution, StepResult::Restitution(_))
        | (Step::Adhesion, StepResult::Adhesion(_)) => true,
        (Step::Film, StepResult::Film(film)) => is_sound_fit(&film.fit),
        (Step::Sensitivity, StepResult::Sensitivity(found)) => {
            is_sound_fit(&found.original) && is_sound_fit(&found.altered)
        }
        _ => false,
    };
    is_sound.then_some(found)
}

/// An answer, if its curves are whole.
fn answer(bytes: &[u8]) -> Option<Arc<Answer>> {
    let answer: Answer = value(bytes)?;
    is_sound_diagnosis(&answer.diagnosis).then(|| Arc::new(answer))
}

fn is_sound_diagnosis(d: &Diagnosis) -> bool {
    let same = |count: usize, others: &[usize]| others.iter().all(|other| *other == count);
    let strips = d.strips.iter().all(|s| {
        let others = [s.before.len(), s.after.len(), s.xp.len(), s.regime.len()];
        same(s.time.len(), &others)
    });
    let marginals =
        (d.marginals.iter()).all(|m| same(m.at.len(), &[m.before.len(), m.after.len()]));
    let balance = d
        .balance
        .iter()
        .flat_map(|b| b.before.iter().chain(&b.after));
    let forces = d.forces.iter().chain(balance.map(|c| &c.curve)).all(|f| {
        let count = f.at.len();
        same(count, &[f.force.len(), f.std_error.len()])
            && (f.law.is_empty() || f.law.len() == count)
    });
    let models = [&d.baseline, &d.model];
    strips && marginals && forces && models.iter().all(|model| model.check().is_ok())
}
