//! Robustness over the points of a map.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use super::ensemble::{Ensemble, Member};
use super::error::RobustnessError;
use super::evaluate::Cases;
use super::result::Robustness;
use super::wish::Wish;
use crate::explore::map::{Axis, MapError, MapRequest, progressive_order};

/// Points that a thread computes together; each costs as many steady states as there are members.
const BATCH_POINTS: usize = 4;
/// Memory of one answer beside its quantiles \[bytes\], about.
const BYTES_OF_ANSWER: u128 = 600;
/// Memory that all answers may take \[bytes\].
const MEMORY_LIMIT: u128 = 512 << 20;

/// Robustness over one or two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustnessRequest {
    /// Axes, device, drive; `measures` are those of which quantiles are given.
    pub map: MapRequest,
    /// The devices.
    pub ensemble: Ensemble,
    /// What is wanted.
    pub wish: Wish,
}

impl RobustnessRequest {
    /// Checks it for so many points at a time.
    ///
    /// # Errors
    /// [`RobustnessError`].
    pub fn check_for(&self, points: u128) -> Result<(), RobustnessError> {
        self.map.check_for(points)?;
        self.ensemble.check(&self.map.model)?;
        self.wish.check()?;
        let needed = points.saturating_mul(BYTES_OF_ANSWER);
        if needed > MEMORY_LIMIT {
            return Err(MapError::TooLarge {
                points,
                needed: needed >> 20,
                allowed: MEMORY_LIMIT >> 20,
            }
            .into());
        }
        Ok(())
    }
}

/// A batch of points on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustUpdate {
    /// Index of a point with what the ensemble says, or why it is impossible.
    pub points: Vec<(usize, Result<Robustness, String>)>,
    /// Points done so far.
    pub done: usize,
    /// Points of the map.
    pub total: usize,
}

/// Robustness over a map; point `(i, j)` has the index `i + j * axes[0].count`.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustnessMap {
    /// The axes.
    pub axes: Vec<Axis>,
    /// For each point the answer, or why it is impossible; `None` is not computed yet.
    pub points: Vec<Option<Result<Robustness, String>>>,
}

impl RobustnessMap {
    /// Without any point yet.
    #[must_use]
    pub fn pending(request: &RobustnessRequest) -> Self {
        Self {
            axes: request.map.axes.clone(),
            points: vec![None; request.map.points()],
        }
    }

    /// Puts in a batch.
    pub fn apply(&mut self, update: &RobustUpdate) {
        for (index, answer) in &update.points {
            if let Some(place) = self.points.get_mut(*index) {
                *place = Some(answer.clone());
            }
        }
    }
}

/// The map, coarse points first. `on_update` is called from several threads. When `cancel` is set it
/// returns soon, with the points that are done.
///
/// # Errors
/// [`RobustnessError`] before any work.
pub fn compute(
    request: &RobustnessRequest,
    cancel: &AtomicBool,
    on_update: &(dyn Fn(RobustUpdate) + Sync),
) -> Result<RobustnessMap, RobustnessError> {
    request.check_for(request.map.points() as u128)?;
    let mut map = RobustnessMap::pending(request);
    let order = progressive_order(request.map.shape());
    let done = AtomicUsize::new(0);
    for pass in order {
        let found = points(request, &pass, cancel, (on_update, &done, map.points.len()))?;
        for (index, answer) in found {
            map.points[index] = Some(answer);
        }
    }
    Ok(map)
}

/// What the ensemble says of a point, or why the point is impossible.
pub type PointAnswer = (usize, Result<Robustness, String>);

/// Points by their indices, in that order; those left out by `cancel` are missing. Each equals that
/// of [`compute`].
///
/// # Errors
/// [`RobustnessError`] before any work.
pub fn compute_points(
    request: &RobustnessRequest,
    indices: &[usize],
    cancel: &AtomicBool,
    on_update: &(dyn Fn(RobustUpdate) + Sync),
) -> Result<Vec<PointAnswer>, RobustnessError> {
    request.check_for(indices.len() as u128)?;
    let done = AtomicUsize::new(0);
    points(request, indices, cancel, (on_update, &done, indices.len()))
}

/// Who hears of batches, points done, and points in all.
type Report<'a> = (&'a (dyn Fn(RobustUpdate) + Sync), &'a AtomicUsize, usize);

fn points(
    request: &RobustnessRequest,
    indices: &[usize],
    cancel: &AtomicBool,
    (on_update, done, total): Report<'_>,
) -> Result<Vec<PointAnswer>, RobustnessError> {
    let members = request.ensemble.draw()?;
    let batches = indices.par_chunks(BATCH_POINTS).map(|own| {
        let found = batch(request, &members, own, cancel);
        if !found.is_empty() {
            let before = done.fetch_add(found.len(), Ordering::Relaxed);
            on_update(RobustUpdate {
                points: found.clone(),
                done: before + found.len(),
                total,
            });
        }
        found
    });
    let all: Vec<Vec<PointAnswer>> = batches.collect();
    Ok(all.into_iter().flatten().collect())
}

/// Points of one thread, in order; none if cancelled.
fn batch(
    request: &RobustnessRequest,
    members: &[Member],
    indices: &[usize],
    cancel: &AtomicBool,
) -> Vec<PointAnswer> {
    let go_on = || !cancel.load(Ordering::Relaxed);
    if !go_on() {
        return Vec::new();
    }
    let mut answers = BTreeMap::new();
    let (mut own, mut cases) = (Vec::new(), Vec::new());
    for index in indices {
        match request.map.setting(*index) {
            Ok(case) => {
                own.push(*index);
                cases.push(case);
            }
            Err(reason) => {
                answers.insert(*index, Err(reason));
            }
        }
    }
    let all = Cases {
        request: &request.map,
        ensemble: &request.ensemble,
        members,
        wish: &request.wish,
    };
    let Some(found) = all.answer(&cases, &go_on) else {
        return Vec::new();
    };
    for (index, robustness) in own.into_iter().zip(found) {
        let answer = match &robustness.first_failure {
            Some(reason) if robustness.failed == robustness.members => {
                Err(format!("each member is impossible; the first: {reason}"))
            }
            _ => Ok(robustness),
        };
        answers.insert(index, answer);
    }
    let ordered = indices.iter();
    ordered
        .filter_map(|index| answers.remove(index).map(|own| (*index, own)))
        .collect()
}
