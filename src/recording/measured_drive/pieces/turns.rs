//! Turns of a smoothed voltage at other instants: the voltage stays, the branch changes earlier or
//! later.

use crate::model::drive::Segment;
use crate::recording::measured_drive::DriveEdge;
use crate::recording::measured_drive::thresholds::{MAX_OPEN_TURNS, MAX_TURN_STEP_SHARE};

/// Which edges are turns that are left open, in order of time: those known least, if there are too
/// many.
pub fn open_turns(pieces: &[Segment], edges: &[DriveEdge]) -> Vec<usize> {
    let mut turns: Vec<usize> = (0..edges.len())
        .filter(|&k| is_turn(pieces, edges, k))
        .collect();
    turns.sort_by(|&a, &b| edges[b].sigma.total_cmp(&edges[a].sigma));
    turns.truncate(MAX_OPEN_TURNS);
    turns.sort_unstable();
    turns
}

/// Whether the branch changes at an edge and the voltage does not jump.
fn is_turn(pieces: &[Segment], edges: &[DriveEdge], k: usize) -> bool {
    let edge = &edges[k];
    let Some([before, after]) = pieces.get(edge.piece - 1..=edge.piece) else {
        return false;
    };
    let step = |t: f64| after.shape.voltage(t) - before.shape.voltage(t);
    let bend = (after.shape.voltage(edge.time + edge.reach) - after.shape.voltage(edge.time)).abs();
    before.branch != after.branch
        && step(edge.time).abs() <= MAX_TURN_STEP_SHARE * bend.max(f64::MIN_POSITIVE)
}

/// The pieces and edges with the open turns later by `late` \[s\] each.
pub fn with_turns(
    pieces: &[Segment],
    edges: &[DriveEdge],
    late: &[f64],
) -> (Vec<Segment>, Vec<DriveEdge>) {
    let mut edges = edges.to_vec();
    let mut is_moved = vec![false; edges.len()];
    let times: Vec<f64> = edges.iter().map(|e| e.time).collect();
    for (k, late) in open_turns(pieces, &edges).into_iter().zip(late) {
        // Halfway to its neighbours at most.
        let before = k.checked_sub(1).map_or(f64::NEG_INFINITY, |k| times[k]);
        let after = times.get(k + 1).copied().unwrap_or(f64::INFINITY);
        let (low, high) = (0.5 * (before + times[k]), 0.5 * (times[k] + after));
        edges[k].time = (times[k] + late).clamp(low, high);
        is_moved[k] = true;
    }
    let mut moved: Vec<Segment> = Vec::with_capacity(pieces.len());
    let mut next = 0;
    let mut branch = pieces[0].branch;
    for (i, piece) in pieces.iter().enumerate() {
        // A jump stays between its two pieces.
        while next < edges.len() && !is_moved[next] && edges[next].piece == i {
            branch = piece.branch;
            edges[next].piece = moved.len();
            next += 1;
        }
        let mut start = piece.start;
        while next < edges.len() && is_moved[next] && edges[next].time < piece.end {
            let time = edges[next].time.max(start);
            if time > start {
                moved.push(Segment {
                    start,
                    end: time,
                    branch,
                    ..*piece
                });
            }
            branch = pieces[edges[next].piece].branch;
            edges[next].time = time;
            edges[next].piece = moved.len();
            start = time;
            next += 1;
        }
        match moved.last_mut() {
            // What a turn cut that is now elsewhere is one piece again.
            Some(last)
                if last.shape == piece.shape && last.branch == branch && start == piece.start =>
            {
                last.end = piece.end;
            }
            _ => moved.push(Segment {
                start,
                branch,
                ..*piece
            }),
        }
    }
    (moved, edges)
}
