//! Estimates everything that belongs to the recordings (initial states, instants of events,
//! nuisances) at given parameters: the first step of an evaluation on held-out recordings.

use super::event_revision::{revise, set_suspects_aside};
use super::levenberg_marquardt::{Clock, Control, improve};
use super::multistart::{fit_states, states_plan};
use super::point::{Point, threshold};
use crate::fit::error::FitError;
use crate::fit::options::FitOptions;
use crate::fit::problem::prepare::Prepared;
use crate::model::Model;

/// The point at the parameters of `model`, everything else estimated.
///
/// # Errors
/// [`FitError`] if the model makes no sense there.
pub(crate) fn estimate_states(
    prepared: &Prepared,
    model: &Model,
    options: &FitOptions,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Point, FitError> {
    let problem = &prepared.problem;
    let mut x = problem.space.coordinates(model);
    let locked: Vec<usize> = (0..x.len()).collect();
    x.extend_from_slice(&prepared.nuisances);
    let used = vec![true; prepared.segments.len()];
    let plan = states_plan(&locked, options.iterations);
    let mut point = fit_states(prepared, &x, &used, &plan, control, clock)?;
    let huber = threshold(problem, &point)?;
    if set_suspects_aside(problem, &mut point, huber, control)? > 0 {
        let watch = (control, &*clock);
        revise(problem, &mut point, &prepared.segments, huber, watch)?;
        point = improve(problem, point, &plan, control, clock)?;
    }
    Ok(point)
}
