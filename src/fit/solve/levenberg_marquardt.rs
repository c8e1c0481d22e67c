//! Bounded Levenberg-Marquardt over parameters and nuisances (Levenberg 1944, Marquardt 1963).
//! Each segment's own unknowns are eliminated from the normal equations, and follow each step.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use nalgebra::DVector;

use super::normal_equations::{bounded_step, normal_equations};
use super::point::{Point, at, starts_near, threshold};
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::sim::SimError;

/// A step is small if it is below this share of the squared standard error.
const CONVERGED_STEP_SHARE: f64 = 1e-2;

/// Cost per row up to which segments may be corrected by their linearization.
const MAX_CORRECTION_COST_PER_ROW: f64 = 4.0;

/// Progress of a fit.
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
    /// Estimated time left.
    pub remaining: Duration,
    /// Doubts about the recordings from the checks before the search, as sentences.
    pub doubts: Arc<[String]>,
}

/// Cancel flag and progress callback of a fit.
///
/// # Examples
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
///
/// use impactscope::fit::Control;
///
/// let cancel = AtomicBool::new(false);
/// let control = Control { cancel: &cancel, progress: &|_| {} };
/// assert!(!control.cancelled());
/// cancel.store(true, Ordering::Relaxed);
/// assert!(control.cancelled());
/// ```
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

/// Counts iterations for the estimate of the time left. Clones count together.
#[derive(Debug, Clone)]
pub struct Clock {
    started: Instant,
    done: Arc<AtomicUsize>,
    /// Iterations expected in all.
    pub expected: usize,
    /// What is reported with the progress: see [`Progress::doubts`].
    pub doubts: Arc<[String]>,
}

impl Clock {
    /// Started now.
    pub fn new(expected: usize) -> Self {
        Self {
            started: Instant::now(),
            done: Arc::default(),
            expected,
            doubts: Arc::default(),
        }
    }

    /// Iterations done so far.
    #[must_use]
    pub fn done(&self) -> usize {
        self.done.load(Ordering::Relaxed)
    }

    /// Reports progress without counting an iteration.
    pub(crate) fn report(
        &self,
        stage: &'static str,
        problem: &Problem,
        point: &Point,
        control: &Control<'_>,
    ) {
        let done = self.done();
        let each = self.started.elapsed().div_f64(done.max(1) as f64);
        let left = match self.expected.checked_sub(done) {
            Some(left) if left > 0 => left,
            // A fit that takes longer than expected is extended.
            _ => done / 8,
        };
        (control.progress)(&Progress {
            stage,
            iteration: done,
            expected: self.expected.max(done),
            misfit: (point.cost / point.rows.max(1) as f64).sqrt(),
            values: problem.space.values(&point.x),
            remaining: each.mul_f64(left as f64),
            doubts: Arc::clone(&self.doubts),
        });
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
    /// Relative fall of the cost in one iteration that ends the search.
    pub enough: f64,
}

/// Improves `point` as planned, under the loss that suits its residuals.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the start.
pub fn improve(
    problem: &Problem,
    point: Point,
    plan: &Plan<'_>,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Point, SimError> {
    descend(problem, point, plan, None, control, clock)
}

/// Improves `point` as planned under the loss `huber` throughout, so that costs of
/// different points can be compared.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the start.
pub fn improve_under(
    problem: &Problem,
    point: Point,
    plan: &Plan<'_>,
    huber: Huber,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Point, SimError> {
    descend(problem, point, plan, Some(huber), control, clock)
}

fn descend(
    problem: &Problem,
    mut point: Point,
    plan: &Plan<'_>,
    fixed: Option<Huber>,
    control: &Control<'_>,
    clock: &mut Clock,
) -> Result<Point, SimError> {
    let n = problem.unknowns();
    if control.cancelled() {
        return Ok(point);
    }
    // Damping after Nielsen (1999): it follows the ratio of actual and predicted fall of the cost.
    let (mut damping, mut growth) = (1e-4, 2.0);
    let mut huber = fixed.map_or_else(|| threshold(problem, &point), Ok)?;
    point = point.under(problem, huber)?;
    for _ in 0..plan.iterations {
        if control.cancelled() {
            break;
        }
        let reduced =
            problem.linearize(&point.x, &point.segments, &point.used, huber, plan.locked)?;
        let (normal, gradient) = normal_equations(problem, &point.x, &reduced, huber);
        // Far from the minimum, a linearization is misleading.
        let near = point.cost < MAX_CORRECTION_COST_PER_ROW * point.rows as f64;
        let mut accepted = None;
        let mut converged = false;
        let (mut tries, mut predicted) = (0, 0.0);
        for _ in 0..7 {
            tries += 1;
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
            let starts = starts_near(&point.segments, &reduced, &step, near);
            let whole = (&point.segments[..], &point.used[..]);
            let trial = at(problem, &there, whole, starts, (huber, 1), point.cost);
            if let Ok(Some(trial)) = trial
                && trial.cost < point.cost
            {
                let gain = point.cost - trial.cost;
                converged = size < CONVERGED_STEP_SHARE
                    || gain < CONVERGED_STEP_SHARE.max(plan.enough * point.cost);
                accepted = Some(trial);
                let foreseen = -2.0 * gradient.dot(&change) - size;
                predicted = foreseen;
                let ratio = (gain / foreseen.max(1e-12)).min(1.0);
                damping = (damping * (1.0 - (2.0 * ratio - 1.0).powi(3)).max(0.1)).max(1e-9);
                growth = 2.0;
                break;
            }
            if size < CONVERGED_STEP_SHARE {
                converged = true;
                break;
            }
            damping = (growth * damping).max(1e-8);
            growth *= 2.0;
        }
        clock.done.fetch_add(1, Ordering::Relaxed);
        let moved = accepted.is_some();
        if let Some(trial) = accepted {
            point = trial;
        }
        log::trace!(
            "cost {:.3} at damping {damping:.1e}, predicted {predicted:.3} in {tries}, moved {moved}, converged {converged}",
            point.cost
        );
        clock.report(plan.stage, problem, &point, control);
        let finer = fixed.unwrap_or_else(|| point.threshold());
        if finer.0 < 0.9 * huber.0 {
            huber = finer;
            point = point.under(problem, huber)?;
        } else if converged || !moved {
            break;
        }
    }
    Ok(point)
}
