//! Value after value, the state carried along.

use std::sync::atomic::{AtomicBool, Ordering};

use super::diagram::{Direction, OrbitAnswer, OrbitDiagram, OrbitSlice};
use super::request::OrbitRequest;
use crate::explore::map::{MapError, PointFault, PointSolver};
use crate::sim::MotionState;

/// The diagram. `on_slice` hears of each value as it is done. When `cancel` is set it returns soon, with
/// the values that are done.
///
/// # Errors
/// [`MapError`] before any work.
pub fn compute(
    request: &OrbitRequest,
    cancel: &AtomicBool,
    on_slice: &mut dyn FnMut(&OrbitSlice),
) -> Result<OrbitDiagram, MapError> {
    request.check()?;
    let axis = &request.map.axes[0];
    let mut diagram = OrbitDiagram {
        axis: axis.clone(),
        up: Vec::new(),
        down: Vec::new(),
    };
    let mut sweep = Sweep {
        request,
        cancel,
        solver: PointSolver::new(&request.map),
        carried: None,
    };
    let up = (0..axis.count).map(|index| (Direction::Up, index));
    let down = (0..axis.count).rev().map(|index| (Direction::Down, index));
    let down = down.filter(|_| request.is_swept_back);
    for (direction, index) in up.chain(down) {
        let answer = match sweep.value(index) {
            Ok(answer) => Ok(answer),
            Err(PointFault::Hole(reason)) => Err(reason),
            Err(PointFault::Cancelled) => break,
        };
        let slice = OrbitSlice {
            direction,
            index,
            value: axis.value(index),
            answer,
        };
        on_slice(&slice);
        match direction {
            Direction::Up => diagram.up.push(slice),
            Direction::Down => diagram.down.push(slice),
        }
    }
    Ok(diagram)
}

/// The sweep while it goes on.
struct Sweep<'a> {
    request: &'a OrbitRequest,
    cancel: &'a AtomicBool,
    solver: PointSolver<'a>,
    /// State at the last value's strobe.
    carried: Option<MotionState>,
}

impl Sweep<'_> {
    fn value(&mut self, index: usize) -> Result<OrbitAnswer, PointFault> {
        let cancel = self.cancel;
        let go_on = || !cancel.load(Ordering::Relaxed);
        if !go_on() {
            return Err(PointFault::Cancelled);
        }
        let (model, drive) = self.request.map.setting(index).map_err(PointFault::Hole)?;
        self.solver.take_model(model)?;
        let mut began_anew = None;
        let carried = match &self.carried {
            None => None,
            Some(state) => match self.solver.solve_from(&drive, state, go_on) {
                Ok(response) => Some(response),
                // The state does not fit: the mass would be in the ground.
                Err(PointFault::Hole(reason)) => {
                    began_anew = Some(reason);
                    None
                }
                Err(PointFault::Cancelled) => return Err(PointFault::Cancelled),
            },
        };
        let response = match carried {
            Some(response) => response,
            None => self.solver.solve(&drive, go_on)?,
        };
        let mut answer = OrbitAnswer::of(&response);
        answer.began_anew = began_anew;
        let periods = self.request.lyapunov_periods;
        if periods > 0 {
            answer.lyapunov = self.solver.lyapunov_exponent(&drive, &response, periods)?;
        }
        self.carried = Some(response.cycle.start);
        Ok(answer)
    }
}
