//! Beginnings in parallel, and the responses they lead to.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::request::BasinRequest;
use super::responses::{BasinResponse, Signature};
use crate::explore::map::{
    MapError, MapRequest, MapStart, PointFault, PointSolver, progressive_order,
};
use crate::model::parameter::ParameterId;

/// Beginnings that a thread follows before it looks for others.
const BATCH_BEGINNINGS: usize = 8;

/// Where a beginning leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BasinPoint {
    /// Not followed yet.
    Pending,
    /// To a response, by its place in [`BasinMap::responses`].
    Response(usize),
    /// It is impossible; [`BasinMap::holes`] has the reason.
    Hole,
}

/// Which beginnings lead where.
#[derive(Debug, Clone, PartialEq)]
pub struct BasinMap {
    /// Beginnings along each direction.
    pub shape: (usize, usize),
    /// Each beginning, index `i + j * shape.0`.
    pub points: Vec<BasinPoint>,
    /// Responses in the order in which they were found.
    pub responses: Vec<BasinResponse>,
    /// Reason of each hole, by index.
    pub holes: BTreeMap<usize, String>,
}

/// The basins. `on_pass` hears of the map after each pass. When `cancel` is set it returns soon, with
/// what is done.
///
/// # Errors
/// [`MapError`] before any work.
pub fn compute(
    request: &BasinRequest,
    cancel: &AtomicBool,
    on_pass: &dyn Fn(&BasinMap),
) -> Result<BasinMap, MapError> {
    request.check()?;
    let shape = request.shape();
    let mut map = BasinMap {
        shape,
        points: vec![BasinPoint::Pending; shape.0 * shape.1],
        responses: Vec::new(),
        holes: BTreeMap::new(),
    };
    let mut known: Vec<Signature> = Vec::new();
    for pass in progressive_order(shape) {
        let batches = pass.par_chunks(BATCH_BEGINNINGS);
        let found = batches.flat_map_iter(|own| batch(request, own, cancel));
        // In order, so that responses have the same numbers whatever the threads.
        let found: Vec<(usize, Result<Signature, String>)> = found.collect();
        for (index, answer) in found {
            map.points[index] = match answer {
                Ok(own) => {
                    BasinPoint::Response(map.number_of(own, index, &mut known, request.tolerance))
                }
                Err(reason) => {
                    map.holes.insert(index, reason);
                    BasinPoint::Hole
                }
            };
        }
        map.count();
        on_pass(&map);
        if cancel.load(Ordering::Relaxed) {
            break;
        }
    }
    Ok(map)
}

impl BasinMap {
    fn number_of(
        &mut self,
        own: Signature,
        index: usize,
        known: &mut Vec<Signature>,
        tolerance: f64,
    ) -> usize {
        let found = known
            .iter()
            .position(|other| own.is_one_with(other, tolerance));
        found.unwrap_or_else(|| {
            self.responses.push(own.response(index));
            known.push(own);
            known.len() - 1
        })
    }

    /// Counts and shares anew.
    fn count(&mut self) {
        self.responses.iter_mut().for_each(|own| own.count = 0);
        for point in &self.points {
            if let BasinPoint::Response(number) = point {
                self.responses[*number].count += 1;
            }
        }
        let all: usize = self.responses.iter().map(|own| own.count).sum();
        for own in &mut self.responses {
            own.share = own.count as f64 / all.max(1) as f64;
        }
    }
}

/// Beginnings of one thread; those that are cancelled are missing.
fn batch(
    request: &BasinRequest,
    indices: &[usize],
    cancel: &AtomicBool,
) -> Vec<(usize, Result<Signature, String>)> {
    let go_on = || !cancel.load(Ordering::Relaxed);
    let mut found = Vec::with_capacity(indices.len());
    let mut map = MapRequest::new(
        request.model.clone(),
        request.drive.clone(),
        Vec::new(),
        Vec::new(),
    );
    map.options = request.options.clone();
    map.point_device_seconds = request.point_device_seconds;
    let mut solver = PointSolver::new(&map);
    let ready = solver.take_model(request.model.clone());
    for &index in indices {
        let answer = ready.clone().and_then(|()| {
            if !go_on() {
                return Err(PointFault::Cancelled);
            }
            let (initial, switched_on) = request.beginning(index);
            let parameters = &request.model.parameters;
            let rest = (parameters[ParameterId::X0], parameters[ParameterId::V0]);
            let (displacement, velocity) = initial.unwrap_or(rest);
            let start = MapStart::Point {
                displacement,
                velocity,
                switched_on,
            };
            solver.solve_with(&request.drive, start, go_on)
        });
        match answer {
            Ok(response) => found.push((index, Ok(Signature::of(&response)))),
            Err(PointFault::Hole(reason)) => found.push((index, Err(reason))),
            Err(PointFault::Cancelled) => break,
        }
    }
    found
}
