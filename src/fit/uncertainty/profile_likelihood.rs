//! Profile likelihood: the best cost with one parameter held at each of several values (Raue et
//! al., Bioinformatics 25, 1923, 2009).
//!
//! The parameter's own value is held, not a coordinate of the fit: the film's strength is profiled
//! by `Cs` itself. All points use one robust loss, so that their costs can be compared.

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::fit_result::{FitResult, FittedParameter, misfits};
use super::normal_inverse::inverse;
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::{Prepared, prepare};
use crate::fit::solve::estimate_states::estimate_states;
use crate::fit::solve::levenberg_marquardt::{Clock, Control, Plan, improve_under};
use crate::fit::solve::normal_equations::normal_equations;
use crate::fit::solve::point::{Point, settle, threshold};
use crate::model::Model;
use crate::model::parameter::{ParameterSpec, Scale};

/// Most iterations for each point.
const MAX_POINT_ITERATIONS: usize = 15;
/// Iterations that a point usually takes, for the estimate of the time left.
const EXPECTED_POINT_ITERATIONS: usize = 5;
/// Largest change of the logarithm for one standard error, for parameters whose errors reach below
/// zero.
const MAX_LOG_STEP_PER_SIGMA: f64 = 1.0;
/// Rounds in which the segments' own unknowns follow a value.
const VALUE_SETTLE_ROUNDS: usize = 3;
/// Iterations that finding the fitted point again usually takes, for the estimate of the time left.
const EXPECTED_ESTIMATE_ITERATIONS: usize = 5;

/// One point of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfilePoint {
    /// Value of the parameter, SI.
    pub value: f64,
    /// Rise of the cost above its minimum, in units of the scatter: 1 at one standard error, 3.84
    /// at 95 %.
    pub rise: f64,
}

/// Profile of the parameter `id` of a `result` on the parts `train` that it was fitted to:
/// the best cost with its value held at each of `shifts` in its standard errors, all other
/// fitted parameters refitted. `options` are those of the fit, except for `free`.
/// Cancelled, it gives the points found so far.
///
/// # Errors
/// [`FitError`] if a part cannot be used or the parameter was not fitted.
pub fn profile_of(
    result: &FitResult,
    train: &[Part],
    id: &str,
    shifts: &[f64],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Vec<ProfilePoint>, FitError> {
    let fitted: Vec<String> = result.parameters.iter().map(|p| p.id.clone()).collect();
    let Some(parameter) = result
        .parameters
        .iter()
        .find(|p| p.id.eq_ignore_ascii_case(id))
    else {
        return Err(FitError::NotFitted {
            id: id.to_owned(),
            fitted: fitted.join(", "),
        });
    };
    let space = Space::new(&result.model, &fitted)?;
    let summaries = summarize(&result.model, train);
    let prepared = prepare(&result.model, &space, train, &summaries, options)?;
    let mut clock = Clock::new(EXPECTED_ESTIMATE_ITERATIONS);
    let point = estimate_states(&prepared, &result.model, options, control, &mut clock)?;
    profile(
        &prepared, point, parameter, shifts, options, control, &mut clock,
    )
}

/// Profile of `parameter`, which is free in `prepared`, over `shifts` in its standard
/// errors around the best, in their order; `start` is the point that was fitted. Values at which the
/// model makes no sense are omitted, and so are those not reached before a cancel.
///
/// # Errors
/// [`FitError`] if the parameter is not free or the model makes no sense.
fn profile(
    prepared: &Prepared,
    start: Point,
    parameter: &FittedParameter,
    shifts: &[f64],
    options: &FitOptions,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Vec<ProfilePoint>, FitError> {
    let problem = &prepared.problem;
    let Some(at) = problem.space.position(&parameter.id) else {
        let entries = problem.space.entries.iter();
        let fitted: Vec<&str> = entries.map(|e| e.id.as_str()).collect();
        return Err(FitError::NotFitted {
            id: parameter.id.clone(),
            fitted: fitted.join(", "),
        });
    };
    let huber = threshold(problem, &start)?;
    let plan = Plan {
        stage: "profile",
        iterations: options.iterations.min(MAX_POINT_ITERATIONS),
        locked: &[],
        enough: 1e-8,
    };
    clock.expected = clock.done() + EXPECTED_POINT_ITERATIONS * (shifts.len() + 1);
    let best = improve_under(problem, start, &plan, huber, control, clock)?;
    let scatter = misfits(prepared, &best)?.0.chi2.max(1.0);
    let along = valley_direction(problem, &best, at, huber)?;
    // The fit may have stopped a fraction of a standard error short of the minimum.
    let centre = FittedParameter {
        value: problem.space.values(&best.x)[at],
        ..parameter.clone()
    };
    let held = HeldParameter {
        problem,
        best: &best,
        along: &along,
        parameter: &centre,
        huber,
    };
    let values = held_values(&centre, &problem.space.entries[at].spec, shifts);
    // From the middle outwards: each point is near the one before it.
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| shifts[a].abs().total_cmp(&shifts[b].abs()));
    let mut found: Vec<(usize, ProfilePoint)> = Vec::with_capacity(values.len());
    // The outermost point on either side.
    let mut sides: [Option<ProfileState>; 2] = [None, None];
    for i in order {
        let value = values[i];
        let last = &mut sides[usize::from(shifts[i] > 0.0)];
        let Some((there, point)) = held.begin(value, last.as_ref())? else {
            continue;
        };
        let point = improve_under(&there, point, &plan, huber, control, clock)?;
        if control.cancelled() {
            break;
        }
        let rise = (point.cost - best.cost) / scatter;
        found.push((i, ProfilePoint { value, rise }));
        *last = Some(ProfileState {
            model: there.space.model(&point.x),
            point,
        });
    }
    found.sort_by_key(|f| f.0);
    // The search for the minimum may have stopped a little short of it.
    let lowest = found.iter().map(|f| f.1.rise).fold(0.0, f64::min);
    let above = |(_, p): (usize, ProfilePoint)| ProfilePoint {
        rise: p.rise - lowest,
        ..p
    };
    Ok(found.into_iter().map(above).collect())
}

/// A point with its model.
struct ProfileState {
    model: Model,
    point: Point,
}

/// The problem with one parameter held, around the best of it free.
struct HeldParameter<'a> {
    problem: &'a Problem,
    best: &'a Point,
    /// Change of all unknowns per unit of the parameter's value.
    along: &'a DVector<f64>,
    parameter: &'a FittedParameter,
    huber: Huber,
}

impl HeldParameter<'_> {
    /// The problem with the parameter held at `value`, and the better of two points to begin at:
    /// the best point moved along the valley, and the `last` point. `None` if the model makes no
    /// sense with that value.
    fn begin(
        &self,
        value: f64,
        last: Option<&ProfileState>,
    ) -> Result<Option<(Problem, Point)>, FitError> {
        let free = &self.problem.space;
        let valley = self.best.x.iter().zip(self.along.iter());
        let valley: Vec<f64> = valley
            .map(|(x, d)| x + d * (value - self.parameter.value))
            .collect();
        let ahead = free.model(&valley);
        let mut starts = vec![(&ahead, &valley, self.best)];
        starts.extend(last.map(|s| (&s.model, &s.point.x, &s.point)));
        let mut chosen: Option<(Problem, Point)> = None;
        for (model, x, from) in starts {
            let space = free.holding(model, &self.parameter.id, value);
            if space.base().check().is_err() {
                continue;
            }
            let mut there = space.coordinates(space.base());
            there.extend_from_slice(&x[x.len() - self.problem.nuisances.len()..]);
            let problem = Problem {
                space,
                ..self.problem.clone()
            };
            let point = settle(
                &problem,
                &there,
                &from.segments,
                &from.used,
                self.huber,
                VALUE_SETTLE_ROUNDS,
            )?;
            if chosen.as_ref().is_none_or(|c| point.cost < c.1.cost) {
                chosen = Some((problem, point));
            }
        }
        Ok(chosen)
    }
}

/// Change of all unknowns per unit of the value of the parameter `at`, the others at their best
/// (linearized).
fn valley_direction(
    problem: &Problem,
    best: &Point,
    at: usize,
    huber: Huber,
) -> Result<DVector<f64>, FitError> {
    let reduced = problem.linearize(&best.x, &best.segments, &best.used, huber, &[])?;
    let (normal, _) = normal_equations(problem, &best.x, &reduced, huber);
    let slopes = problem.space.slopes(&best.x);
    let mut slope = DVector::zeros(problem.unknowns());
    for i in 0..problem.space.len() {
        slope[i] = slopes[(at, i)];
    }
    let turned = inverse(&normal) * &slope;
    let variance = slope.dot(&turned);
    Ok(if variance > 0.0 && variance.is_finite() {
        turned / variance
    } else {
        DVector::zeros(problem.unknowns())
    })
}

/// Values that are `shifts` standard errors from the parameter's own, within its limits. A
/// logarithmic parameter whose errors reach below zero is shifted by a factor; one that is not
/// determined, by tenths of its range.
fn held_values(parameter: &FittedParameter, spec: &ParameterSpec, shifts: &[f64]) -> Vec<f64> {
    let value = parameter.value;
    let error = if parameter.std_error.is_finite() {
        parameter.std_error
    } else {
        0.1 * (spec.range.1 - spec.range.0)
    };
    let lowest = shifts.iter().copied().fold(0.0, f64::min);
    let by_factor = spec.scale == Scale::Log && value > 0.0 && value + lowest * error <= 0.0;
    let width = (error / value).min(MAX_LOG_STEP_PER_SIGMA);
    let shifted = |shift: &f64| {
        if by_factor {
            value * (shift * width).exp()
        } else {
            value + shift * error
        }
    };
    let (low, high) = spec.limits;
    shifts
        .iter()
        .map(shifted)
        .map(|v| v.clamp(low, high))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::profile_likelihood::*;
    use crate::model::parameter::ParameterId;

    #[test]
    fn held_values_stay_within_the_limits() {
        let of = |id: ParameterId, value: f64, std_error: f64| {
            let spec = id.spec();
            let parameter = FittedParameter {
                id: spec.id.to_owned(),
                value,
                std_error,
                unit: spec.unit,
                start: value,
                at_bound: false,
            };
            held_values(&parameter, spec, &[-3.0, 0.0, 3.0])
        };
        let close = |found: Vec<f64>, expected: [f64; 3]| {
            for (f, e) in found.iter().zip(expected) {
                assert!((f / e - 1.0).abs() < 1e-9, "{found:?} {expected:?}");
            }
        };
        close(of(ParameterId::Dp, 58e-6, 1e-7), [57.7e-6, 58e-6, 58.3e-6]);
        // Three errors lead below zero: factors instead, and no more than e for one.
        let cs = of(ParameterId::Cs, 1e-20, 0.5e-20);
        close(cs, [1e-20 / 1.5f64.exp(), 1e-20, 1e-20 * 1.5f64.exp()]);
        let cs = of(ParameterId::Cs, 1e-20, f64::INFINITY);
        assert!(cs[0] > 0.0 && cs[2] < 1e-18, "{cs:?}");
        close(of(ParameterId::Alpha, 0.9, 0.05), [0.75, 0.9, 1.0]);
    }
}
