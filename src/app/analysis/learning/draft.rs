//! A prediction while it is made.

use crate::learn::lesson::{CurveTask, Mark, Task};
use crate::learn::prediction::Prediction;

/// What the pupil has set so far.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Draft {
    /// The chosen answer, from 0.
    pub choice: Option<usize>,
    /// The value of the mark \[SI\].
    pub mark: f64,
    /// Whether the mark was moved.
    pub mark_is_moved: bool,
    /// The points of the curve \[m\].
    pub curve: Vec<f64>,
    /// Whether a point was moved.
    pub curve_is_moved: bool,
    /// The point that keys move.
    pub point: usize,
}

impl Draft {
    /// The beginning of a task: the mark and all points in the middle, so that nothing is told.
    pub fn new(task: &Task) -> Self {
        let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
        match task {
            Task::Mark(mark) => Self {
                mark: middle(mark.range),
                ..Self::default()
            },
            Task::Curve(curve) => Self {
                curve: vec![middle(curve.range); curve.points],
                ..Self::default()
            },
            _ => Self::default(),
        }
    }

    /// Moves the mark by `steps` of its keys.
    pub fn move_mark(&mut self, mark: &Mark, steps: f64) {
        self.set_mark(mark, self.mark + steps * mark.step());
    }

    /// Moves the mark to a value \[SI\], held within its range.
    pub fn set_mark(&mut self, mark: &Mark, value: f64) {
        self.mark = value.clamp(mark.range.0, mark.range.1);
        self.mark_is_moved = true;
    }

    /// Moves a point of the curve to a reading \[m\], held within its range.
    pub fn set_point(&mut self, task: &CurveTask, index: usize, reading: f64) {
        if let Some(point) = self.curve.get_mut(index) {
            *point = reading.clamp(task.range.0, task.range.1);
            self.curve_is_moved = true;
        }
    }

    /// The prediction, once one was made.
    pub fn prediction(&self, task: &Task) -> Option<Prediction> {
        match task {
            Task::Choice(_) => self.choice.map(Prediction::Choice),
            Task::Mark(_) => self.mark_is_moved.then_some(Prediction::Mark(self.mark)),
            Task::Curve(_) => {
                let is_drawn = self.curve_is_moved;
                is_drawn.then(|| Prediction::Curve(self.curve.clone()))
            }
            _ => None,
        }
    }

    /// A draft that shows a prediction made before.
    pub fn of(task: &Task, prediction: &Prediction) -> Self {
        let mut draft = Self::new(task);
        match (task, prediction) {
            (Task::Choice(_), Prediction::Choice(chosen)) => draft.choice = Some(*chosen),
            (Task::Mark(mark), Prediction::Mark(value)) => draft.set_mark(mark, *value),
            (Task::Curve(task), Prediction::Curve(points)) if points.len() == task.points => {
                draft.curve.clone_from(points);
                draft.curve_is_moved = true;
            }
            _ => {}
        }
        draft
    }
}
