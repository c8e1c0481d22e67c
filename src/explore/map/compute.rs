//! Points in parallel: coarse first, then where the regime changes, then all others.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use super::axis::AxisOf;
use super::error::MapError;
use super::lattice::{Cell, Lattice, around};
use super::point::{PointFault, PointSolver};
use super::request::{MapRequest, Refinement};
use super::result::{MapPoint, MapResult, MapUpdate, Pass};
use crate::explore::measures::{Drawn, Regime};
use crate::explore::steady_state::SteadyResponse;
use crate::model::Model;
use crate::model::drive::Waveform;

/// Points that a thread solves before it hands them over: some ten milliseconds of work.
const BATCH_POINTS: usize = 16;
/// Points that are filled in one batch.
const BATCH_FILLED: usize = 4096;

/// Category of a point while the map grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Category {
    Unknown,
    /// Guessed: code of the regime around.
    Guess(u32),
    /// Solved: code of its regime.
    Regime(u32),
    Hole,
}

impl Category {
    fn code(self) -> Option<u32> {
        match self {
            Self::Guess(code) | Self::Regime(code) => Some(code),
            Self::Unknown | Self::Hole => None,
        }
    }

    fn is_settled(self) -> bool {
        matches!(self, Self::Regime(_) | Self::Hole)
    }
}

/// A point as it comes from a thread.
struct Solved {
    point: MapPoint,
    category: Category,
}

/// The map. `on_update` is called from several threads while it works.
///
/// When `cancel` is set it returns soon, with the points solved so far.
///
/// # Errors
/// [`MapError`] before any work.
pub fn compute(
    request: &MapRequest,
    cancel: &AtomicBool,
    on_update: &(dyn Fn(MapUpdate) + Sync),
) -> Result<MapResult, MapError> {
    request.check()?;
    let mut growing = Growing {
        request,
        cancel,
        on_update,
        result: MapResult::pending(request),
        categories: vec![Category::Unknown; request.points()],
        solved: AtomicUsize::new(0),
    };
    growing.grow();
    Ok(growing.result)
}

/// Points of the map by their indices, each solved, in that order; those left out by `cancel` are
/// missing. Each equals that of [`compute`] to the last bit.
///
/// # Errors
/// [`MapError`] before any work.
pub fn compute_points(
    request: &MapRequest,
    indices: &[usize],
    cancel: &AtomicBool,
    on_update: &(dyn Fn(MapUpdate) + Sync),
) -> Result<Vec<MapPoint>, MapError> {
    request.check_for(indices.len() as u128)?;
    let batches = Batches {
        request,
        cancel,
        on_update,
        solved: &AtomicUsize::new(0),
        total: indices.len(),
    };
    let found = batches.solve(indices, Pass::Rest);
    Ok(found.into_iter().map(|s| s.point).collect())
}

/// One point with its device, drive and whole response: what stands behind it.
///
/// # Errors
/// [`PointFault`].
pub fn solve_point(
    request: &MapRequest,
    index: usize,
    cancel: &AtomicBool,
) -> Result<(Model, Waveform, SteadyResponse), PointFault> {
    let mut solver = PointSolver::new(request);
    let (model, _) = request.setting(index).map_err(PointFault::Hole)?;
    let go_on = || !cancel.load(Ordering::Relaxed);
    let (response, drive) = solver.response(index, go_on)?;
    Ok((model, drive, response))
}

/// A map while it grows.
struct Growing<'a> {
    request: &'a MapRequest,
    cancel: &'a AtomicBool,
    on_update: &'a (dyn Fn(MapUpdate) + Sync),
    result: MapResult,
    categories: Vec<Category>,
    solved: AtomicUsize,
}

impl Growing<'_> {
    fn grow(&mut self) {
        let shape = self.request.shape();
        let mut lattice = Lattice::coarse(shape);
        self.solve(lattice.points(), Pass::Coarse);
        while let Some(finer) = lattice.finer() {
            let points = self.refined(&lattice, finer);
            let stride = finer.stride.0.max(finer.stride.1);
            self.solve(points, Pass::Boundary { stride });
            lattice = finer;
        }
        self.follow_boundaries(shape);
        if self.request.refinement == Refinement::Everywhere {
            let left = (0..self.categories.len()).filter(|k| !self.categories[*k].is_settled());
            let left = left.map(|k| self.request.place(k)).collect();
            self.solve(left, Pass::Rest);
        }
    }

    /// Fills the cells of one regime, and returns the finer points of all others.
    fn refined(&mut self, lattice: &Lattice, finer: Lattice) -> Vec<(usize, usize)> {
        let (mut points, mut filled) = (Vec::new(), Vec::new());
        for cell in lattice.cells() {
            match self.one_regime(&cell) {
                Some(code) => self.fill(&cell, code, &mut filled),
                None => points.extend(finer.within(&cell)),
            }
        }
        self.hand_over_filled(filled, finer.stride.0.max(finer.stride.1));
        points
    }

    /// Points that are only filled and next to another regime are solved, until there is none.
    fn follow_boundaries(&mut self, shape: (usize, usize)) {
        loop {
            let is_doubtful = |k: &usize| {
                let Category::Guess(code) = self.categories[*k] else {
                    return false;
                };
                let mut near = around(self.request.place(*k), shape);
                near.any(|at| self.category(at).code() != Some(code))
            };
            let doubtful: Vec<_> = (0..self.categories.len())
                .filter(is_doubtful)
                .map(|k| self.request.place(k))
                .collect();
            if doubtful.is_empty() || self.is_cancelled() {
                return;
            }
            self.solve(doubtful, Pass::Boundary { stride: 1 });
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    fn index(&self, (i, j): (usize, usize)) -> usize {
        i + j * self.request.shape().0
    }

    fn category(&self, place: (usize, usize)) -> Category {
        self.categories[self.index(place)]
    }

    /// Code of the regime that all corners of a cell have.
    fn one_regime(&self, cell: &Cell) -> Option<u32> {
        let codes = cell.corners().map(|corner| self.category(corner).code());
        codes[0].filter(|_| codes.iter().all(|code| *code == codes[0]))
    }

    /// Fills the points of a cell of which nothing is known.
    fn fill(&mut self, cell: &Cell, code: u32, filled: &mut Vec<MapPoint>) {
        let corners = cell.corners().map(|corner| self.index(corner));
        for j in cell.second.0..=cell.second.1 {
            for i in cell.first.0..=cell.first.1 {
                let index = self.index((i, j));
                if self.categories[index] != Category::Unknown {
                    continue;
                }
                self.categories[index] = Category::Guess(code);
                let weights = cell.weights((i, j));
                let specs = self.request.measures.iter().map(|m| m.spec());
                let values = specs.zip(&self.result.values).map(|(spec, all)| {
                    let corners = corners.map(|k| all[k]);
                    match spec.drawn {
                        Drawn::Category | Drawn::Count => corners[0],
                        _ => corners.iter().zip(weights).map(|(v, w)| v * w).sum(),
                    }
                });
                let values = Ok(values.collect());
                filled.push(MapPoint {
                    index,
                    values,
                    is_filled: true,
                });
            }
        }
    }

    fn hand_over_filled(&mut self, filled: Vec<MapPoint>, stride: usize) {
        for points in filled.chunks(BATCH_FILLED) {
            let update = MapUpdate {
                pass: Pass::Boundary { stride },
                points: points.to_vec(),
                solved: self.solved.load(Ordering::Relaxed),
                total: self.categories.len(),
            };
            self.result.apply(&update);
            (self.on_update)(update);
        }
    }

    /// Solves those of the points that are not yet.
    fn solve(&mut self, places: Vec<(usize, usize)>, pass: Pass) {
        let indices = places.into_iter().map(|place| self.index(place));
        let mut indices: Vec<usize> = indices
            .filter(|k| !self.categories[*k].is_settled())
            .collect();
        indices.sort_unstable();
        indices.dedup();
        let batches = Batches {
            request: self.request,
            cancel: self.cancel,
            on_update: self.on_update,
            solved: &self.solved,
            total: self.categories.len(),
        };
        for found in batches.solve(&indices, pass) {
            self.categories[found.point.index] = found.category;
            self.result.apply(&MapUpdate {
                pass,
                points: vec![found.point],
                solved: 0,
                total: 0,
            });
        }
    }
}

/// Batches of points on all threads.
struct Batches<'a> {
    request: &'a MapRequest,
    cancel: &'a AtomicBool,
    on_update: &'a (dyn Fn(MapUpdate) + Sync),
    solved: &'a AtomicUsize,
    total: usize,
}

impl Batches<'_> {
    /// In the order of `indices`.
    fn solve(&self, indices: &[usize], pass: Pass) -> Vec<Solved> {
        let ordered = self.by_model(indices);
        let batches = ordered.par_chunks(BATCH_POINTS);
        let found = batches.flat_map_iter(|batch| self.batch(batch, pass));
        let mut found: Vec<(usize, Solved)> = found.collect();
        found.sort_by_key(|(order, _)| *order);
        found.into_iter().map(|(_, solved)| solved).collect()
    }

    /// Indices with their order, those of one device together: changing it costs time.
    fn by_model(&self, indices: &[usize]) -> Vec<(usize, usize)> {
        let mut ordered: Vec<(usize, usize)> = indices.iter().copied().enumerate().collect();
        let first_is_model = self
            .request
            .axes
            .first()
            .is_some_and(|a| a.of == AxisOf::Model);
        if first_is_model {
            ordered.sort_by_key(|(_, index)| self.request.place(*index));
        }
        ordered
    }

    fn batch(&self, batch: &[(usize, usize)], pass: Pass) -> Vec<(usize, Solved)> {
        let mut solver = PointSolver::new(self.request);
        let mut found = Vec::with_capacity(batch.len());
        for &(order, index) in batch {
            match self.point(&mut solver, index) {
                Some(solved) => found.push((order, solved)),
                None => break,
            }
        }
        if !found.is_empty() {
            let before = self.solved.fetch_add(found.len(), Ordering::Relaxed);
            (self.on_update)(MapUpdate {
                pass,
                points: found.iter().map(|(_, s)| s.point.clone()).collect(),
                solved: before + found.len(),
                total: self.total,
            });
        }
        found
    }

    /// `None` if it was cancelled.
    fn point(&self, solver: &mut PointSolver<'_>, index: usize) -> Option<Solved> {
        let go_on = || !self.cancel.load(Ordering::Relaxed);
        if !go_on() {
            return None;
        }
        let measured = solver.response(index, go_on).and_then(|(response, drive)| {
            let code = Regime::of(&response).code();
            let values = solver.measure(&drive, &response, &self.request.measures)?;
            Ok((values, code))
        });
        let (values, category) = match measured {
            Ok((values, code)) => (Ok(values), Category::Regime(code)),
            Err(PointFault::Hole(reason)) => (Err(reason), Category::Hole),
            Err(PointFault::Cancelled) => return None,
        };
        let point = MapPoint {
            index,
            values,
            is_filled: false,
        };
        Some(Solved { point, category })
    }
}
