//! The Learn workspace: the lessons, the open step, and what the pupil predicts in it.

mod draft;
pub mod presenting;
pub mod runs;
mod step;

use std::sync::{Arc, OnceLock};

use eframe::egui::Context;

pub use self::draft::Draft;
pub use self::step::{OpenStep, Phase};
use crate::learn::catalogue;
use crate::learn::lesson::Lesson;
use crate::learn::pupil::Pupil;

/// The lessons that come with the program, read once.
pub fn built_in() -> &'static [Arc<Lesson>] {
    static LESSONS: OnceLock<Vec<Arc<Lesson>>> = OnceLock::new();
    LESSONS.get_or_init(|| catalogue::lessons().into_iter().map(Arc::new).collect())
}

/// State of the workspace.
#[derive(Debug, Clone, Default)]
pub struct Learning {
    /// What the pupil has done.
    pub pupil: Pupil,
    /// Lessons from files of a teacher, the newest last.
    pub own: Vec<Arc<Lesson>>,
    /// The open step.
    pub open: Option<OpenStep>,
}

impl Learning {
    /// All lessons, in the order of the list.
    pub fn lessons(&self) -> impl Iterator<Item = &Arc<Lesson>> {
        built_in().iter().chain(&self.own)
    }

    /// Opens a lesson where the pupil left it.
    pub fn open_lesson(&mut self, lesson: &Arc<Lesson>) {
        let progress = self.pupil.progress(&lesson.id);
        self.open_step(&Arc::clone(lesson), progress.step);
    }

    /// Opens a step of a lesson.
    pub fn open_step(&mut self, lesson: &Arc<Lesson>, step: usize) {
        self.pupil.open(lesson, step);
        let step = self.pupil.progress(&lesson.id).step;
        let answers = self.pupil.progress(&lesson.id).answers;
        self.open = OpenStep::new(Arc::clone(lesson), step, answers.get(&step));
    }

    /// Opens the first lesson that is not done, if none is open.
    pub fn open_some(&mut self) {
        if self.open.is_some() {
            return;
        }
        let is_open = |lesson: &&Arc<Lesson>| !self.pupil.progress(&lesson.id).is_done;
        let next = self.lessons().find(is_open).cloned();
        let next = next.or_else(|| built_in().first().cloned());
        if let Some(lesson) = next {
            self.open_lesson(&lesson);
        }
    }

    /// Takes a teacher's lesson and opens it; one of the same id is replaced.
    pub fn take(&mut self, lesson: Lesson) {
        let lesson = Arc::new(lesson);
        self.own.retain(|known| known.id != lesson.id);
        self.own.push(Arc::clone(&lesson));
        // Its progress may be that of a lesson that comes with the program.
        if built_in().iter().any(|known| known.id == lesson.id) {
            self.pupil.reset(&lesson.id);
        }
        self.open_lesson(&lesson);
    }

    /// The next step; after the last one the lesson is done and the next one opens. Returns the
    /// lesson that was finished.
    pub fn go_on(&mut self) -> Option<Arc<Lesson>> {
        let (lesson, step) = self.place()?;
        if step + 1 < lesson.steps.len() {
            self.open_step(&lesson, step + 1);
            return None;
        }
        self.pupil.finish(&lesson);
        self.go_to_lesson(1);
        Some(lesson)
    }

    /// The step before.
    pub fn back(&mut self) {
        if let Some((lesson, step)) = self.place()
            && step > 0
        {
            self.open_step(&lesson, step - 1);
        }
    }

    /// Another lesson of the list, `by` further on. At either end the present one stays.
    pub fn go_to_lesson(&mut self, by: isize) {
        let all: Vec<Arc<Lesson>> = self.lessons().cloned().collect();
        let Some((lesson, _)) = self.place() else {
            return;
        };
        let here = all.iter().position(|known| Arc::ptr_eq(known, &lesson));
        let to = here.and_then(|i| i.checked_add_signed(by));
        if let Some(next) = to.and_then(|i| all.get(i)) {
            self.open_lesson(next);
        }
    }

    /// Forgets what was done in the open lesson, and begins it again.
    pub fn reset(&mut self) {
        if let Some((lesson, _)) = self.place() {
            self.pupil.reset(&lesson.id);
            self.open_lesson(&lesson);
        }
    }

    /// The open lesson and step.
    pub fn place(&self) -> Option<(Arc<Lesson>, usize)> {
        let open = self.open.as_ref()?;
        Some((Arc::clone(&open.lesson), open.index))
    }

    /// Asks for the run of the open step and keeps the answer of one that was shown.
    /// One that is `still` is shown whole at once instead of played.
    pub fn update(&mut self, context: &Context, wall: f64, is_still: bool) {
        let Some(open) = &mut self.open else {
            return;
        };
        if is_still {
            open.playback.skip(open.scene.duration);
        }
        if let Some((prediction, scored)) = open.update(context, wall) {
            let (lesson, index) = (Arc::clone(&open.lesson), open.index);
            self.pupil.answer(&lesson, index, prediction, scored);
        }
    }

    /// Whether something is still being computed.
    pub fn is_busy(&self) -> bool {
        self.open.as_ref().is_some_and(OpenStep::is_busy)
    }
}
