//! The rows of a segment's residuals, and what is needed to compute them.
//!
//! The rows are, in this order: samples of the proof mass, samples of the cantilever, at each event
//! the laws of the ground (height at a touch, velocity after a bounce, force at a release), and the
//! distance of each instant from its first guess. Their number does not depend on the unknowns.

use super::coloured_noise::Colour;
use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::recording::Recording;
use crate::sim::StretchState;

/// The unknowns that belong to a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nuisances {
    /// Added to the reading of the proof mass \[m\].
    pub offset_p: f64,
    /// Added to that of the cantilever \[m\].
    pub offset_c: f64,
    /// Factor of the reading of the proof mass.
    pub scale_p: f64,
    /// Factor of that of the cantilever.
    pub scale_c: f64,
    /// The drive's clock minus the reading's \[s\].
    pub skew: f64,
}

impl Default for Nuisances {
    fn default() -> Self {
        Self {
            offset_p: 0.0,
            offset_c: 0.0,
            scale_p: 1.0,
            scale_c: 1.0,
            skew: 0.0,
        }
    }
}

/// Standard deviations of the rows of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sigmas {
    /// Noise of the proof mass \[m\].
    pub xp: f64,
    /// Noise of the cantilever \[m\].
    pub xc: f64,
    /// Of the height at which the mass meets the ground \[m\].
    pub height: f64,
    /// Of the velocity after a bounce \[m/s\].
    pub velocity: f64,
    /// Of the force at a release \[N\].
    pub force: f64,
    /// Of the held cantilever's rest where only the mass was recorded \[m\].
    pub rest: f64,
    /// Colour of the noise of either reading.
    pub colour: Colour,
}

/// What a row is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Row {
    /// A reading of the proof mass.
    ProofMass,
    /// A reading of the cantilever.
    Cantilever,
    /// Height at a touch or bounce.
    Height,
    /// Velocity after a bounce.
    Velocity,
    /// Force at a release.
    Force,
    /// A prior.
    Prior,
}

/// What a segment is simulated with.
#[derive(Debug, Clone, Copy)]
pub struct SegmentContext<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Standard deviations of the rows.
    pub sigmas: &'a Sigmas,
    /// The effects' extra states at its start; empty for those of rest.
    pub states: &'a [f64],
    /// Time from the beginning of the series to that of the recording \[s\], by which the
    /// ground's level goes.
    pub epoch: f64,
}

/// Kinds of a segment's rows, in the order of its residuals.
pub fn rows(segment: &Segment, context: &SegmentContext<'_>) -> Vec<Row> {
    let r = context.recording;
    let finite = |values: &[f64]| {
        values[segment.samples.clone()]
            .iter()
            .filter(|x| x.is_finite())
            .count()
    };
    let mut rows = vec![Row::ProofMass; finite(&r.proof_mass)];
    if let Some(xc) = &r.cantilever {
        rows.resize(rows.len() + finite(xc), Row::Cantilever);
    }
    for joint in &segment.joints {
        if let JointKind::Event(kind) = joint.what {
            match kind {
                GroundEvent::Bounce { .. } => rows.extend([Row::Height, Row::Velocity]),
                GroundEvent::Touch => rows.push(Row::Height),
                GroundEvent::Release { .. } => rows.push(Row::Force),
            }
        }
        rows.push(Row::Prior);
    }
    if segment.starts_held {
        rows.resize(rows.len() + held_count(segment), Row::Prior);
    }
    rows
}

/// Unknowns of a held start.
fn held_count(segment: &Segment) -> usize {
    let joints: usize = segment.joints.iter().map(Joint::unknowns).sum();
    segment.locals.len() - joints
}

/// One event of a simulated segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Encounter {
    /// The mass comes down.
    Meeting {
        /// When, by the drive's clock \[s\].
        time: f64,
        /// How far from the ground the two are \[m\].
        miss: f64,
        /// Speed of approach \[m/s\].
        speed: f64,
        /// Velocity after, if it bounces \[m/s\].
        after: Option<f64>,
    },
    /// It is pulled off, or was free already (`None`).
    PullOff(Option<PullOff>),
}

impl Encounter {
    /// When, by the drive's clock, where that is known \[s\].
    pub fn time(&self) -> Option<f64> {
        match self {
            Self::Meeting { time, .. } => Some(*time),
            Self::PullOff(pull) => pull.map(|p| p.time),
        }
    }
}

/// How the mass is pulled off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PullOff {
    /// When, by the drive's clock \[s\].
    pub time: f64,
    /// How long it was on the ground \[s\].
    pub contact: f64,
    /// Pull-off force \[N\].
    pub force: f64,
    /// The largest step of that force at an edge of the drive close by \[N\].
    pub jump: f64,
    /// Whether the stay was long enough to determine the force.
    pub informative: bool,
}

/// A segment simulated with given unknowns.
#[derive(Debug, Clone, Default)]
pub struct SegmentRun {
    /// Proof mass and cantilever at the samples, without the sensor \[m\].
    pub xp: Vec<f64>,
    /// See [`Self::xp`].
    pub xc: Vec<f64>,
    /// Events at the ground, in order of time.
    pub encounters: Vec<Encounter>,
    /// Distance of each instant from its guess, in standard deviations.
    pub(crate) priors: Vec<f64>,
    /// Where a held start would rest.
    pub(crate) rest: Option<StretchState>,
}
