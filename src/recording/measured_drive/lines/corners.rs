//! Lines between jumps, and the corners where they meet.

use super::line::{Line, Node, line_through};
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    CORNER_REACH_SIGMAS, CORNER_ROUNDS, CORNERS_CONVERGED_INTERVALS, MERGE_ROUNDS,
};

/// The lines of the samples `from..end` without jumps, and the corners between them. `None` beyond
/// `most` lines.
pub fn lines_of(
    samples: &Samples<'_>,
    from: usize,
    end: usize,
    most: usize,
) -> Option<(Vec<Line>, Vec<Node>)> {
    let mut starts = vec![from];
    let mut at = from;
    loop {
        let to = longest_line(samples, at, end);
        if to >= end {
            break;
        }
        starts.push(to);
        at = to;
        if starts.len() > most {
            return None;
        }
    }
    // Corners as boundaries in time, improved by the lines beside them.
    let interval = samples.interval;
    let mut corners: Vec<f64> = starts[1..]
        .iter()
        .map(|&i| samples.time[i] - 0.5 * interval)
        .collect();
    let mut lines = Vec::new();
    for round in 0..CORNER_ROUNDS {
        lines = between(samples, from, end, &corners);
        if round < MERGE_ROUNDS {
            merge(samples, from, end, &mut corners, &mut lines);
        }
        let mut moved = 0.0f64;
        for k in 0..corners.len() {
            let (a, b) = (&lines[k], &lines[k + 1]);
            let turn = a.slope - b.slope;
            let meet = a.at + (b.value - a.value - b.slope * (b.at - a.at)) / turn;
            let low = if k == 0 {
                samples.time[from]
            } else {
                corners[k - 1]
            };
            let high = corners.get(k + 1).copied().unwrap_or(samples.time[end - 1]);
            if meet.is_finite() && meet > low && meet < high {
                moved = moved.max((corners[k] - meet).abs());
                corners[k] = meet;
            }
        }
        if round >= MERGE_ROUNDS && moved < CORNERS_CONVERGED_INTERVALS * interval {
            break;
        }
    }
    let nodes = corners
        .iter()
        .enumerate()
        .map(|(k, &time)| {
            let (a, b) = (&lines[k], &lines[k + 1]);
            let turn = (a.slope - b.slope).abs();
            let sigma = a.sigma(time).hypot(b.sigma(time)) / turn;
            // Two levels do not intersect: they meet where the runs of samples do.
            let reach = if sigma.is_finite() {
                (CORNER_REACH_SIGMAS * sigma).max(1e-12)
            } else {
                2.0 * interval
            };
            Node {
                time,
                low: time - reach,
                high: time + reach,
                jumps: false,
            }
        })
        .collect();
    Some((lines, nodes))
}

/// Removes corners across which one line follows the samples of both.
fn merge(
    samples: &Samples<'_>,
    from: usize,
    end: usize,
    corners: &mut Vec<f64>,
    lines: &mut Vec<Line>,
) {
    let mut k = 0;
    let index = |t: f64| samples.time.partition_point(|&s| s < t).clamp(from, end);
    while k < corners.len() {
        let a = if k == 0 { from } else { index(corners[k - 1]) };
        let b = corners.get(k + 1).map_or(end, |&t| index(t));
        if b <= a + 2 {
            k += 1;
            continue;
        }
        let one = line_through(samples, a, b);
        if samples.part(a, b).are(|t| one.voltage(t)) {
            corners.remove(k);
            lines[k] = one;
            lines.remove(k + 1);
        } else {
            k += 1;
        }
    }
}

/// The line of each stretch between corners, from the samples clearly inside.
fn between(samples: &Samples<'_>, from: usize, end: usize, corners: &[f64]) -> Vec<Line> {
    let index = |t: f64| samples.time.partition_point(|&s| s < t).clamp(from, end);
    (0..=corners.len())
        .map(|k| {
            let mut a = if k == 0 { from } else { index(corners[k - 1]) };
            let mut b = corners.get(k).map_or(end, |&t| index(t));
            // The samples next to a corner may be on its other side.
            if b > a + 6 {
                a += usize::from(k > 0);
                b -= usize::from(k < corners.len());
            }
            if b < a + 2 {
                a = a.min(end.saturating_sub(2).max(from));
                b = (a + 2).min(end);
            }
            line_through(samples, a, b)
        })
        .collect()
}

/// The end (excluded) of the longest run from `from` on, below `end`, that one line follows.
fn longest_line(samples: &Samples<'_>, from: usize, end: usize) -> usize {
    let follows = |to: usize| {
        let line = line_through(samples, from, to);
        let reach = samples.reach();
        (from..to).all(|i| (samples.volts[i] - line.voltage(samples.time[i])).abs() <= reach)
    };
    let mut good = (from + 2).min(end);
    let mut size = 4;
    let mut bad = loop {
        let to = (from + size).min(end);
        if to <= good {
            return end;
        }
        if !follows(to) {
            break to;
        }
        good = to;
        size *= 2;
    };
    while bad > good + 1 {
        let middle = good + (bad - good) / 2;
        if follows(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}
