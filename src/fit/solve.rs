//! Bounded Levenberg-Marquardt over parameters and nuisances, with each segment's own
//! unknowns eliminated and brought along.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::problem::{Problem, Reduced};
use super::robust::Huber;
use super::segment::Segment;
use crate::sim::SimError;

/// Largest step of a parameter's coordinate (a factor of e on a logarithm).
const LARGEST: f64 = 1.0;
/// Threshold of the robust loss in units of the noise.
const THRESHOLD: f64 = 3.0;

/// A step is small if it is below this share of the squared standard error.
const SETTLED: f64 = 1e-2;

/// How far a fit has come.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: &'static str,
    /// Iterations done in all.
    pub iteration: usize,
    /// Iterations expected in all.
    pub expected: usize,
    /// Misfit: root of the robust cost per row, 1 at the noise.
    pub misfit: f64,
    /// Values of the parameters in SI, in the order of the free ones.
    pub values: Vec<f64>,
    /// Time left, as far as one can tell.
    pub remaining: Duration,
}

/// Means to watch a fit and to end it early.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Set to true, the fit ends soon with the best so far.
    pub cancel: &'a AtomicBool,
    /// Called after each iteration.
    pub progress: &'a (dyn Fn(&Progress) + Sync),
}

impl Control<'_> {
    /// Whether to stop.
    pub fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

/// Unknowns with their cost.
#[derive(Debug, Clone)]
pub struct Point {
    /// Coordinates of the parameters, then the nuisances.
    pub x: Vec<f64>,
    /// The segments with their own unknowns.
    pub segments: Vec<Segment>,
    /// Whether a segment could be simulated.
    pub alive: Vec<bool>,
    /// Whether a segment has a say.
    pub used: Vec<bool>,
    /// Robust cost.
    pub cost: f64,
    /// Rows in all.
    pub rows: usize,
}

/// Counts iterations for the estimate of the time left.
#[derive(Debug)]
pub struct Clock {
    started: Instant,
    done: usize,
    /// Iterations expected in all.
    pub expected: usize,
}

impl Clock {
    /// Started now.
    pub fn new(expected: usize) -> Self {
        Self {
            started: Instant::now(),
            done: 0,
            expected,
        }
    }
}

/// Which unknowns may move, and for how long.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// What is being done, for people.
    pub stage: &'static str,
    /// Most iterations.
    pub iterations: usize,
    /// Unknowns that stay where they are.
    pub locked: &'a [usize],
    /// Fall of the cost in one iteration, as a share of it, that is not worth another.
    pub enough: f64,
}

/// The point at unknowns `x` with each segment's own unknowns fitted.
///
/// # Errors
/// [`SimError`] if the model makes no sense at `x`.
pub fn settle(
    problem: &Problem,
    x: &[f64],
    segments: &[Segment],
    used: &[bool],
    huber: Huber,
    rounds: usize,
) -> Result<Point, SimError> {
    let starts = segments.iter().map(|s| vec![s.locals.clone()]).collect();
    at(problem, x, (segments, used), starts, huber, rounds)
}

fn at(
    problem: &Problem,
    x: &[f64],
    (segments, used): (&[Segment], &[bool]),
    starts: Vec<Vec<Vec<f64>>>,
    huber: Huber,
    rounds: usize,
) -> Result<Point, SimError> {
    let simulator = problem.simulator(x)?;
    let states = problem.states(&simulator, segments);
    let fitted: Vec<(Vec<f64>, f64)> = segments
        .par_iter()
        .zip(starts)
        .enumerate()
        .map(|(i, (segment, starts))| {
            if !used[i] {
                return (segment.locals.clone(), 0.0);
            }
            let nuisances = problem.nuisances_of(x, segment.recording);
            let cost = |locals: &[f64]| {
                problem.cost(segment, &states[i], &simulator, &nuisances, locals, huber)
            };
            let start = if starts.len() < 2 {
                starts.into_iter().next()
            } else {
                let weighed = starts.into_iter().map(|s| (cost(&s), s));
                weighed.min_by(|a, b| a.0.total_cmp(&b.0)).map(|w| w.1)
            };
            let start = start.unwrap_or_else(|| segment.locals.clone());
            problem.refine(
                segment, &states[i], &simulator, &nuisances, start, huber, rounds,
            )
        })
        .collect();
    let mut point = Point {
        x: x.to_vec(),
        segments: segments.to_vec(),
        alive: Vec::with_capacity(segments.len()),
        used: used.to_vec(),
        cost: problem.priors(x).iter().map(|p| huber.cost(p.2)).sum(),
        rows: 0,
    };
    let own = point.segments.iter_mut().zip(fitted).zip(used);
    for ((segment, (locals, cost)), used) in own {
        segment.locals = locals;
        point.alive.push(cost.is_finite());
        if !used {
            continue;
        }
        let rows = problem.rows(segment).len();
        point.rows += rows;
        // A segment that cannot be simulated counts as badly off: it must not pay.
        point.cost += if cost.is_finite() {
            cost
        } else {
            rows as f64 * huber.cost(1e3)
        };
    }
    Ok(point)
}

/// Scale of each segment's residuals in units of the noise: what 68 % of them stay below.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn scales(problem: &Problem, point: &Point) -> Result<Vec<f64>, SimError> {
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&simulator, &point.segments);
    let scale = |(i, segment): (usize, &Segment)| {
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        let mut stretcher = crate::sim::Stretcher::new(&simulator);
        let mut r = Vec::new();
        let locals = &segment.locals;
        if !problem.evaluate(
            segment,
            &states[i],
            &mut stretcher,
            &nuisances,
            locals,
            &mut r,
        ) {
            return f64::INFINITY;
        }
        r.iter_mut().for_each(|r| *r = r.abs());
        crate::recording::quantile_in_place(&mut r, 0.683)
    };
    Ok(point.segments.par_iter().enumerate().map(scale).collect())
}

/// Threshold of the loss that suits the present residuals.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn threshold(problem: &Problem, point: &Point) -> Result<Huber, SimError> {
    let all = scales(problem, point)?;
    let own = all.into_iter().zip(&point.used);
    let mut finite: Vec<f64> = own
        .filter(|(s, used)| **used && s.is_finite())
        .map(|(s, _)| s)
        .collect();
    let scale = crate::recording::quantile_in_place(&mut finite, 0.75);
    Ok(Huber(
        THRESHOLD
            * if scale.is_finite() {
                scale.max(1.0)
            } else {
                1.0
            },
    ))
}

/// Normal equations of all segments: matrix and gradient.
pub fn normal_equations(
    problem: &Problem,
    x: &[f64],
    reduced: &[Option<Reduced>],
    huber: Huber,
) -> (DMatrix<f64>, DVector<f64>) {
    let n = problem.unknowns();
    let mut normal = DMatrix::zeros(n, n);
    let mut gradient = DVector::zeros(n);
    // One after the other, so that rounding is the same on any number of cores.
    for r in reduced.iter().flatten() {
        let (h, g) = (r.s.tr_mul(&r.s), r.s.tr_mul(&r.c));
        for (i, &ci) in r.columns.iter().enumerate() {
            gradient[ci] += g[i];
            for (j, &cj) in r.columns.iter().enumerate() {
                normal[(ci, cj)] += h[(i, j)];
            }
        }
    }
    for (i, slope, value) in problem.priors(x) {
        let w = huber.root_weight(value).powi(2);
        normal[(i, i)] += w * slope * slope;
        gradient[i] += w * slope * value;
    }
    (normal, gradient)
}

/// Improves `point` as planned.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the start.
pub fn improve(
    problem: &Problem,
    mut point: Point,
    plan: &Plan<'_>,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Point, SimError> {
    let n = problem.unknowns();
    // Damping after Nielsen (1999): it follows how well the step was foreseen.
    let (mut damping, mut growth) = (1e-4, 2.0);
    let mut huber = threshold(problem, &point)?;
    point = settle(problem, &point.x, &point.segments, &point.used, huber, 1)?;
    for _ in 0..plan.iterations {
        if control.cancelled() {
            break;
        }
        let reduced = problem.linearise(&point.x, &point.segments, &point.used, huber)?;
        let (normal, gradient) = normal_equations(problem, &point.x, &reduced, huber);
        let mut accepted = None;
        let mut converged = false;
        for _ in 0..7 {
            let Some(step) =
                bounded_step(problem, &point.x, &normal, &gradient, damping, plan.locked)
            else {
                damping *= growth;
                growth *= 2.0;
                continue;
            };
            let there: Vec<f64> = (0..n).map(|i| point.x[i] + step[i]).collect();
            let change = DVector::from_column_slice(&step);
            let size = (&change.transpose() * &normal * &change)[(0, 0)];
            let starts = point
                .segments
                .iter()
                .zip(&reduced)
                .map(|(segment, r)| {
                    let Some(changes) = r.as_ref().and_then(|r| r.local_changes(&step)) else {
                        return vec![segment.locals.clone()];
                    };
                    let moved = |change: &DVector<f64>| {
                        let all = segment.locals.iter().zip(change.iter());
                        all.map(|(x, d)| x + d).collect()
                    };
                    changes.iter().map(moved).collect()
                })
                .collect();
            let whole = (&point.segments[..], &point.used[..]);
            let trial = at(problem, &there, whole, starts, huber, 1);
            if let Ok(trial) = trial
                && trial.cost < point.cost
            {
                let gain = point.cost - trial.cost;
                converged = size < SETTLED || gain < SETTLED.max(plan.enough * point.cost);
                accepted = Some(trial);
                let foreseen = -2.0 * gradient.dot(&change) - size;
                let ratio = (gain / foreseen.max(1e-12)).min(1.0);
                damping = (damping * (1.0 - (2.0 * ratio - 1.0).powi(3)).max(0.1)).max(1e-9);
                growth = 2.0;
                break;
            }
            if size < SETTLED {
                converged = true;
                break;
            }
            damping = (growth * damping).max(1e-8);
            growth *= 2.0;
        }
        clock.done += 1;
        let moved = accepted.is_some();
        if let Some(trial) = accepted {
            point = trial;
        }
        report(problem, &point, plan, control, clock);
        let finer = threshold(problem, &point)?;
        if finer.0 < 0.9 * huber.0 {
            huber = finer;
            point = settle(problem, &point.x, &point.segments, &point.used, huber, 1)?;
        } else if converged || !moved {
            break;
        }
    }
    Ok(point)
}

fn report(problem: &Problem, point: &Point, plan: &Plan<'_>, control: &Control<'_>, clock: &Clock) {
    let each = clock.started.elapsed().div_f64(clock.done.max(1) as f64);
    let left = clock.expected.saturating_sub(clock.done);
    (control.progress)(&Progress {
        stage: plan.stage,
        iteration: clock.done,
        expected: clock.expected.max(clock.done),
        misfit: (point.cost / point.rows.max(1) as f64).sqrt(),
        values: problem.space.values(&point.x),
        remaining: each.mul_f64(left as f64),
    });
}

/// Damped step within the bounds; a parameter that would leave them stays at its bound,
/// one that would go far goes a part of the way, and the others make the best of it.
fn bounded_step(
    problem: &Problem,
    x: &[f64],
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
    locked: &[usize],
) -> Option<Vec<f64>> {
    let n = x.len();
    let parameters = problem.space.len();
    let mut fixed = vec![false; n];
    locked.iter().for_each(|&i| fixed[i] = true);
    let mut step = vec![0.0; n];
    // Each round can only fix more unknowns.
    for _ in 0..=parameters {
        let free: Vec<usize> = (0..n).filter(|&i| !fixed[i]).collect();
        let k = free.len();
        let mut a = DMatrix::from_fn(k, k, |i, j| normal[(free[i], free[j])]);
        let mut b = DVector::from_fn(k, |i, _| -gradient[free[i]]);
        for (i, _) in free.iter().enumerate() {
            // What fixed unknowns have moved is taken over by the others.
            for j in (0..n).filter(|&j| fixed[j]) {
                b[i] -= normal[(free[i], j)] * step[j];
            }
        }
        for i in 0..k {
            a[(i, i)] += damping * a[(i, i)] + 1e-9;
        }
        let solved = a.cholesky()?.solve(&b);
        let mut violated = false;
        for (i, &at) in free.iter().enumerate() {
            let mut d = solved[i];
            if at < parameters {
                let entry = &problem.space.entries[at];
                let near = d.clamp(-LARGEST, LARGEST);
                let bounded = (x[at] + near).clamp(entry.low, entry.high) - x[at];
                if bounded != d {
                    fixed[at] = true;
                    violated = true;
                    d = bounded;
                }
            }
            step[at] = d;
        }
        if !violated {
            break;
        }
    }
    step.iter().all(|d| d.is_finite()).then_some(step)
}
