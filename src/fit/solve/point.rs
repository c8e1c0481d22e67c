//! A point of the search: unknowns with their cost, each segment's own unknowns fitted.

use std::sync::{Mutex, PoisonError};

use nalgebra::DVector;
use rayon::prelude::*;

use crate::fit::problem::huber::Huber;
use crate::fit::problem::{MAX_REUSE_COST_PER_ROW, Problem, Reduced};
use crate::fit::segment::Segment;
use crate::fit::thresholds::HUBER_THRESHOLD;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, Stretcher};

/// Relative difference of sums of costs that are taken in another order.
const COST_ROUNDING_SHARE: f64 = 1e-9;

/// Unknowns with their cost.
#[derive(Debug, Clone)]
pub struct Point {
    /// Coordinates of the parameters, then the nuisances.
    pub x: Vec<f64>,
    /// The segments with their own unknowns.
    pub segments: Vec<Segment>,
    /// Whether a segment could be simulated.
    pub alive: Vec<bool>,
    /// Whether a segment is used.
    pub used: Vec<bool>,
    /// Scale of each segment's residuals where they were last fitted: 68 % of them are below it. In
    /// units of the noise; infinite for none.
    scales: Vec<f64>,
    /// Robust cost.
    pub cost: f64,
    /// Rows in all.
    pub rows: usize,
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
    let starts = segments.iter().map(|s| Start::Here(s.locals.clone()));
    let starts = starts.collect();
    let any = f64::INFINITY;
    let point = at(problem, x, (segments, used), starts, (huber, rounds), any)?;
    Ok(point.expect("no cost is beyond infinity"))
}

/// The same at unknowns `x` near `point`, at which the segments are `reduced`.
///
/// # Errors
/// [`SimError`] if the model makes no sense at `x`.
pub fn settle_near(
    problem: &Problem,
    x: &[f64],
    (point, reduced): (&Point, &[Option<Reduced>]),
    huber: Huber,
    rounds: usize,
) -> Result<Point, SimError> {
    let step: Vec<f64> = x.iter().zip(&point.x).map(|(x, from)| x - from).collect();
    let starts = starts_near(&point.segments, reduced, &step, true);
    let whole = (&point.segments[..], &point.used[..]);
    let any = f64::INFINITY;
    let point = at(problem, x, whole, starts, (huber, rounds), any)?;
    Ok(point.expect("no cost is beyond infinity"))
}

/// Starts of the segments' own unknowns for a `step` of all others. Segments that are `reduced` may
/// be corrected by their linearization if the step is `near`.
pub(super) fn starts_near<'a>(
    segments: &[Segment],
    reduced: &'a [Option<Reduced>],
    step: &[f64],
    near: bool,
) -> Vec<Start<'a>> {
    let start = |(segment, reduced): (&Segment, &'a Option<Reduced>)| {
        let changes = reduced
            .as_ref()
            .and_then(|r| Some((r, r.local_changes(step)?)));
        let Some((reduced, changes)) = changes else {
            return Start::Here(segment.locals.clone());
        };
        let moved = |change: DVector<f64>| {
            let all = segment.locals.iter().zip(change.iter());
            all.map(|(x, d)| x + d).collect()
        };
        Start::Near(changes.map(moved), Some(reduced).filter(|_| near))
    };
    segments.iter().zip(reduced).map(start).collect()
}

/// Where the search for a segment's own unknowns starts.
pub(super) enum Start<'a> {
    /// At these unknowns, without a linearization.
    Here(Vec<f64>),
    /// At one of these, with a linearization so near that it may correct them.
    Near([Vec<f64>; 2], Option<&'a Reduced>),
}

/// As [`settle`], with the segments' own unknowns begun at `starts`. `None` as soon as the cost is
/// beyond `most`: far from the minimum, motions take long to simulate.
pub(super) fn at(
    problem: &Problem,
    x: &[f64],
    (segments, used): (&[Segment], &[bool]),
    starts: Vec<Start<'_>>,
    (huber, rounds): (Huber, usize),
    most: f64,
) -> Result<Option<Point>, SimError> {
    let simulator = problem.simulator(x)?;
    let states = problem.states(x, &simulator, segments);
    let priors = problem.prior_cost(x, huber);
    // A segment that cannot be simulated counts as a bad fit, so that it does not pay.
    let cost_of = |cost: f64, segment: &Segment| {
        if cost.is_finite() {
            cost
        } else {
            problem.rows(segment).len() as f64 * huber.cost(1e3)
        }
    };
    // The order of the segments must not matter, not even by rounding.
    let (so_far, beyond) = (Mutex::new(priors), most + COST_ROUNDING_SHARE * most.abs());
    let fitted: Option<Vec<(Vec<f64>, f64, f64)>> = segments
        .par_iter()
        .zip(starts)
        .enumerate()
        .map(|(i, (segment, start))| {
            if !used[i] {
                return Some((segment.locals.clone(), 0.0, f64::INFINITY));
            }
            let (near, state) = (problem.nuisances_of(x, segment.recording), &states[i]);
            let refined = match start {
                Start::Here(first) => {
                    problem.refine(segment, state, &simulator, &near, first, huber, rounds)
                }
                Start::Near(starts, by) => {
                    let loss = (huber, rounds);
                    problem.correct(segment, state, &simulator, &near, starts, by, loss)
                }
            };
            {
                let mut sum = so_far.lock().unwrap_or_else(PoisonError::into_inner);
                *sum += cost_of(refined.cost, segment);
                if *sum > beyond {
                    return None;
                }
            }
            let scale = scale_of(refined.residuals);
            Some((refined.locals, refined.cost, scale))
        })
        .collect();
    let Some(fitted) = fitted else {
        return Ok(None);
    };
    let mut point = Point {
        x: x.to_vec(),
        segments: segments.to_vec(),
        alive: Vec::with_capacity(segments.len()),
        scales: fitted.iter().map(|f| f.2).collect(),
        used: used.to_vec(),
        cost: priors,
        rows: 0,
    };
    let own = point.segments.iter_mut().zip(fitted).zip(used);
    for ((segment, (locals, cost, _)), used) in own {
        segment.locals = locals;
        point.alive.push(cost.is_finite());
        if !used {
            continue;
        }
        point.rows += problem.rows(segment).len();
        point.cost += cost_of(cost, segment);
    }
    let beyond = point.cost > most;
    Ok((!beyond).then_some(point))
}

/// The value that 68 % of the residuals stay below; infinite for none.
fn scale_of(mut residuals: Vec<f64>) -> f64 {
    if residuals.is_empty() {
        return f64::INFINITY;
    }
    residuals.iter_mut().for_each(|r| *r = r.abs());
    quantile_in_place(&mut residuals, 0.683)
}

/// Residuals of the segments chosen by index and segment, in units of the noise; `None` for the
/// others, and for one that cannot be simulated.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn residuals_at(
    problem: &Problem,
    point: &Point,
    which: impl Fn(usize, &Segment) -> bool + Sync,
) -> Result<Vec<Option<Vec<f64>>>, SimError> {
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let one = |(i, segment): (usize, &Segment)| {
        if !which(i, segment) {
            return None;
        }
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        let mut stretcher = Stretcher::new(&simulator);
        let (locals, states, mut r) = (&segment.locals, &states[i], Vec::new());
        problem
            .evaluate(segment, states, &mut stretcher, &nuisances, locals, &mut r)
            .then_some(r)
    };
    Ok(point.segments.par_iter().enumerate().map(one).collect())
}

/// Threshold of the loss that suits the present residuals.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn threshold(problem: &Problem, point: &Point) -> Result<Huber, SimError> {
    let all = residuals_at(problem, point, |_, _| true)?;
    let scales: Vec<f64> = all
        .into_iter()
        .map(|r| r.map_or(f64::INFINITY, scale_of))
        .collect();
    Ok(threshold_of(&scales, &point.used))
}

/// Threshold of the loss that suits residuals of such scales.
fn threshold_of(scales: &[f64], used: &[bool]) -> Huber {
    let own = scales.iter().zip(used);
    let mut finite: Vec<f64> = own
        .filter(|(s, used)| **used && s.is_finite())
        .map(|(s, _)| *s)
        .collect();
    let scale = quantile_in_place(&mut finite, 0.75);
    Huber(
        HUBER_THRESHOLD
            * if scale.is_finite() {
                scale.max(1.0)
            } else {
                1.0
            },
    )
}

impl Point {
    /// Unknowns `x` and all of `segments`, nothing fitted yet.
    pub fn unfitted(x: Vec<f64>, segments: &[Segment]) -> Self {
        Self {
            x,
            segments: segments.to_vec(),
            alive: vec![true; segments.len()],
            used: vec![true; segments.len()],
            scales: vec![f64::INFINITY; segments.len()],
            cost: f64::INFINITY,
            rows: 0,
        }
    }

    /// The same point under another loss. Close to the minimum, segments are near their best under
    /// any loss, and each step brings them along. Far from it, a step must not gain from that
    /// difference.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense there.
    pub(super) fn under(&self, problem: &Problem, huber: Huber) -> Result<Self, SimError> {
        let close = self.cost < MAX_REUSE_COST_PER_ROW * self.rows as f64;
        let rounds = usize::from(!close);
        settle(problem, &self.x, &self.segments, &self.used, huber, rounds)
    }

    /// Threshold of the loss that suits the residuals as they were when the point was made.
    pub(super) fn threshold(&self) -> Huber {
        threshold_of(&self.scales, &self.used)
    }
}
