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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::catalogue::lessons;

    fn scored(score: f64, predicted: &str) -> Scored {
        Scored {
            score,
            predicted: predicted.to_owned(),
            simulated: "9 mm".to_owned(),
            difference: String::new(),
        }
    }

    /// Number of the first step that asks for a prediction.
    fn asking(lesson: &Lesson) -> usize {
        let asks = |step: &Step| step.task.is_prediction();
        lesson.steps.iter().position(asks).unwrap()
    }

    #[test]
    fn answers_are_a_table_that_a_spreadsheet_reads() {
        let lessons = lessons();
        let all: Vec<&Lesson> = lessons.iter().collect();
        let lesson = &lessons[3];
        let step = asking(lesson);
        let mut pupil = Pupil::default();
        pupil.answer(lesson, step, None, scored(0.5, "low, \"very\" low"));
        let table = pupil.csv(&all).unwrap();
        let mut reader = csv::Reader::from_reader(table.as_slice());
        let head = reader.headers().unwrap().clone();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let [row] = &rows[..] else {
            panic!("{rows:?}");
        };
        let at = |name: &str| {
            let column = head.iter().position(|known| known == name).unwrap();
            row.get(column).unwrap().to_owned()
        };
        assert_eq!(at("lesson"), lesson.id);
        assert_eq!(at("step"), (step + 1).to_string());
        assert_eq!(at("title"), lesson.steps[step].title);
        assert_eq!(at("predicted"), "low, \"very\" low");
        assert_eq!(
            (at("simulated"), at("score")),
            ("9 mm".into(), "0.50".into())
        );
        assert_eq!(at("tries"), "1");
        let asked_for_names = head.iter().any(|name| name.contains("name"));
        assert!(!asked_for_names);
    }

    #[test]
    fn the_first_prediction_counts_and_the_best_round_of_a_game() {
        let lessons = lessons();
        let lesson = &lessons[0];
        let step = asking(lesson);
        let mut pupil = Pupil::default();
        for (score, option) in [(0.0, 0), (1.0, 1)] {
            let prediction = Some(Prediction::Choice(option));
            pupil.answer(lesson, step, prediction, scored(score, "it"));
        }
        let answer = pupil.progress(&lesson.id).answers[&step].clone();
        assert_eq!((answer.scored.score, answer.tries), (0.0, 2));
        for score in [0.2, 0.9, 0.4] {
            pupil.answer(lesson, step + 1, None, scored(score, "it"));
        }
        let answer = pupil.progress(&lesson.id).answers[&(step + 1)].clone();
        assert_eq!((answer.scored.score, answer.tries), (0.9, 3));
        assert_eq!(pupil.stars(lesson).0, 3);
        pupil.reset(&lesson.id);
        assert!(pupil.is_new() && pupil.stars(lesson).0 == 0);
    }
}
