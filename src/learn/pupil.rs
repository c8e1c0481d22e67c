//! What a pupil has done: where each lesson stands, what was predicted, and how near it came. No
//! names are asked or kept.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::lesson::{Lesson, Step, Task};
use super::prediction::{Prediction, Scored};

/// Most answers that are kept of one lesson: of a file that was changed, old ones go.
const MAX_ANSWERS: usize = 200;

/// All lessons of a pupil.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Pupil {
    lessons: BTreeMap<String, Progress>,
}

/// How far a lesson is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Progress {
    /// The step that is open, from 0.
    pub step: usize,
    /// The furthest step that was reached, from 0.
    pub reached: usize,
    /// Whether the last step was left.
    pub is_done: bool,
    /// Answers by step, from 0.
    pub answers: BTreeMap<usize, Answer>,
}

/// What was answered in a step. The first prediction counts; later tries are counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The first prediction, if the step asks for one.
    pub prediction: Option<Prediction>,
    /// How near it came.
    pub scored: Scored,
    /// How often it was tried.
    pub tries: usize,
}

impl Pupil {
    /// How far a lesson is; at its beginning if nothing is known.
    pub fn progress(&self, id: &str) -> Progress {
        self.lessons.get(id).cloned().unwrap_or_default()
    }

    /// Whether nothing was done yet.
    pub fn is_new(&self) -> bool {
        self.lessons.is_empty()
    }

    /// Opens a step of a lesson.
    pub fn open(&mut self, lesson: &Lesson, step: usize) {
        let last = lesson.steps.len().saturating_sub(1);
        let progress = self.lessons.entry(lesson.id.clone()).or_default();
        progress.step = step.min(last);
        progress.reached = progress.reached.max(progress.step);
    }

    /// The lesson was gone through.
    pub fn finish(&mut self, lesson: &Lesson) {
        self.lessons.entry(lesson.id.clone()).or_default().is_done = true;
    }

    /// Keeps the answer to a step. The first counts, unless a game or a fit came nearer.
    pub fn answer(
        &mut self,
        lesson: &Lesson,
        step: usize,
        prediction: Option<Prediction>,
        scored: Scored,
    ) {
        let progress = self.lessons.entry(lesson.id.clone()).or_default();
        if let Some(known) = progress.answers.get_mut(&step) {
            known.tries += 1;
            if known.prediction.is_none() && scored.score > known.scored.score {
                known.scored = scored;
            }
            return;
        }
        if progress.answers.len() < MAX_ANSWERS {
            let answer = Answer {
                prediction,
                scored,
                tries: 1,
            };
            progress.answers.insert(step, answer);
        }
    }

    /// Forgets what was done in a lesson.
    pub fn reset(&mut self, id: &str) {
        self.lessons.remove(id);
    }

    /// Stars earned in a lesson, and those that its tasks offer.
    pub fn stars(&self, lesson: &Lesson) -> (usize, usize) {
        let progress = self.progress(&lesson.id);
        let earned = progress.answers.values().map(|a| a.scored.stars()).sum();
        let offered = lesson.steps.iter().filter(|s| is_scored(s)).count();
        (earned, 3 * offered)
    }

    /// All answers as a table, one row each, in the order of `lessons`. Nothing in it says whose
    /// they are.
    ///
    /// # Errors
    /// The writer's, which a text in memory does not give.
    pub fn csv(&self, lessons: &[&Lesson]) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record([
            "lesson",
            "step",
            "title",
            "task",
            "predicted",
            "simulated",
            "difference",
            "score",
            "tries",
        ])?;
        for lesson in lessons {
            let progress = self.progress(&lesson.id);
            for (step, answer) in &progress.answers {
                let of = lesson.steps.get(*step);
                writer.write_record([
                    lesson.id.as_str(),
                    &(step + 1).to_string(),
                    of.map_or("", |of| of.title.as_str()),
                    of.map_or("", |of| kind(&of.task)),
                    &answer.scored.predicted,
                    &answer.scored.simulated,
                    &answer.scored.difference,
                    &format!("{:.2}", answer.scored.score),
                    &answer.tries.to_string(),
                ])?;
            }
        }
        writer
            .into_inner()
            .map_err(|error| error.into_error().into())
    }
}

fn is_scored(step: &Step) -> bool {
    step.task.is_prediction() || matches!(step.task, Task::Fit(_) | Task::Concealed(_))
}

/// The name of a task in a table.
fn kind(task: &Task) -> &'static str {
    match task {
        Task::Watch => "watch",
        Task::Choice(_) => "choice",
        Task::Mark(_) => "mark",
        Task::Curve(_) => "curve",
        Task::Explore(_) => "explore",
        Task::Fit(_) => "fit",
        Task::Concealed(_) => "concealed effect",
    }
}
