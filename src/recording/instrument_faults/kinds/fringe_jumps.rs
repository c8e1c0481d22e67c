//! Steps of a reading by multiples of one size inside smooth motion, as when an interferometer
//! miscounts a fringe.
//!
//! Left and right of the step the motion goes on with the same speed: parabolas through the samples
//! on either side lie a step apart and have one slope. At an impact they meet and have two.

use crate::recording::channel::Channel;
use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::signal::{Found, Signal};
use crate::recording::instrument_faults::thresholds::{
    FRINGE_ALIKE, FRINGE_MAX_MISFIT, FRINGE_MAX_MULTIPLE, FRINGE_MAX_TURN, FRINGE_MIN_AGREEMENT,
    FRINGE_MIN_PROMINENCE, FRINGE_MIN_SPEED_SIGMAS, FRINGE_SIDE_SAMPLES, FRINGE_SIGMAS,
    FRINGE_SMALLER_SHARE, FRINGE_USUAL_STEPS, LONE_JUMP_FACTOR, LONE_JUMP_PROMINENCE,
    MIN_NOISE_SHARE_OF_SPAN,
};
use crate::recording::statistics::{median_in_place, quantile_in_place};

/// A step between sample `at` and the next.
struct Jump {
    at: usize,
    /// With its sign.
    size: f64,
    /// Speed there, per sample.
    speed: f64,
    /// Size over what steps differ from their neighbours around it.
    prominence: f64,
}

/// Fringe jumps. The size is that of which all are multiples. What follows is shifted, and not
/// unusable by itself.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    if signal.channel == Channel::Voltage {
        return None;
    }
    let sigma = signal.sigma();
    // Steps of the recorder are no jumps.
    let lattice = signal.lattice().min(signal.span());
    let rounding = MIN_NOISE_SHARE_OF_SPAN * signal.span();
    let values = &signal.values;
    let least = (FRINGE_SIGMAS * sigma.max(rounding).max(lattice / 12f64.sqrt()))
        .max(FRINGE_USUAL_STEPS * usual_steps(values));
    let smaller = FRINGE_SMALLER_SHARE * least;
    let mut jumps: Vec<Jump> = Vec::new();
    for at in FRINGE_SIDE_SAMPLES - 1..values.len().saturating_sub(FRINGE_SIDE_SAMPLES) {
        let near = values[at + 1] - values[at];
        // Cheap before dear.
        if near.is_nan() || near.abs() <= 0.5 * smaller || signal.near_edge[at] {
            continue;
        }
        let Some(found) = jump_at(values, at, sigma).filter(|j| j.size.abs() > smaller) else {
            continue;
        };
        match jumps.last_mut() {
            Some(last) if at - last.at < FRINGE_SIDE_SAMPLES => {
                if found.size.abs() > last.size.abs() {
                    *last = found;
                }
            }
            _ => jumps.push(found),
        }
    }
    let found = jumps.len();
    jumps.retain(|j| j.size.abs() > least);
    // Noise with rare large errors has more of those that just miss the size.
    if found > 2 * jumps.len() {
        return None;
    }
    let size = common_size(&jumps, sigma, LONE_JUMP_FACTOR * least)?;
    let places: Vec<_> = jumps.iter().map(|j| j.at..j.at + 2).collect();
    Some(Found {
        fault: signal.fault(FaultKind::FringeJumps, size, &places)?,
        unusable: Vec::new(),
    })
}

/// The step between sample `at` and the next, if the motion is smooth on both sides and goes on as
/// before.
fn jump_at(values: &[f64], at: usize, sigma: f64) -> Option<Jump> {
    let left = values[at + 1 - FRINGE_SIDE_SAMPLES..=at].iter().rev();
    let right = values[at + 1..=at + FRINGE_SIDE_SAMPLES].iter();
    let (a, b) = (Parabola::of(left), Parabola::of(right));
    // Towards the step on the left side, away from it on the right.
    let (slope_before, slope_after) = (-a.slope, b.slope);
    let size = b.start - a.start;
    let misfit = FRINGE_MAX_MISFIT * size.abs() + 2.0 * sigma;
    let turn = FRINGE_MAX_TURN * size.abs() + 2.0 * sigma;
    // False where a sample is missing.
    let smooth = a.rms <= misfit && b.rms <= misfit && (slope_after - slope_before).abs() <= turn;
    // Parabolas miss the third derivative of a fast motion, which is no step.
    let beyond = beyond_neighbours(values, at);
    let prominence = beyond.abs() / usual_beyond(values, at);
    let sudden = (beyond - size).abs() <= FRINGE_MAX_TURN * size.abs() + 3.0 * sigma
        && prominence > FRINGE_MIN_PROMINENCE;
    (smooth && sudden).then_some(Jump {
        at,
        size,
        speed: 0.5 * (slope_before + slope_after),
        prominence,
    })
}

/// A parabola through samples that follow one another at 1/2, 3/2, ... samples from its start.
struct Parabola {
    start: f64,
    slope: f64,
    /// Root mean square of what it leaves, with three degrees of freedom fewer.
    rms: f64,
}

impl Parabola {
    fn of<'v>(values: impl Iterator<Item = &'v f64> + Clone) -> Self {
        // Legendre's polynomials on the samples, orthogonal by construction.
        let n = FRINGE_SIDE_SAMPLES as f64;
        let middle = 0.5 * n;
        let second = (n * n - 1.0) / 12.0;
        let (mut p0, mut p1, mut p2) = (0.0, 0.0, 0.0);
        let (mut n1, mut n2) = (0.0, 0.0);
        let place = |i: usize| i as f64 + 0.5 - middle;
        for (i, value) in values.clone().enumerate() {
            let u = place(i);
            let q = u * u - second;
            p0 += value / n;
            p1 += value * u;
            p2 += value * q;
            n1 += u * u;
            n2 += q * q;
        }
        let (b, c) = (p1 / n1, p2 / n2);
        let at = |u: f64| p0 + b * u + c * (u * u - second);
        let square = |(i, value): (usize, &f64)| (value - at(place(i))).powi(2);
        let left: f64 = values.enumerate().map(square).sum();
        Self {
            start: at(-middle),
            slope: b - 2.0 * c * middle,
            rms: (left / (n - 3.0)).sqrt(),
        }
    }
}

/// How far the step from sample `at` to the next is from the mean of the steps before and after.
fn beyond_neighbours(values: &[f64], at: usize) -> f64 {
    let step = |i: usize| values[i + 1] - values[i];
    step(at) - 0.5 * (step(at - 1) + step(at + 1))
}

/// The same that a tenth of the samples exceed: noise that is not the same everywhere shows in it.
/// NaN where nothing is known.
fn usual_steps(values: &[f64]) -> f64 {
    let all = 1..values.len().saturating_sub(2);
    let mut beyond: Vec<f64> = all
        .map(|at| beyond_neighbours(values, at).abs())
        .filter(|b| b.is_finite())
        .collect();
    quantile_in_place(&mut beyond, 0.9)
}

/// The same around, apart from where the step itself counts: what the motion does there.
fn usual_beyond(values: &[f64], at: usize) -> f64 {
    let from = (at + 1 - FRINGE_SIDE_SAMPLES).max(1);
    let to = (at + FRINGE_SIDE_SAMPLES).min(values.len() - 2);
    let others = (from..to).filter(|i| i.abs_diff(at) > 1);
    others
        .map(|i| beyond_neighbours(values, i).abs())
        .fold(0.0, f64::max)
}

/// The size of which nearly all jumps are multiples; two must be equal, and a single one exceed
/// `lone`. One of them at least must happen while the mass moves: a mass at rest on a ground that
/// steps is no fault.
fn common_size(jumps: &[Jump], sigma: f64, lone: f64) -> Option<f64> {
    let smallest = jumps.iter().map(|j| j.size.abs()).reduce(f64::min)?;
    let moving = |j: &&Jump| j.speed.abs() > FRINGE_MIN_SPEED_SIGMAS * sigma;
    if jumps.len() == 1 {
        let stands_out = |j: &Jump| moving(&j) && j.prominence > LONE_JUMP_PROMINENCE;
        let shows = smallest > lone && jumps.iter().all(stands_out);
        return shows.then_some(smallest);
    }
    let mut alike: Vec<f64> = jumps
        .iter()
        .map(|j| j.size.abs())
        .filter(|s| *s <= (1.0 + FRINGE_ALIKE) * smallest + 3.0 * sigma)
        .collect();
    let unit = median_in_place(&mut alike);
    let is_multiple = |j: &&Jump| {
        let times = j.size.abs() / unit;
        times < FRINGE_MAX_MULTIPLE + 0.5
            && (times - times.round()).abs() <= FRINGE_ALIKE + 3.0 * sigma / unit
    };
    let fitting = jumps.iter().filter(is_multiple).count();
    let equal = alike.len() == jumps.len();
    let shown = equal || jumps.len() > 2;
    let moves = jumps.iter().any(|j| moving(&j));
    let agree = fitting as f64 >= FRINGE_MIN_AGREEMENT * jumps.len() as f64;
    // Each is as uncertain as the others: a large multiple says most about the size.
    let (mut along, mut squares) = (0.0, 0.0);
    for jump in jumps.iter().filter(is_multiple) {
        let times = (jump.size.abs() / unit).round();
        along += times * jump.size.abs();
        squares += times * times;
    }
    (shown && moves && agree).then_some(along / squares)
}
