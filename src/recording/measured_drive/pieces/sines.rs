//! Sinusoids as pieces from turn to turn.

use super::{hold, turn_edge};
use crate::model::drive::{Segment, Shape};
use crate::model::piezo::Branch;
use crate::recording::measured_drive::DriveEdge;
use crate::recording::measured_drive::samples::Span;
use crate::recording::measured_drive::sinusoid::Sinusoids;
use crate::recording::measured_drive::thresholds::PIECES_PER_TURN;

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
