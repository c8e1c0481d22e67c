//! Recordings cut into segments, away from events, edges and gaps.

use std::ops::Range;

use super::event_sequence::{GroundEvent, Mark, Timeline};
use super::initial_guess::guess;
use super::voltage_track::{Edge, Track};
use super::{Joint, JointKind, Segment};
use crate::fit::thresholds::{MIN_SEGMENT_SAMPLES, SETTLED_TIME_CONSTANTS};
use crate::recording::Recording;
use crate::sim::StretchSimulator;

/// Samples between a cut and the nearest event.
const EVENT_GUARD_SAMPLES: usize = 4;

/// What cutting needs to know.
#[derive(Debug, Clone, Copy)]
pub struct Cut<'a> {
    /// Index of the recording.
    pub index: usize,
    /// The recording.
    pub recording: &'a Recording,
    /// Its drive.
    pub track: &'a Track,
    /// Its events.
    pub timeline: &'a Timeline,
    /// The device as guessed at first.
    pub simulator: &'a StretchSimulator,
    /// Longest segment \[s\].
    pub longest: f64,
    /// Whether only the proof mass was recorded: then segments are cut in flight, or where the
    /// held cantilever is at rest.
    pub lone: bool,
    /// Noise of the proof mass \[m\].
    pub noise: f64,
}

/// Cuts `samples` of a recording into segments.
pub fn cut(c: &Cut<'_>, samples: Range<usize>) -> Vec<Segment> {
    let time = &c.recording.time;
    let marks = &c.timeline.marks;
    let mut segments = Vec::new();
    let mut from = samples.start;
    // A segment never spans a gap.
    let mut ends: Vec<usize> = (samples.start..samples.end.saturating_sub(1))
        .filter(|&i| c.recording.is_gap(i))
        .map(|i| i + 1)
        .collect();
    ends.push(samples.end);
    let damping = c
        .simulator
        .held_structure()
        .damping
        .iter()
        .fold(f64::INFINITY, |a, &b| a.min(0.5 * b));
    let quiet = SETTLED_TIME_CONSTANTS / damping.max(1.0);
    let reach = c.track.edges.iter().fold(0.0, |a: f64, e| a.max(e.reach));
    for end in ends {
        while from + MIN_SEGMENT_SAMPLES <= end {
            let limit = time[from] + c.longest;
            let mut to = time[..end]
                .partition_point(|&t| t < limit)
                .max(from + MIN_SEGMENT_SAMPLES);
            // On to a place without an event nearby.
            while to < end && !may_cut(c, marks, to, (quiet, reach)) {
                to += 1;
            }
            if end < to + MIN_SEGMENT_SAMPLES {
                to = end;
            }
            segments.extend(segment(c, from..to.min(end), quiet));
            from = to;
        }
        from = end;
    }
    segments
}

/// Whether a segment may end before sample `at`. What is held comes to rest within `quiet`
/// \[s\]; no edge is farther from its guess than `reach` \[s\].
fn may_cut(c: &Cut<'_>, marks: &[Mark], at: usize, (quiet, reach): (f64, f64)) -> bool {
    let time = &c.recording.time;
    let guard = EVENT_GUARD_SAMPLES as f64 * c.recording.interval();
    let t = time[at];
    let next = marks.partition_point(|m| m.time <= t);
    let close = |m: &Mark| (m.time - t).abs() < guard;
    if marks[..next].last().is_some_and(close) || marks.get(next).is_some_and(close) {
        return false;
    }
    // Edges are in order of time, so that only those about here are looked at.
    let edges = &c.track.edges;
    let near_edge = |e: &Edge| (e.time - t).abs() < e.reach + guard;
    let about = edges.partition_point(|e| e.time <= t - reach - guard);
    let until = edges.partition_point(|e| e.time < t + reach + guard);
    if edges[about..until.max(about)].iter().any(near_edge) {
        return false;
    }
    if !c.lone {
        return true;
    }
    // The cantilever's unseen motion must be known: where it has come to rest.
    let held = held_at(c, next);
    let at_rest = |since: f64| t - since > quiet;
    !held
        || (marks[..next].last().is_some_and(|m| at_rest(m.time))
            && last_edge(c.track, t).is_none_or(at_rest))
}

/// Time of the last edge up to `t` \[s\].
fn last_edge(track: &Track, t: f64) -> Option<f64> {
    let before = track.edges.partition_point(|e| e.time <= t);
    before.checked_sub(1).map(|i| track.edges[i].time)
}

/// Whether the mass is on the ground after the first `passed` marks.
fn held_at(c: &Cut<'_>, passed: usize) -> bool {
    match passed.checked_sub(1).map(|i| c.timeline.marks[i].kind) {
        None => c.timeline.starts_held,
        Some(GroundEvent::Touch) => true,
        Some(_) => false,
    }
}

fn segment(c: &Cut<'_>, samples: Range<usize>, quiet: f64) -> Option<Segment> {
    let time = &c.recording.time;
    let interval = c.recording.interval();
    let (start, end) = (time[samples.start], time[samples.end - 1]);
    let marks = &c.timeline.marks;
    let first = marks.partition_point(|m| m.time <= start);
    let last = marks.partition_point(|m| m.time <= end);
    let starts_held = held_at(c, first);
    let since = first
        .checked_sub(1)
        .map(|i| marks[i].time)
        .filter(|_| starts_held);
    let mut clock_known = !starts_held || since.is_some();
    let margin = 2.0 * interval;
    let begin_piece = c.track.pieces.partition_point(|p| p.end <= start - margin);
    let end_piece = c.track.pieces.partition_point(|p| p.start < end + margin);
    let pieces = c.track.pieces[begin_piece..end_piece.max(begin_piece + 1)].to_vec();
    let mut joints: Vec<Joint> = marks[first..last]
        .iter()
        .map(|m| {
            // The duration of a stay that began before the recording is unknown.
            let kind = match m.kind {
                GroundEvent::Release { informative } => GroundEvent::Release {
                    informative: informative && clock_known,
                },
                other => other,
            };
            clock_known = true;
            Joint {
                time: m.time,
                reach: 5.0 * interval,
                sigma: 2.0 * interval,
                what: JointKind::Event(kind),
            }
        })
        .collect();
    let from_edge = c.track.edges.partition_point(|e| e.piece <= begin_piece);
    let to_edge = c.track.edges.partition_point(|e| e.piece < end_piece);
    for edge in &c.track.edges[from_edge..to_edge.max(from_edge)] {
        if edge.time > start - margin {
            joints.push(Joint {
                time: edge.time,
                reach: edge.reach,
                sigma: edge.sigma,
                what: JointKind::Edge(edge.piece - begin_piece),
            });
        }
    }
    joints.sort_by(|a, b| a.time.total_cmp(&b.time));
    let lasts = |t: Option<f64>| t.is_none_or(|t| start - t > quiet);
    let last_edge = last_edge(c.track, start);
    let mut segment = Segment {
        recording: c.index,
        samples,
        starts_held,
        since,
        settled: starts_held && lasts(since) && lasts(last_edge),
        joints,
        pieces,
        locals: Vec::new(),
        units: Vec::new(),
        velocity_unit: 0.05 * c.noise / interval,
        interval,
    };
    guess(c, &mut segment);
    Some(segment)
}
