//! Runs of scenes on a thread of their own: of an open step with its texts, and of the presenter.

use std::sync::Arc;
use std::time::Duration;

use crate::app::analysis::explore::latest::Answers;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::simulation::snapshot::Snapshot;
use crate::learn::lesson::{Lesson, Task, Written};
use crate::learn::playback::SlowMoments;
use crate::learn::run::{Run, Scene};
use crate::learn::target::{Round, Target};

/// Seed of the noise of a recording to be fitted by hand: the same for a whole class.
const FIT_SEED: u64 = 48;

/// What is asked: a scene, and the step that it belongs to.
#[derive(Debug, Clone)]
pub struct SceneQuestion {
    /// The scene as it is now.
    pub scene: Scene,
    /// Lesson and step whose texts are wanted too.
    pub step: Option<(Arc<Lesson>, usize)>,
    /// The round of a game whose recording is wanted.
    pub round: Option<Round>,
}

impl PartialEq for SceneQuestion {
    fn eq(&self, other: &Self) -> bool {
        let is_same_step = match (&self.step, &other.step) {
            (Some((a, i)), Some((b, j))) => Arc::ptr_eq(a, b) && i == j,
            (None, None) => true,
            _ => false,
        };
        is_same_step && self.scene == other.scene && self.round == other.round
    }
}

/// A run as it is shown.
#[derive(Debug, Clone)]
pub struct SceneResult {
    /// The run.
    pub run: Arc<Run>,
    /// The same for the pictures.
    pub snapshot: Arc<Snapshot>,
    /// Where it is shown slowly.
    pub slow: Arc<SlowMoments>,
    /// The texts of its step; empty without one.
    pub written: Arc<Written>,
    /// The recording to compare with.
    pub target: Option<TargetCurves>,
}

/// A recording with what is drawn of it.
#[derive(Debug, Clone)]
pub struct TargetCurves {
    /// The recording.
    pub target: Arc<Target>,
    /// Its readings.
    pub recorded: Arc<Pyramid>,
    /// Simulated less recorded reading.
    pub residual: Arc<Pyramid>,
}

impl TargetCurves {
    fn new(target: Arc<Target>, run: &Run) -> Self {
        let pyramid = |values: &[f64]| Arc::new(Pyramid::new(target.t0, target.dt, values));
        Self {
            recorded: pyramid(&target.readings),
            residual: pyramid(&target.residual(run)),
            target,
        }
    }
}

/// A step, with the round of its game.
type KnownStep = (Arc<Lesson>, usize, Option<Round>);

/// Simulates scenes; keeps the texts and the recording of the step at hand.
#[derive(Default)]
pub struct SceneRuns {
    generation: u64,
    texts: Option<(Arc<Lesson>, usize, Arc<Written>)>,
    target: Option<(KnownStep, Arc<Target>)>,
}

impl Answers for SceneRuns {
    type Question = SceneQuestion;
    type Answer = SceneResult;
    const NAME: &'static str = "scene";

    fn answer(
        &mut self,
        question: &SceneQuestion,
        go_on: &dyn Fn() -> bool,
    ) -> Result<SceneResult, String> {
        let given_up = || "given up for a newer one".to_owned();
        let run = question.scene.run(go_on);
        let run = run
            .map_err(|error| error.to_string())?
            .ok_or_else(given_up)?;
        self.generation += 1;
        let snapshot = Snapshot::new(
            self.generation,
            &run.model,
            Arc::clone(&run.trace),
            Vec::new(),
            Duration::ZERO,
        );
        Ok(SceneResult {
            slow: Arc::new(SlowMoments::of(&run.trace, run.duration)),
            snapshot: Arc::new(snapshot),
            written: self.written(question, go_on)?,
            target: (self.target_of(question, go_on)?)
                .map(|target| TargetCurves::new(target, &run)),
            run: Arc::new(run),
        })
    }
}

impl SceneRuns {
    /// The texts of the step, with the numbers of its own scene.
    fn written(
        &mut self,
        question: &SceneQuestion,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Arc<Written>, String> {
        let Some((lesson, index)) = &question.step else {
            return Ok(Arc::default());
        };
        if let Some((of, i, written)) = &self.texts
            && Arc::ptr_eq(of, lesson)
            && i == index
        {
            return Ok(Arc::clone(written));
        }
        let Some(step) = lesson.steps.get(*index) else {
            return Ok(Arc::default());
        };
        let run = step.scene.run(go_on).map_err(|error| error.to_string())?;
        let run = run.ok_or("given up for a newer one")?;
        let written = step
            .written(&run)
            .map_err(|error| format!("{}, step {}: {error}", lesson.title, index + 1))?;
        let written = Arc::new(written);
        self.texts = Some((Arc::clone(lesson), *index, Arc::clone(&written)));
        Ok(written)
    }

    /// The recording to compare with, if the step has one.
    fn target_of(
        &mut self,
        question: &SceneQuestion,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<Arc<Target>>, String> {
        let Some((lesson, index)) = &question.step else {
            return Ok(None);
        };
        if let Some(((of, i, round), target)) = &self.target
            && Arc::ptr_eq(of, lesson)
            && i == index
            && *round == question.round
        {
            return Ok(Some(Arc::clone(target)));
        }
        let Some(step) = lesson.steps.get(*index) else {
            return Ok(None);
        };
        let made = match (&step.task, &question.round) {
            (Task::Fit(fit), _) => fit.target(&step.scene, FIT_SEED, go_on),
            (Task::Concealed(game), Some(round)) => game.target(&step.scene, round, go_on),
            _ => return Ok(None),
        };
        let made = made.map_err(|error| error.to_string())?.map(Arc::new);
        if let Some(target) = &made {
            let round = question.round.clone();
            self.target = Some(((Arc::clone(lesson), *index, round), Arc::clone(target)));
        }
        Ok(made)
    }
}
