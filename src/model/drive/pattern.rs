//! A cycle with offset and bursts as smooth pieces, each with its hysteresis branch.

use super::cycle::Cycle;
use super::segments::direction;
use super::{Segment, Shape};

/// Steps that are smaller than this share of the largest voltage are rounding.
const STEP_TOLERANCE: f64 = 1e-9;

/// Lines are one line if slope and voltage differ by less than this share.
const SAME_LINE_TOLERANCE: f64 = 1e-12;

/// `on` periods of each `of`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Burst {
    /// Periods of the cycle, at least 1.
    pub on: u32,
    /// Periods of the pattern, at least `on`.
    pub of: u32,
}

/// The pieces of a pattern with offset and branches, in periods.
pub(super) fn pattern(cycle: &Cycle, offset: f64, burst: Option<Burst>) -> Vec<Segment> {
    let cycle = cycle.pieces();
    let Burst { on, of } = burst.unwrap_or(Burst { on: 1, of: 1 });
    let mut pieces: Vec<Segment> = Vec::new();
    let cycles = (0..on).flat_map(|k| cycle.iter().map(move |p| p.shifted(f64::from(k))));
    for mut piece in cycles {
        piece.shape = raised(piece.shape, offset);
        match pieces.last_mut() {
            Some(last) if goes_on(last, &piece) => last.end = piece.end,
            _ => pieces.push(piece),
        }
    }
    if on < of {
        pieces.push(Segment {
            start: f64::from(on),
            end: f64::from(of),
            shape: Shape::Constant { voltage: offset },
            branch: direction(true),
        });
    }
    // What leads over the end of the pattern is one piece.
    if pieces.len() > 1 {
        let before = pieces[pieces.len() - 1].shifted(-f64::from(of));
        if goes_on(&before, &pieces[0]) {
            pieces[0] = Segment {
                end: pieces[0].end,
                ..before
            };
            pieces.pop();
        }
    }
    set_branches(&mut pieces);
    pieces
}

fn raised(shape: Shape, by: f64) -> Shape {
    match shape {
        Shape::Constant { voltage } => Shape::Constant {
            voltage: voltage + by,
        },
        Shape::Line { voltage, slope, at } => Shape::Line {
            voltage: voltage + by,
            slope,
            at,
        },
        Shape::Sine {
            amplitude,
            omega,
            at,
            offset,
        } => Shape::Sine {
            amplitude,
            omega,
            at,
            offset: offset + by,
        },
        Shape::Chirp {
            amplitude,
            phase,
            from,
            rate,
            offset,
        } => Shape::Chirp {
            amplitude,
            phase,
            from,
            rate,
            offset: offset + by,
        },
        Shape::Cubic { c, at, unit } => Shape::Cubic {
            c: [c[0] + by, c[1], c[2], c[3]],
            at,
            unit,
        },
    }
}

/// Whether `next` is the same curve as `piece`, which ends where it begins.
fn goes_on(piece: &Segment, next: &Segment) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= SAME_LINE_TOLERANCE * a.abs().max(b.abs());
    let is_same_time = |a: f64, b: f64| (a - b).abs() <= STEP_TOLERANCE;
    match (piece.shape, next.shape) {
        (Shape::Constant { voltage: a }, Shape::Constant { voltage: b }) => a == b,
        (
            Shape::Line { slope: a, .. },
            Shape::Line {
                slope: b, voltage, ..
            },
        ) => {
            let start = next.shape.voltage(next.start);
            let scale = start.abs().max(voltage.abs()).max(a.abs());
            near(a, b)
                && (piece.shape.voltage(next.start) - start).abs() <= SAME_LINE_TOLERANCE * scale
        }
        (
            Shape::Sine {
                amplitude: a,
                at: t,
                ..
            },
            Shape::Sine {
                amplitude: b,
                at: s,
                ..
            },
        ) => a == b && is_same_time(t, s),
        (
            Shape::Cubic { c, at, unit },
            Shape::Cubic {
                c: d,
                at: s,
                unit: w,
            },
        ) => c == d && unit == w && is_same_time(at, s),
        _ => false,
    }
}

/// The branch of each piece as in a drive that has always run: that of its slope; on a level
/// that of the step that leads to it, or of the piece before.
fn set_branches(pieces: &mut [Segment]) {
    let ends = |p: &Segment| (p.shape.voltage(p.start), p.shape.voltage(p.end));
    let scale = pieces.iter().fold(0.0f64, |most, p| {
        most.max(ends(p).0.abs()).max(ends(p).1.abs())
    });
    let tolerance = STEP_TOLERANCE * scale;
    let n = pieces.len();
    let own: Vec<Option<f64>> = (0..n)
        .map(|i| {
            let (start, end) = ends(&pieces[i]);
            if !matches!(pieces[i].shape, Shape::Constant { .. }) && end != start {
                return Some(end - start);
            }
            let step = start - ends(&pieces[(i + n - 1) % n]).1;
            (step.abs() > tolerance).then_some(step)
        })
        .collect();
    let level = pieces[0].shape.voltage(pieces[0].start);
    let mut last = own
        .iter()
        .rev()
        .find_map(|&d| d)
        .unwrap_or(if level >= 0.0 { 1.0 } else { -1.0 });
    for (piece, own) in pieces.iter_mut().zip(own) {
        last = own.unwrap_or(last);
        piece.branch = direction(last > 0.0);
    }
}
