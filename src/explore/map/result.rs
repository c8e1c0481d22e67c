//! A map, and the batches in which it comes.

use std::collections::BTreeMap;

use super::axis::Axis;
use super::request::MapRequest;
use crate::explore::measures::MeasureId;

/// What is known of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointState {
    /// Nothing yet.
    Pending,
    /// Guessed from coarser points around of one regime: categories as theirs, numbers interpolated.
    Filled,
    /// Solved.
    Solved,
    /// Impossible, for a reason that is kept.
    Hole,
}

/// Which part of the work a batch belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// The coarse lattice.
    Coarse,
    /// Where the regime changes, with points `stride` apart.
    Boundary {
        /// Steps of the finer axis.
        stride: usize,
    },
    /// All others.
    Rest,
}

/// A point of a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct MapPoint {
    /// Index, see [`MapRequest::place`].
    pub index: usize,
    /// Value of each measure, NaN where the response has none; or why the point is impossible.
    pub values: Result<Vec<f64>, String>,
    /// Whether it is only filled.
    pub is_filled: bool,
}

/// A batch of points.
#[derive(Debug, Clone, PartialEq)]
pub struct MapUpdate {
    /// What they belong to.
    pub pass: Pass,
    /// The points.
    pub points: Vec<MapPoint>,
    /// Points solved so far, holes too.
    pub solved: usize,
    /// Points of the map.
    pub total: usize,
}

/// A map. Point `(i, j)` has the index `i + j * axes[0].count`.
#[derive(Debug, Clone, PartialEq)]
pub struct MapResult {
    /// The axes.
    pub axes: Vec<Axis>,
    /// The measures.
    pub measures: Vec<MeasureId>,
    /// For each measure the value of each point; NaN where it has none.
    pub values: Vec<Vec<f64>>,
    /// For each point what is known.
    pub states: Vec<PointState>,
    /// Reason of each hole, by index.
    pub holes: BTreeMap<usize, String>,
}

impl MapResult {
    /// Without any point yet.
    #[must_use]
    pub fn pending(request: &MapRequest) -> Self {
        let points = request.points();
        Self {
            axes: request.axes.clone(),
            measures: request.measures.clone(),
            values: vec![vec![f64::NAN; points]; request.measures.len()],
            states: vec![PointState::Pending; points],
            holes: BTreeMap::new(),
        }
    }

    /// Puts in the points of a batch. What is solved is not replaced by what is filled.
    pub fn apply(&mut self, update: &MapUpdate) {
        update.points.iter().for_each(|point| self.put(point));
    }

    fn put(&mut self, point: &MapPoint) {
        let Some(state) = self.states.get_mut(point.index) else {
            return;
        };
        let is_settled = matches!(*state, PointState::Solved | PointState::Hole);
        if point.is_filled && is_settled {
            return;
        }
        match &point.values {
            Ok(values) => {
                *state = if point.is_filled {
                    PointState::Filled
                } else {
                    PointState::Solved
                };
                for (all, value) in self.values.iter_mut().zip(values) {
                    all[point.index] = *value;
                }
            }
            Err(reason) => {
                *state = PointState::Hole;
                self.values
                    .iter_mut()
                    .for_each(|all| all[point.index] = f64::NAN);
                self.holes.insert(point.index, reason.clone());
            }
        }
    }

    /// Whether each point is solved, filled or a hole.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        !self.states.contains(&PointState::Pending)
    }

    /// Number of points of a state.
    #[must_use]
    pub fn count(&self, state: PointState) -> usize {
        self.states.iter().filter(|own| **own == state).count()
    }

    /// Values of a measure, if it was asked for.
    #[must_use]
    pub fn of(&self, measure: MeasureId) -> Option<&[f64]> {
        let place = self.measures.iter().position(|own| *own == measure)?;
        self.values.get(place).map(Vec::as_slice)
    }
}
