//! Flight, impact, contact and release of a trial device, with events found as roots
//! on the solver's continuous extension.

pub(crate) mod follow;
pub(crate) mod ground;
pub mod integrator;
#[cfg(test)]
pub(crate) mod solver_tests;
pub(crate) mod travel;

pub use self::follow::follow;

use thiserror::Error;

use self::integrator::{MAX_STATE, State};
use super::device::{Device, Phase};
use super::voltage::Piece;

/// Longest step \[s\].
const LONGEST_STEP: f64 = 2e-5;
/// Shortest step \[s\].
const SHORTEST_STEP: f64 = 1e-13;

/// Why a trial device could not be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RunError {
    /// The motion cannot be followed.
    #[error("the trial device cannot be followed beyond t = {time:.6} s; draw another seed")]
    Stalled {
        /// When \[s\].
        time: f64,
    },
    /// Too many events or steps.
    #[error("the trial device chatters at t = {time:.6} s; draw another seed")]
    TooMuchWork {
        /// When \[s\].
        time: f64,
    },
}

/// Kinds of events at the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A bounce.
    Impact,
    /// A touch that held.
    Stick,
    /// A release.
    Release,
}

/// One event at the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// When \[s\].
    pub time: f64,
    /// Which kind.
    pub kind: Kind,
    /// Velocity of the mass before \[m/s\].
    pub before: f64,
    /// And after.
    pub after: f64,
    /// Level of the ground \[m\].
    pub level: f64,
    /// Force with which the structure alone pulls the mass off \[N\].
    pub pull: f64,
    /// How fast that grows as the mass is pulled off \[N/s\]; zero for other events.
    pub pull_rate: f64,
    /// Contact that ends here \[s\].
    pub contact: f64,
    /// Whether a step of the drive tore the mass off, with more than adhesion holds.
    pub torn: bool,
}

/// A stretch without ground events, from a known state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// From \[s\].
    pub start: f64,
    /// To \[s\].
    pub end: f64,
    /// What the mass is doing.
    pub phase: Phase,
    /// State at `start`.
    pub state: State,
}

/// A run, sampled.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// What the sensor at the mass shows at each asked time \[m\].
    pub proof_mass: Vec<f64>,
    /// What the sensor at the cantilever shows \[m\].
    pub cantilever: Vec<f64>,
    /// Events at the ground, in order.
    pub events: Vec<Event>,
    /// Stretches between them, in order.
    pub stretches: Vec<Stretch>,
    /// Steps taken.
    pub steps: u64,
    /// Coordinates of the device: the velocities of a state stand behind as many.
    pub coordinates: usize,
}

/// The device on its way.
struct Traveller<'a> {
    device: &'a Device,
    times: &'a [f64],
    t: f64,
    y: State,
    phase: Phase,
    run: Run,
    stretch: (f64, State, Phase),
}

/// Cuts pieces where the ground steps.
fn with_ground_step(pieces: &[Piece], at: f64) -> Vec<Piece> {
    let mut out = Vec::with_capacity(pieces.len() + 1);
    for piece in pieces {
        if at > piece.start && at < piece.end {
            let (mut a, mut b) = (piece.clone(), piece.clone());
            a.end = at;
            b.start = at;
            out.extend([a, b]);
        } else {
            out.push(piece.clone());
        }
    }
    out
}

/// Runs from rest at zero over `[0, end]` \[s\], read at `times` (not falling; those
/// before zero show the rest state).
///
/// # Errors
/// [`RunError`] if the motion diverges or chatters.
pub fn run(
    device: &Device,
    pieces: &[Piece],
    end: f64,
    times: &[f64],
    tolerance: f64,
) -> Result<Run, RunError> {
    let y = [0.0; MAX_STATE];
    let phase = Phase::Flight { direction: 0.0 };
    let mut traveller = Traveller {
        device,
        times,
        t: 0.0,
        y,
        phase,
        run: Run {
            coordinates: device.structure.n,
            ..Run::default()
        },
        stretch: (0.0, y, phase),
    };
    let early = times.partition_point(|t| *t < 0.0);
    traveller.run.proof_mass.resize(early, 0.0);
    traveller.run.cantilever.resize(early, 0.0);
    let pieces = with_ground_step(pieces, device.rise_time);
    for (i, piece) in pieces.iter().enumerate() {
        if piece.start >= end {
            break;
        }
        if i == 0 {
            traveller.fly(piece);
        }
        traveller.travel(piece, piece.end.min(end), &device.tolerances(tolerance))?;
    }
    traveller.close_stretch();
    // Rounding may leave the last times beyond the end.
    let [xp, xc] = {
        let (p, c) = device.readings(&traveller.y);
        [p, c]
    };
    traveller.run.proof_mass.resize(times.len(), xp);
    traveller.run.cantilever.resize(times.len(), xc);
    Ok(traveller.run)
}

impl Traveller<'_> {
    fn close_stretch(&mut self) {
        let (start, state, phase) = self.stretch;
        if self.t > start {
            self.run.stretches.push(Stretch {
                start,
                end: self.t,
                phase,
                state,
            });
        }
        self.stretch = (self.t, self.y, self.phase);
    }
}
