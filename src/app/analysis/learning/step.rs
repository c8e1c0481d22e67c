//! The open step: its scene as it was changed, its run, and the moment that is shown.

use std::sync::Arc;

use eframe::egui::Context;

use super::draft::Draft;
use super::runs::{SceneQuestion, SceneResult, SceneRuns};
use crate::app::analysis::explore::latest::Latest;
use crate::learn::lesson::{Concealed, HandFit, Lesson, Step, Task};
use crate::learn::playback::{Playback, SlowMoments};
use crate::learn::prediction::{Prediction, Scored, score};
use crate::learn::pupil::Answer;
use crate::learn::run::Scene;
use crate::learn::target::{Round, fit_score};
use crate::model::unit::format_number;

/// What the pupil is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Predicts; the run is not shown.
    Predicting,
    /// Watches the run.
    Watching,
    /// Has seen the run to its end.
    Seen,
}

/// An open step.
#[derive(Debug, Clone)]
pub struct OpenStep {
    /// The lesson.
    pub lesson: Arc<Lesson>,
    /// Number of the step, from 0.
    pub index: usize,
    /// Its scene, as the pupil changed it.
    pub scene: Scene,
    /// What is being predicted.
    pub draft: Draft,
    /// The moment shown.
    pub playback: Playback,
    /// What the pupil is doing.
    pub phase: Phase,
    /// How near the prediction came, once it was seen.
    pub scored: Option<Scored>,
    /// The round of the game.
    pub round: Option<Round>,
    /// The guess in the round, once it was made.
    pub guess: Option<usize>,
    /// Rounds of the game that were guessed right, and all that were guessed, by level.
    pub tally: Vec<(usize, usize)>,
    /// Why no run is shown.
    pub problem: Option<String>,
    runs: Latest<SceneRuns>,
    newest: Option<SceneResult>,
    is_known: bool,
}

impl OpenStep {
    /// Opens a step with what was answered before; `None` for one that there is not.
    pub fn new(lesson: Arc<Lesson>, index: usize, answer: Option<&Answer>) -> Option<Self> {
        let step = lesson.steps.get(index)?;
        let before = answer.and_then(|answer| Some((answer.prediction.as_ref()?, answer)));
        let is_prediction = step.task.is_prediction();
        let mut open = Self {
            scene: step.scene.clone(),
            draft: before.map_or_else(
                || Draft::new(&step.task),
                |(prediction, _)| Draft::of(&step.task, prediction),
            ),
            playback: Playback::new(step.speed),
            phase: match (is_prediction, before.is_some()) {
                (true, false) => Phase::Predicting,
                (true, true) => Phase::Seen,
                (false, _) => Phase::Watching,
            },
            scored: before.map(|(_, answer)| answer.scored.clone()),
            round: None,
            guess: None,
            tally: Vec::new(),
            problem: None,
            runs: Latest::default(),
            newest: None,
            is_known: before.is_some(),
            lesson,
            index,
        };
        // What is compared or explored is seen whole; Play shows it in time.
        let has_controls = open
            .step()
            .is_some_and(|step| !step.task.controls().is_empty());
        if open.phase == Phase::Seen || has_controls {
            open.playback.time = open.scene.duration;
        }
        if let Task::Concealed(game) = &open.step()?.task.clone() {
            open.tally = vec![(0, 0); game.levels.len()];
            open.draw(game, 0);
        }
        Some(open)
    }

    /// The step.
    pub fn step(&self) -> Option<&Step> {
        self.lesson.steps.get(self.index)
    }

    /// The run that is shown.
    pub fn result(&self) -> Option<&SceneResult> {
        self.newest.as_ref()
    }

    /// Whether a run is still being computed.
    pub fn is_busy(&self) -> bool {
        self.runs.is_waiting()
    }

    /// Draws a round of a game.
    pub fn draw(&mut self, game: &Concealed, level: usize) {
        self.guess = None;
        self.round = game.draw(level, u64::from(rand::random::<u32>()));
        if let Some(step) = self.lesson.steps.get(self.index) {
            self.scene = step.scene.clone();
        }
        self.playback.is_playing = false;
        self.playback.time = self.scene.duration;
    }

    /// Settles the round of the game with a guess.
    pub fn guess(&mut self, guess: usize) -> Option<Scored> {
        let Some(Step {
            task: Task::Concealed(game),
            ..
        }) = self.lesson.steps.get(self.index)
        else {
            return None;
        };
        let round = self.round.as_ref().filter(|_| self.guess.is_none())?;
        let level = game.level(round)?;
        let is_right = Concealed::is_right(round, guess);
        let opened = game.opened(round)?.name.clone();
        if let Some((right, all)) = self.tally.get_mut(round.level) {
            *right += usize::from(is_right);
            *all += 1;
        }
        self.guess = Some(guess);
        let predicted = level.candidates.get(guess)?.name.clone();
        let levels = game.levels.len().max(1) as f64;
        Some(Scored {
            // A right guess of a higher level is worth more.
            score: f64::from(u8::from(is_right)) * (round.level + 1) as f64 / levels,
            predicted,
            simulated: opened,
            difference: String::new(),
        })
    }

    /// Commits the prediction and plays the run; nothing without a prediction.
    pub fn predict(&mut self) {
        let has_one = self
            .step()
            .is_some_and(|step| self.draft.prediction(&step.task).is_some());
        if self.phase == Phase::Predicting && has_one {
            self.phase = Phase::Watching;
            self.playback.start();
        }
    }

    /// Plays the run from its beginning, if it may be seen.
    pub fn replay(&mut self) {
        if self.phase != Phase::Predicting {
            self.playback.start();
        }
    }

    /// Plays or pauses, if the run may be seen.
    pub fn toggle(&mut self) {
        if self.phase != Phase::Predicting {
            self.playback.toggle(self.scene.duration);
        }
    }

    /// Sets the scene back to that of the step.
    pub fn restore(&mut self) {
        if let Some(step) = self.lesson.steps.get(self.index) {
            self.scene = step.scene.clone();
        }
    }

    /// The misfit of the fit by hand now, in units of the noise.
    pub fn misfit(&self) -> Option<f64> {
        let result = self.newest.as_ref()?;
        Some(result.target.as_ref()?.target.misfit(&result.run))
    }

    /// The fit by hand handed in, with its score.
    pub fn hand_in(&self, fit: &HandFit) -> Option<Scored> {
        let misfit = self.misfit()?;
        let values = |of: &dyn Fn(&str) -> Option<f64>| {
            let all = fit.truth.iter().filter_map(|(id, _)| {
                let unit = self.scene.preset.model.unit_of(id).unwrap_or_default();
                let text = crate::model::unit::format_quantity(of(id)?, unit, 3);
                Some(format!("{id} = {text}"))
            });
            all.collect::<Vec<_>>().join(", ")
        };
        let truth = |id: &str| {
            let found = fit.truth.iter().find(|(known, _)| known == id);
            found.map(|(_, value)| *value)
        };
        Some(Scored {
            score: fit_score(misfit),
            predicted: values(&|id| self.scene.control_value(id)),
            simulated: values(&truth),
            difference: format!("{} x noise", format_number(misfit, 3)),
        })
    }

    /// Asks for the run, takes it, and advances the moment by `wall` \[s\]. Returns the prediction that
    /// was seen to its end just now, with its score.
    pub fn update(&mut self, context: &Context, wall: f64) -> Option<(Option<Prediction>, Scored)> {
        self.ask(context);
        if self.playback.is_playing {
            context.request_repaint();
        }
        let slow = self.newest.as_ref().map(|r| Arc::clone(&r.slow));
        let slow = slow.unwrap_or_else(|| Arc::new(SlowMoments::default()));
        if self.newest.is_some() && self.playback.advance(wall, self.scene.duration, &slow) {
            self.phase = match self.phase {
                Phase::Predicting => Phase::Predicting,
                _ => Phase::Seen,
            };
        }
        self.settle()
    }

    fn ask(&mut self, context: &Context) {
        let question = SceneQuestion {
            scene: self.scene.clone(),
            step: Some((Arc::clone(&self.lesson), self.index)),
            round: self.round.clone(),
        };
        self.runs.ask(question, context);
        if let Some(answered) = self.runs.newest() {
            match &answered.answer {
                Ok(result) => {
                    self.problem = None;
                    self.newest = Some(result.clone());
                }
                Err(error) if !self.runs.is_waiting() => self.problem = Some(error.clone()),
                Err(_) => {}
            }
        }
    }

    /// Scores a prediction that was seen to its end.
    fn settle(&mut self) -> Option<(Option<Prediction>, Scored)> {
        if self.phase != Phase::Seen || self.is_known {
            return None;
        }
        let step = self.lesson.steps.get(self.index)?;
        let prediction = self.draft.prediction(&step.task)?;
        let result = self.newest.as_ref()?;
        self.is_known = true;
        match score(
            &step.task,
            &prediction,
            &result.run,
            &result.written.options,
        ) {
            Ok(scored) => {
                self.scored = Some(scored.clone());
                Some((Some(prediction), scored))
            }
            Err(error) => {
                self.problem = Some(error);
                None
            }
        }
    }
}
