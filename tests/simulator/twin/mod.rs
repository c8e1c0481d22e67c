//! The paper's device with all the effects, written again: physical coordinates, reactions
//! from the condition that a held point does not accelerate, play operators one by one,
//! and a Runge-Kutta method of order 5 with short fixed steps. SI.

mod contact;
mod drive;
mod forces;
mod travel;

pub use self::drive::Drive;

use std::f64::consts::TAU;

use self::drive::Piece;

/// Modes of the device: Hz, damping, shapes at cantilever and mass.
const MODES: [[f64; 4]; 2] = [
    [623.0, 0.0262, 13381.005, 50145.332],
    [6424.0, 0.0257, 74486.762, -12923.177],
];
const DP: f64 = 58e-6;
/// Play operators of the hysteresis with memory.
const PLAYS: usize = 800;

/// Play operators with weights, in place of the branches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Memory {
    pub share: f64,
    pub width: f64,
    pub reference: f64,
    /// Narrowness and growth of the plays' weights.
    pub q: f64,
    pub k: f64,
    /// Voltage from which it came to rest before.
    pub past: f64,
    /// Bend and twist of the middle line, at the reference.
    pub middle: (f64, f64),
}

/// Parameters of the effects; zero is off.
#[derive(Debug, Clone, Copy, Default)]
pub struct Effects {
    pub amplifier_tau: f64,
    /// Share and time of either element.
    pub creep: [(f64, f64); 2],
    pub memory: Memory,
    /// Area, gap.
    pub electrostatic: (f64, f64),
    /// Frequency, damping, shapes at cantilever, mass and drive.
    pub mode: [f64; 5],
    pub k2: f64,
    pub k3: f64,
    pub k5: f64,
    /// Length of the sine form; 0 for the plain cubic.
    pub sine_length: f64,
    pub cd: f64,
    pub fc: f64,
    /// Friction per deflection, and per its square.
    pub load: (f64, f64),
    pub film_tau: f64,
    pub film_growth: f64,
    /// Force, range, exponent.
    pub attraction: (f64, f64, f64),
    /// Growth, time, share of the logarithm, of the straight line.
    pub adhesion: (f64, f64, f64, f64),
    /// Exponent, speed.
    pub restitution: (f64, f64),
    /// Stiffness, damping.
    pub ground: (f64, f64),
    /// Height, time.
    pub step: (f64, f64),
    /// Amplitude, frequency, phase.
    pub base: (f64, f64, f64),
    /// End, time, rate.
    pub drift: (f64, f64, f64),
    pub sensor_tau: f64,
    pub gravity: f64,
}

/// A drive and what the device is like.
#[derive(Debug, Clone)]
pub struct Twin {
    pub effects: Effects,
    pub drive: Drive,
    /// Displacement and velocity of the mass at the start, by a static force and an impulse.
    pub start: (f64, f64),
    pub has_ground: bool,
    pub has_film: bool,
    /// Step in flight and in a compliant ground [s].
    pub steps: (f64, f64),
}

/// `yc yp yc' yp' q q'`, then lagged voltage, creep, film force, lagged readings p and c,
/// further creep.
type State = [f64; 12];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Flight,
    /// On the rigid ground since.
    Held(f64),
    /// By friction.
    Stuck,
}

/// What the twin did: readings of mass and cantilever at `i / rate`, times of all changes
/// of contact, and the work of friction, film and so on is in the trace of energies.
#[derive(Debug, Default)]
pub struct Run {
    pub proof_mass: Vec<f64>,
    pub cantilever: Vec<f64>,
    pub contacts: Vec<(f64, f64)>,
}

struct Machine<'a> {
    twin: &'a Twin,
    m: [[f64; 2]; 2],
    b: [[f64; 2]; 2],
    k: [[f64; 2]; 2],
    plays: Vec<f64>,
    piece: Piece,
    phase: Phase,
    sliding: f64,
    touch: Option<f64>,
}

fn matrices() -> [[[f64; 2]; 2]; 3] {
    let [a, c] = MODES;
    let det = a[2] * c[3] - c[2] * a[3];
    let inverse = [[c[3] / det, -c[2] / det], [-a[3] / det, a[2] / det]];
    let congruence = |d: [f64; 2]| -> [[f64; 2]; 2] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..2).map(|n| d[n] * inverse[n][i] * inverse[n][j]).sum())
        })
    };
    let w = MODES.map(|m| TAU * m[0]);
    [
        congruence([1.0, 1.0]),
        congruence([2.0 * a[1] * w[0], 2.0 * c[1] * w[1]]),
        congruence([w[0] * w[0], w[1] * w[1]]),
    ]
}

impl Machine<'_> {
    fn e(&self) -> &Effects {
        &self.twin.effects
    }

    fn points(&self, s: &State) -> (f64, f64, f64, f64) {
        let [_, _, c, p, _] = self.e().mode;
        (
            s[1] + p * s[4],
            s[3] + p * s[5],
            s[0] + c * s[4],
            s[2] + c * s[5],
        )
    }

    fn level(&self, t: f64) -> f64 {
        let (height, time) = self.e().step;
        if t >= time { height - DP } else { -DP }
    }
}

impl Memory {
    /// The plays at rest after the past.
    fn plays(&self) -> Vec<f64> {
        let count = if self.share > 0.0 { PLAYS } else { 0 };
        let one = |i: usize| {
            let r = forces::width_of(i);
            0.0f64.clamp(self.past - r, self.past + r).clamp(-r, r)
        };
        (0..count).map(one).collect()
    }
}

impl Twin {
    /// The device from rest under `drive`.
    pub fn new(effects: Effects, drive: Drive) -> Self {
        Self {
            effects,
            drive,
            start: (0.0, 0.0),
            has_ground: true,
            has_film: true,
            steps: (1e-6, 2e-8),
        }
    }

    /// Runs for `duration` [s] with `rate` samples per second.
    pub fn run(&self, duration: f64, rate: f64) -> Run {
        let [m, b, k] = matrices();
        let mut machine = Machine {
            twin: self,
            m,
            b,
            k,
            plays: self.effects.memory.plays(),
            piece: self.drive.pieces(duration)[0],
            phase: Phase::Flight,
            sliding: 0.0,
            touch: None,
        };
        // Bent by a force on the mass: K y = [0, F].
        let (x, v) = self.start;
        let mut s = [0.0; 12];
        (s[0], s[1]) = (-k[0][1] / k[0][0] * x, x);
        machine.set_velocity(&mut s, v);
        (s[9], s[10]) = (s[1], s[0]);
        machine.run(s, duration, rate)
    }
}
