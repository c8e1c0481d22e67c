//! What was found as smooth pieces with branches of the hysteresis loop, and as edges.

mod sines;
mod smoothed;
mod turns;

pub use self::sines::of_sinusoids;
pub use self::smoothed::smoothed;
pub use self::turns::{open_turns, with_turns};
use super::DriveEdge;
use super::knots::{Knot, Knots};
use super::samples::{Samples, Span};
use super::thresholds::{EDGE_REACH_SIGMAS, MIN_EDGE_SIGMA_INTERVALS};
use crate::model::drive::{Segment, Shape};
use crate::model::piezo::Branch;

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
