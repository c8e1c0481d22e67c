//! A smoothed voltage as pieces: its cubics, cut where it turns.

use std::ops::Range;

use rayon::prelude::*;

use super::{edge, first_branch, hold, turn_edge};
use crate::model::drive::{Segment, Shape};
use crate::model::piezo::Branch;
use crate::recording::measured_drive::DriveEdge;
use crate::recording::measured_drive::lines::jump_blocks;
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::smooth::turn::refine_turn;
use crate::recording::measured_drive::smooth::{Cubic, smooth};
use crate::recording::measured_drive::thresholds::{MAX_TURN_CHANGE_SIGMAS, REVERSAL_SIGMAS};

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
