//! Stretches of a recording that are simulated in one piece: from a free initial state,
//! through the events that the data show, at free instants.

use std::ops::Range;

use super::timeline::{Kind, Timeline};
use super::track::Track;
use crate::model::drive::Segment as Piece;
use crate::recording::Recording;
use crate::sim::{StretchSimulator, StretchState};

/// A stretch is not cut closer than this many samples to an event.
const GUARD: usize = 4;
/// Fewest samples of a stretch.
const LEAST: usize = 6;
/// Step of an unknown for differences, in its unit.
const STEP: f64 = 0.5;
/// Time constants after which a held cantilever counts as come to rest.
const SETTLED: f64 = 7.0;

/// An instant that a segment leaves free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// First guess \[s\], by the reading's clock for events, by the drive's for edges; how
    /// far it is from there is by the reading's clock for both.
    pub time: f64,
    /// How far it may be from the guess \[s\].
    pub reach: f64,
    /// Standard deviation of the guess \[s\].
    pub sigma: f64,
    /// An event, or the edge at which this piece of the drive begins.
    pub what: JointKind,
}

/// See [`Joint`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// At the ground.
    Event(Kind),
    /// Index into the segment's own pieces.
    Edge(usize),
}

/// A stretch with its unknowns.
#[derive(Debug, Clone)]
pub struct Segment {
    /// Which recording it is of.
    pub recording: usize,
    /// Its samples.
    pub samples: Range<usize>,
    /// Whether the mass is on the ground at its start.
    pub starts_held: bool,
    /// When that stay began \[s\], if it is known.
    pub since: Option<f64>,
    /// Whether, started on the ground, everything has come to rest by then.
    pub settled: bool,
    /// Instants left free, in order of time.
    pub joints: Vec<Joint>,
    /// The drive's pieces that it needs.
    pub pieces: Vec<Piece>,
    /// Unknowns: coordinates, velocities, then for each joint its time, and for a
    /// bounce the velocity after. In the units of [`Segment::unit`].
    pub locals: Vec<f64>,
    /// Unit of each unknown.
    pub units: Vec<f64>,
    /// Unit of velocities after a bounce \[m/s\].
    pub velocity_unit: f64,
    /// Interval of the samples \[s\].
    pub interval: f64,
}

impl Joint {
    /// Number of its unknowns: its time, and the velocity after a bounce.
    pub fn unknowns(&self) -> usize {
        1 + usize::from(matches!(self.what, JointKind::Event(Kind::Bounce { .. })))
    }
}

impl Segment {
    /// Value of unknown `i` in SI.
    pub fn value(&self, locals: &[f64], i: usize) -> f64 {
        locals[i] * self.units[i]
    }

    /// Whether something happens at the ground in it.
    pub fn has_events(&self) -> bool {
        let event = |j: &Joint| matches!(j.what, JointKind::Event(_));
        self.joints.iter().any(event)
    }

    /// Whether the mass is in the air where it hits the ground, and on it where it leaves.
    pub fn is_consistent(&self) -> bool {
        let mut held = self.starts_held;
        self.joints.iter().all(|joint| match joint.what {
            JointKind::Edge(_) => true,
            JointKind::Event(kind) => {
                let before = std::mem::replace(&mut held, kind == Kind::Touch);
                before == matches!(kind, Kind::Release { .. })
            }
        })
    }

    /// Brings instants back within their reach.
    pub fn keep_within(&self, locals: &mut [f64]) {
        let joints: usize = self.joints.iter().map(Joint::unknowns).sum();
        let mut k = locals.len() - joints;
        for joint in &self.joints {
            // An edge is shifted by the skew of the clocks, and kept within its reach after.
            if let JointKind::Event(_) = joint.what {
                let reach = joint.reach / self.units[k];
                locals[k] = locals[k].clamp(-reach, reach);
            }
            k += joint.unknowns();
        }
    }

    /// Step of unknown `k` for differences: about as large as the noise, which is well
    /// above rounding and still small; inwards from the end of an instant's reach.
    pub fn step(&self, locals: &[f64], k: usize) -> f64 {
        let mut there = locals.to_vec();
        there[k] += STEP;
        self.keep_within(&mut there);
        if there[k] < locals[k] + 0.5 * STEP {
            -STEP
        } else {
            STEP
        }
    }

    /// Unit of instants \[s\].
    pub fn time_unit(&self) -> f64 {
        0.02 * self.interval
    }
}

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
    /// Longest stretch \[s\].
    pub longest: f64,
    /// Whether only the proof mass was recorded: then stretches are cut in flight, or
    /// where the held cantilever is at rest.
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
    let quiet = SETTLED / damping.max(1.0);
    for end in ends {
        while from + LEAST <= end {
            let limit = time[from] + c.longest;
            let mut to = time[..end]
                .partition_point(|&t| t < limit)
                .max(from + LEAST);
            // On to a place that no event is near.
            while to < end && !may_cut(c, marks, to, quiet) {
                to += 1;
            }
            if end < to + LEAST {
                to = end;
            }
            segments.extend(segment(c, from..to.min(end), quiet));
            from = to;
        }
        from = end;
    }
    segments
}

/// Whether the stretch may be cut before sample `at`.
fn may_cut(c: &Cut<'_>, marks: &[super::timeline::Mark], at: usize, quiet: f64) -> bool {
    let time = &c.recording.time;
    let guard = GUARD as f64 * c.recording.interval();
    let t = time[at];
    let next = marks.partition_point(|m| m.time <= t);
    let close = |m: &super::timeline::Mark| (m.time - t).abs() < guard;
    if marks[..next].last().is_some_and(close) || marks.get(next).is_some_and(close) {
        return false;
    }
    let near_edge = |e: &super::track::Edge| (e.time - t).abs() < e.reach + guard;
    if c.track.edges.iter().any(near_edge) {
        return false;
    }
    if !c.lone {
        return true;
    }
    // The cantilever's unseen motion must be known: where it has come to rest.
    let held = held_at(c, next);
    let calm = |since: f64| t - since > quiet;
    !held
        || (marks[..next].last().is_some_and(|m| calm(m.time))
            && c.track.edges.iter().all(|e| e.time > t || calm(e.time)))
}

/// Whether the mass is on the ground after the first `passed` marks.
fn held_at(c: &Cut<'_>, passed: usize) -> bool {
    match passed.checked_sub(1).map(|i| c.timeline.marks[i].kind) {
        None => c.timeline.starts_held,
        Some(Kind::Touch) => true,
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
            // How long a stay has lasted that the recording's begin cuts is not known.
            let kind = match m.kind {
                Kind::Release { telling } => Kind::Release {
                    telling: telling && clock_known,
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
    for edge in &c.track.edges {
        if edge.piece > begin_piece && edge.piece < end_piece && edge.time > start - margin {
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
    let last_edge = c
        .track
        .edges
        .iter()
        .rev()
        .find(|e| e.time <= start)
        .map(|e| e.time);
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

/// Units of coordinates, then velocities, of a stretch of `span` \[s\]: motions as large as
/// the `noise` \[m\].
pub fn state_units(sim: &StretchSimulator, held: bool, noise: f64, span: f64) -> Vec<f64> {
    let (shapes, omega2): (Vec<f64>, Vec<f64>) = if held {
        let structure = sim.held_structure();
        (structure.cantilever.clone(), structure.omega2.clone())
    } else {
        let (p, c) = sim.flight_shapes();
        let both = p.iter().zip(c).map(|(p, c)| p.hypot(*c)).collect();
        (both, sim.flight_omega2().collect())
    };
    let size = |shape: &f64| noise / shape.abs().max(1e-300);
    let speeds = shapes
        .iter()
        .zip(&omega2)
        .map(|(shape, omega2)| size(shape) * omega2.sqrt().max(1.0 / span));
    shapes.iter().map(size).chain(speeds).collect()
}

/// First guess of the unknowns, and their units: motions as large as the noise.
fn guess(c: &Cut<'_>, segment: &mut Segment) {
    let sim = c.simulator;
    let start = c.recording.time[segment.samples.start];
    let level = sim.ground_level(start);
    let held = segment.starts_held.then_some(level);
    let mut state = sim.rest_state(&segment.pieces, start, held);
    let n = state.q.len();
    let span = c.recording.time[segment.samples.end - 1] - start;
    let mut units = state_units(sim, segment.starts_held, c.noise, span);
    if !segment.starts_held {
        follow_data(c, segment, &mut state);
    }
    let mut locals: Vec<f64> = state.q.iter().chain(&state.v).copied().collect();
    let interval = c.recording.interval();
    for joint in &segment.joints {
        locals.push(joint.time);
        units.push(0.02 * interval);
        if let JointKind::Event(Kind::Bounce { v_after }) = joint.what {
            locals.push(v_after);
            units.push(c.noise / interval * 0.05);
        }
    }
    // Times are counted from the guess: a difference of two late instants is exact.
    let mut k = 2 * n;
    for joint in &segment.joints {
        locals[k] -= joint.time;
        k += 1 + usize::from(matches!(joint.what, JointKind::Event(Kind::Bounce { .. })));
    }
    segment.locals = locals.iter().zip(&units).map(|(x, u)| x / u).collect();
    segment.units = units;
}

/// Brings the modes to where the first samples lie, with their mean slope.
fn follow_data(c: &Cut<'_>, segment: &Segment, state: &mut StretchState) {
    let (phi_p, phi_c) = c.simulator.flight_shapes();
    let n = state.q.len();
    let first = segment.samples.start;
    let few = first..(first + 4).min(segment.samples.end);
    let line = |values: &[f64]| -> Option<(f64, f64)> {
        let points: Vec<(f64, f64)> = few
            .clone()
            .map(|i| (c.recording.time[i] - c.recording.time[first], values[i]))
            .filter(|p| p.1.is_finite())
            .collect();
        let count = points.len() as f64;
        if points.len() < 2 {
            return None;
        }
        let (mt, mx) = points
            .iter()
            .fold((0.0, 0.0), |m, p| (m.0 + p.0, m.1 + p.1));
        let (mt, mx) = (mt / count, mx / count);
        let (mut xy, mut xx) = (0.0, 0.0);
        for (t, x) in &points {
            xy += (t - mt) * (x - mx);
            xx += (t - mt) * (t - mt);
        }
        Some((mx - xy / xx * mt, xy / xx))
    };
    let xp = line(&c.recording.proof_mass);
    let xc = c.recording.cantilever.as_deref().and_then(line);
    // The smallest change of the modes that meets the readings.
    let rows: Vec<(&[f64], (f64, f64))> = [(phi_p, xp), (phi_c, xc)]
        .into_iter()
        .filter_map(|(phi, x)| x.map(|x| (phi, x)))
        .filter(|(phi, _)| phi.iter().any(|p| *p != 0.0))
        .collect();
    let phi = nalgebra::DMatrix::from_fn(rows.len(), n, |i, j| rows[i].0[j]);
    let Ok(inverse) = phi.clone().pseudo_inverse(1e-12) else {
        return;
    };
    let want = |pick: fn(&(f64, f64)) -> f64, now: &[f64]| {
        let now = nalgebra::DVector::from_column_slice(now);
        let miss = nalgebra::DVector::from_fn(rows.len(), |i, _| pick(&rows[i].1)) - &phi * &now;
        now + &inverse * miss
    };
    let (q, v) = (want(|x| x.0, &state.q), want(|x| x.1, &state.v));
    state.q.copy_from_slice(q.as_slice());
    state.v.copy_from_slice(v.as_slice());
}
