//! Unknowns with their cost, each segment's own unknowns fitted.

use rayon::prelude::*;

use crate::fit::problem::Problem;
use crate::fit::robust::Huber;
use crate::fit::segment::Segment;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, Stretcher};

/// Threshold of the robust loss in units of the noise.
const THRESHOLD: f64 = 3.0;

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

pub(super) fn at(
    problem: &Problem,
    x: &[f64],
    (segments, used): (&[Segment], &[bool]),
    starts: Vec<Vec<Vec<f64>>>,
    huber: Huber,
    rounds: usize,
) -> Result<Point, SimError> {
    let simulator = problem.simulator(x)?;
    let states = problem.states(x, &simulator, segments);
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
    let scale = |r: Option<Vec<f64>>| {
        r.map_or(f64::INFINITY, |mut r| {
            r.iter_mut().for_each(|r| *r = r.abs());
            quantile_in_place(&mut r, 0.683)
        })
    };
    let all = residuals_at(problem, point, |_, _| true)?;
    Ok(all.into_iter().map(scale).collect())
}

/// Residuals of those segments at a point that are asked for, by index and segment, in units of
/// the noise; `None` for the others, and where one cannot be simulated.
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
    let all = scales(problem, point)?;
    let own = all.into_iter().zip(&point.used);
    let mut finite: Vec<f64> = own
        .filter(|(s, used)| **used && s.is_finite())
        .map(|(s, _)| s)
        .collect();
    let scale = quantile_in_place(&mut finite, 0.75);
    Ok(Huber(
        THRESHOLD
            * if scale.is_finite() {
                scale.max(1.0)
            } else {
                1.0
            },
    ))
}
