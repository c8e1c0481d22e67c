//! Segments of a recording, each simulated in one piece: from a free initial state, through the
//! events that the data show, at free instants (multiple shooting).

pub(crate) mod cut;
pub mod event_sequence;
pub(crate) mod initial_guess;
pub mod voltage_track;

pub use self::cut::{Cut, cut};
pub use self::initial_guess::state_units;

use std::ops::Range;

use self::event_sequence::GroundEvent;
use crate::fit::thresholds::MIN_DRIVE_JUMP_SHARE;
use crate::model::drive::Segment as Piece;

/// Step of an unknown for differences, in its unit.
const LOCAL_DIFFERENCE_STEP: f64 = 0.5;

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
    Event(GroundEvent),
    /// Index into the segment's own pieces.
    Edge(usize),
}

/// A segment with its unknowns.
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
    /// bounce the velocity after. In the units of `Segment`.
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
        1 + usize::from(matches!(
            self.what,
            JointKind::Event(GroundEvent::Bounce { .. })
        ))
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

    /// Whether the drive jumps in it, in flight or held.
    pub fn has_jump(&self) -> bool {
        self.joints.iter().any(|joint| match joint.what {
            JointKind::Edge(piece) if piece > 0 => {
                let volts = |p: &Piece| p.shape.voltage(joint.time);
                let (before, after) = (volts(&self.pieces[piece - 1]), volts(&self.pieces[piece]));
                (after - before).abs() > MIN_DRIVE_JUMP_SHARE * before.abs().max(after.abs())
            }
            _ => false,
        })
    }

    /// Whether the events alternate as they must: the mass is in flight before each touch or bounce,
    /// and on the ground before each release.
    pub fn is_consistent(&self) -> bool {
        let mut held = self.starts_held;
        self.joints.iter().all(|joint| match joint.what {
            JointKind::Edge(_) => true,
            JointKind::Event(kind) => {
                let before = std::mem::replace(&mut held, kind == GroundEvent::Touch);
                before == matches!(kind, GroundEvent::Release { .. })
            }
        })
    }

    /// Clamps instants to their reach.
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

    /// Step of unknown `k` for differences: about as large as the noise, which is well above
    /// rounding and still small. It points inwards at the end of an instant's reach.
    pub fn step(&self, locals: &[f64], k: usize) -> f64 {
        let mut there = locals.to_vec();
        there[k] += LOCAL_DIFFERENCE_STEP;
        self.keep_within(&mut there);
        if there[k] < locals[k] + 0.5 * LOCAL_DIFFERENCE_STEP {
            -LOCAL_DIFFERENCE_STEP
        } else {
            LOCAL_DIFFERENCE_STEP
        }
    }

    /// Unit of instants \[s\].
    pub fn time_unit(&self) -> f64 {
        0.02 * self.interval
    }
}
