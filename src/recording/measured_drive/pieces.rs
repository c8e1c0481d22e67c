//! What was found as smooth pieces with branches of the hysteresis loop, and as edges.

use std::ops::Range;

use rayon::prelude::*;

use super::DriveEdge;
use super::knots::{Knot, Knots};
use super::lines::jump_blocks;
use super::samples::{Samples, Span};
use super::sinusoid::Sinusoids;
use super::smooth::turn::refine_turn;
use super::smooth::{Cubic, smooth};
use crate::model::drive::{Segment, Shape};
use crate::model::piezo::Branch;

/// Least standard deviation of an edge in sampling intervals: what clocks differ.
const MIN_EDGE_SIGMA_INTERVALS: f64 = 0.01;
/// Reversals of a smoothed voltage below this many of its standard deviations are noise.
const REVERSAL_SIGMAS: f64 = 8.0;
/// Standard deviations of the spline's turn by which a better estimate may move it, two
/// intervals in any case.
const MAX_TURN_CHANGE_SIGMAS: f64 = 8.0;
/// Pieces in which a turn of the fastest of several sines is written.
const PIECES_PER_TURN: f64 = 100.0;
/// Standard deviations an edge may lie from its estimate.
const EDGE_REACH_SIGMAS: f64 = 4.0;

/// A piece's direction from the change of the voltage over it.
fn branch_of(change: f64, last: Branch) -> Branch {
    if change > 0.0 {
        Branch::Rising
    } else if change < 0.0 {
        Branch::Falling
    } else {
        last
    }
}

/// A drive that starts on a level counts as having just stepped there.
fn first_branch(voltage: f64) -> Branch {
    if voltage >= 0.0 {
        Branch::Rising
    } else {
        Branch::Falling
    }
}

fn hold(start: f64, end: f64, voltage: f64, branch: Branch) -> Segment {
    Segment {
        start,
        end,
        shape: Shape::Constant { voltage },
        branch,
    }
}

/// The samples as knots.
pub fn points(samples: &Samples<'_>) -> Knots {
    let knot = |(&time, &volts): (&f64, &f64)| Knot {
        time,
        bounds: (time, time),
        before: volts,
        after: volts,
        sigma: samples.sigma,
    };
    Knots(samples.time.iter().zip(samples.volts).map(knot).collect())
}

/// Pieces and edges of straight lines.
pub fn of_knots(span: Span, knots: &Knots) -> (Vec<Segment>, Vec<DriveEdge>) {
    let knots = &knots.0;
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    let mut pieces = Vec::with_capacity(knots.len() + 1);
    let mut edges = Vec::new();
    let mut branch = first_branch(first.after);
    for (i, pair) in knots.windows(2).enumerate() {
        let (a, b) = (&pair[0], &pair[1]);
        let before = branch;
        let level = a.after == b.before;
        branch = branch_of(
            if level {
                if i > 0 { a.after - a.before } else { 0.0 }
            } else {
                b.before - a.after
            },
            branch,
        );
        if i == 0 {
            pieces.push(hold(f64::NEG_INFINITY, a.time, a.after, branch));
        } else if a.jumps() || branch != before {
            edges.push(edge(span.interval, pieces.len(), a.time, a.bounds));
        }
        pieces.push(Segment {
            start: a.time,
            end: b.time,
            shape: if level {
                Shape::Constant { voltage: a.after }
            } else {
                Shape::Line {
                    voltage: a.after,
                    slope: (b.before - a.after) / (b.time - a.time),
                    at: a.time,
                }
            },
            branch,
        });
    }
    if pieces.is_empty() {
        pieces.push(hold(f64::NEG_INFINITY, first.time, first.after, branch));
    }
    pieces.push(hold(last.time, f64::INFINITY, last.after, branch));
    (pieces, edges)
}

fn edge(interval: f64, piece: usize, time: f64, (low, high): (f64, f64)) -> DriveEdge {
    let floor = MIN_EDGE_SIGMA_INTERVALS * interval;
    DriveEdge {
        piece,
        time,
        sigma: ((high - low) / 12f64.sqrt()).max(floor),
        reach: (high - time).max(time - low).max(EDGE_REACH_SIGMAS * floor),
    }
}

/// An edge at a turn whose time has standard deviation `sigma` \[s\].
pub fn turn_edge(interval: f64, piece: usize, time: f64, sigma: f64) -> DriveEdge {
    let sigma = sigma.max(MIN_EDGE_SIGMA_INTERVALS * interval);
    DriveEdge {
        piece,
        time,
        sigma,
        reach: EDGE_REACH_SIGMAS * sigma,
    }
}

/// Pieces and edges of sinusoids: from turn to turn for a single one, else short cubics.
pub fn of_sinusoids(span: Span, sinusoids: &Sinusoids) -> (Vec<Segment>, Vec<DriveEdge>) {
    let (first, last) = (span.first, span.last);
    let turns = turns_of(span.interval, sinusoids, first, last);
    let single = (sinusoids.parts.len() == 1).then(|| sinusoids.parts[0]);
    let sigma = sinusoids
        .parts
        .iter()
        .map(|p| p.time_sigma)
        .fold(0.0, f64::max);
    let rising = |t: f64| {
        if sinusoids.slope(t) >= 0.0 {
            Branch::Rising
        } else {
            Branch::Falling
        }
    };
    let mut bounds = vec![first];
    bounds.extend(&turns);
    bounds.push(last);
    let mut branch = rising(0.5 * (bounds[0] + bounds[1]));
    let start = sinusoids.voltage(first);
    let mut pieces = vec![hold(f64::NEG_INFINITY, first, start, branch)];
    let mut edges = Vec::new();
    for (i, pair) in bounds.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            continue;
        }
        branch = rising(0.5 * (pair[0] + pair[1]));
        if i > 0 {
            edges.push(turn_edge(span.interval, pieces.len(), pair[0], sigma));
        }
        if let Some(part) = single {
            // The phase counts from the piece's own start, so that late periods are as
            // exact as the first.
            let whole = part.turns(pair[0]).floor();
            pieces.push(Segment {
                start: pair[0],
                end: pair[1],
                shape: Shape::Chirp {
                    amplitude: part.amplitude,
                    phase: part.phase - whole,
                    from: part.from,
                    rate: part.rate,
                    offset: sinusoids.offset,
                },
                branch,
            });
        } else {
            cubics_of(sinusoids, (pair[0], pair[1]), branch, &mut pieces);
        }
    }
    let end = sinusoids.voltage(last);
    pieces.push(hold(last, f64::INFINITY, end, branch));
    (pieces, edges)
}

/// Cubics of Hermite that follow a sum of sines.
fn cubics_of(sum: &Sinusoids, (from, to): (f64, f64), branch: Branch, pieces: &mut Vec<Segment>) {
    let fastest = sum.parts.iter().map(|p| p.from.abs()).fold(0.0, f64::max);
    let count = ((to - from) * fastest * PIECES_PER_TURN).ceil().max(1.0) as usize;
    let unit = (to - from) / count as f64;
    for k in 0..count {
        let at = from + k as f64 * unit;
        let end = if k + 1 == count {
            to
        } else {
            from + (k + 1) as f64 * unit
        };
        let (a, b) = (sum.voltage(at), sum.voltage(end));
        let (da, db) = (sum.slope(at) * unit, sum.slope(end) * unit);
        pieces.push(Segment {
            start: at,
            end,
            shape: Shape::Cubic {
                c: [
                    a,
                    da,
                    3.0 * (b - a) - 2.0 * da - db,
                    2.0 * (a - b) + da + db,
                ],
                at,
                unit,
            },
            branch,
        });
    }
}

/// Where sinusoids turn between `first` and `last` \[s\].
fn turns_of(interval: f64, sum: &Sinusoids, first: f64, last: f64) -> Vec<f64> {
    let mut turns = Vec::new();
    if let [part] = sum.parts[..]
        && part.rate == 0.0
    {
        // Turns are a quarter period after each zero.
        let period = 1.0 / part.from.abs();
        let begin = (0.25 - part.phase) / part.from;
        let mut k = ((first - begin) / (0.5 * period)).floor();
        loop {
            k += 1.0;
            let t = begin + 0.5 * k * period;
            if t >= last {
                return turns;
            }
            if t > first {
                turns.push(t);
            }
        }
    }
    // Else where the slope changes its sign, halved down from the samples' intervals.
    let fastest = sum
        .parts
        .iter()
        .map(|p| p.from.abs().max((p.from + p.rate * last).abs()))
        .fold(0.0, f64::max);
    let step = (0.05 / fastest).max(0.1 * interval);
    let mut t = first;
    let mut slope = sum.slope(t);
    while t < last {
        let next = (t + step).min(last);
        let there = sum.slope(next);
        if (slope > 0.0) != (there > 0.0) {
            let (mut a, mut b) = (t, next);
            for _ in 0..50 {
                let middle = 0.5 * (a + b);
                if (sum.slope(middle) > 0.0) == (slope > 0.0) {
                    a = middle;
                } else {
                    b = middle;
                }
            }
            turns.push(0.5 * (a + b));
        }
        (t, slope) = (next, there);
    }
    turns
}

/// A turn of a smoothed voltage.
#[derive(Debug, Clone, Copy)]
struct Extreme {
    time: f64,
    value: f64,
    sigma: f64,
    time_sigma: f64,
    /// Samples of its interval of the spline.
    samples: usize,
}

/// Pieces and edges of a smoothed voltage.
pub fn smoothed(samples: &Samples<'_>) -> (Vec<Segment>, Vec<DriveEdge>) {
    let blocks = jump_blocks(samples);
    let cubics: Vec<Vec<Cubic>> = blocks
        .iter()
        .map(|block| smooth(&samples.part(block.start, block.end)))
        .collect();
    let mut turns = branch_turns(samples, &cubics);
    refine_turns(samples, &blocks, &mut turns);
    let first_value = samples.volts[0];
    let mut pieces: Vec<Segment> = Vec::new();
    let mut edges = Vec::new();
    let mut turns = turns.into_iter().peekable();
    let mut branch = turns.peek().map_or(first_branch(first_value), |t| t.1);
    let mut before: Option<(f64, f64)> = None;
    for (block, own) in blocks.iter().zip(&cubics) {
        let (start, end) = (samples.time[block.start], samples.time[block.end - 1]);
        let begin = match before {
            None => {
                let value = own.first().map_or(first_value, |c| c.shape.voltage(start));
                pieces.push(hold(f64::NEG_INFINITY, start, value, branch));
                start
            }
            Some((time, _)) => {
                let middle = 0.5 * (time + start);
                let rises = samples.volts[block.start] > samples.volts[block.start - 1];
                branch = if rises {
                    Branch::Rising
                } else {
                    Branch::Falling
                };
                if let Some(piece) = pieces.last_mut() {
                    piece.end = middle;
                }
                edges.push(edge(samples.interval, pieces.len(), middle, (time, start)));
                middle
            }
        };
        if own.is_empty() {
            pieces.push(hold(
                begin,
                end.max(begin),
                samples.volts[block.start],
                branch,
            ));
        }
        for (k, cubic) in own.iter().enumerate() {
            let mut from = if k == 0 { begin } else { cubic.start };
            // Turns before this block's first cubic belong to the jump.
            while let Some((turn, to)) = turns.next_if(|t| t.0.time < cubic.end) {
                if to == branch {
                    continue;
                }
                let at = turn.time.max(from);
                if at > from {
                    pieces.push(Segment {
                        start: from,
                        end: at,
                        shape: cubic.shape,
                        branch,
                    });
                }
                branch = to;
                if at > start {
                    edges.push(turn_edge(
                        samples.interval,
                        pieces.len(),
                        at,
                        turn.time_sigma,
                    ));
                }
                from = at;
            }
            pieces.push(Segment {
                start: from,
                end: cubic.end,
                shape: cubic.shape,
                branch,
            });
        }
        before = Some((end, samples.volts[block.end - 1]));
    }
    let (time, _) = before.unwrap_or((samples.time[0], first_value));
    let value = pieces
        .last()
        .filter(|p| p.start.is_finite())
        .map_or(first_value, |p| p.shape.voltage(time));
    pieces.push(hold(time, f64::INFINITY, value, branch));
    (pieces, edges)
}

/// Better instants of the turns, from the samples around each.
fn refine_turns(samples: &Samples<'_>, blocks: &[Range<usize>], turns: &mut [(Extreme, Branch)]) {
    turns.par_iter_mut().for_each(|(turn, _)| {
        let near = samples.time.partition_point(|&t| t < turn.time);
        let block = blocks.partition_point(|b| b.end <= near);
        let block = blocks.get(block).filter(|b| b.contains(&near));
        let refined =
            block.and_then(|b| refine_turn(samples, near, turn.samples / 2, (b.start, b.end)));
        if let Some((time, sigma)) = refined
            && (time - turn.time).abs()
                < (MAX_TURN_CHANGE_SIGMAS * turn.time_sigma).max(2.0 * samples.interval)
        {
            (turn.time, turn.time_sigma) = (time, sigma);
        }
    });
}

/// Where the voltage turns by more than its noise, and the branch from there on. On a level that
/// only noise moves, the last branch is held until the voltage leaves it for good.
fn branch_turns(samples: &Samples<'_>, blocks: &[Vec<Cubic>]) -> Vec<(Extreme, Branch)> {
    let mut extremes: Vec<Extreme> = Vec::new();
    for own in blocks {
        if let (Some(first), Some(last)) = (own.first(), own.last()) {
            extremes.push(extreme(samples, first, first.start));
            extremes.extend(own.iter().flat_map(|c| inner_extremes(samples, c)));
            extremes.push(extreme(samples, last, last.end));
        }
    }
    extremes.sort_by(|a, b| a.time.total_cmp(&b.time));
    let mut turns: Vec<(Extreme, Branch)> = Vec::new();
    let mut rising: Option<bool> = None;
    let Some(&begin) = extremes.first() else {
        return turns;
    };
    // The lowest and the highest since the last turn: value reached, and the last extreme that
    // noise alone keeps from it.
    let (mut low, mut high) = ((begin.value, begin), (begin.value, begin));
    let dead = |a: &Extreme, b: &Extreme| REVERSAL_SIGMAS * a.sigma.hypot(b.sigma);
    for &e in &extremes {
        if e.value < low.0 || e.value - low.0 < 0.5 * dead(&low.1, &e) {
            low = (low.0.min(e.value), e);
        }
        if e.value > high.0 || high.0 - e.value < 0.5 * dead(&high.1, &e) {
            high = (high.0.max(e.value), e);
        }
        if rising != Some(true) && e.value > low.0 + dead(&low.1, &e) {
            turns.push((low.1, Branch::Rising));
            rising = Some(true);
            high = (e.value, e);
        } else if rising != Some(false) && e.value < high.0 - dead(&high.1, &e) {
            turns.push((high.1, Branch::Falling));
            rising = Some(false);
            low = (e.value, e);
        }
    }
    turns
}

fn extreme(samples: &Samples<'_>, cubic: &Cubic, time: f64) -> Extreme {
    let width = cubic.end - cubic.start;
    // Curvature from the ends' slopes.
    let bend = (cubic.shape.slope(cubic.end) - cubic.shape.slope(cubic.start)).abs() / width;
    let slope_sigma = 3.0 * cubic.sigma / width;
    Extreme {
        time,
        value: cubic.shape.voltage(time),
        sigma: cubic.sigma,
        samples: (width / samples.interval) as usize,
        time_sigma: (slope_sigma / bend).clamp(0.0, width.max(samples.interval)),
    }
}

/// Turns of a cubic inside its interval.
fn inner_extremes(samples: &Samples<'_>, cubic: &Cubic) -> Vec<Extreme> {
    let Shape::Cubic { c, at, unit } = cubic.shape else {
        return Vec::new();
    };
    let (a, b, d) = (3.0 * c[3], c[2], c[1]);
    let root = (b * b - a * d).sqrt();
    if root.is_nan() {
        return Vec::new();
    }
    // In the form without cancellation.
    let q = -(b + root.copysign(b));
    [q / a, d / q]
        .into_iter()
        .filter(|u| u.is_finite())
        .map(|u| at + u * unit)
        .filter(|t| *t > cubic.start && *t < cubic.end)
        .map(|t| extreme(samples, cubic, t))
        .collect()
}
