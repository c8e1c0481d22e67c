//! A trial device: structure, drive, film, ground and concealed forces, as accelerations of its
//! coordinates.

pub mod beam;
pub(crate) mod flow;
pub(crate) mod laws;
pub mod reference_device;
pub mod structure;

pub use self::laws::{Adhesion, Film, Gain, Ground, Restitution, branch};

use self::structure::{Structure, dot};
use super::concealed::hidden_forces::Term;
use super::hybrid::integrator::{MAX_STATE, State};

/// Local error bound of positions in the trials \[m\].
pub const TOLERANCE: f64 = 2e-12;

/// A device with all its laws.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// Masses and springs.
    pub structure: Structure,
    /// Drive gain \[N per unit of `gc`\].
    pub eta: f64,
    /// Film coefficient \[N m^2 s\].
    pub cs: f64,
    /// Film gap at zero \[m\].
    pub gp: f64,
    /// Distance of the ground \[m\].
    pub dp: f64,
    /// Restitution.
    pub alpha: f64,
    /// Growth of adhesion \[N/s\].
    pub ca: f64,
    /// Adhesion at touch \[N\].
    pub ca0: f64,
    /// Dry friction on the mass \[N\].
    pub friction: f64,
    /// Height of a step of the ground \[m\].
    pub ground_rise: f64,
    /// Time of that step \[s\].
    pub rise_time: f64,
    /// Law of the ground.
    pub ground: Ground,
    /// Restitution law.
    pub restitution: Restitution,
    /// Adhesion law.
    pub adhesion: Adhesion,
    /// Film law.
    pub film: Film,
    /// Drive law.
    pub gain: Gain,
    /// Further forces.
    pub terms: Vec<Term>,
}

/// Phase of the proof mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// In flight. The direction of sliding is stored, so that dry friction cannot chatter.
    Flight { direction: f64 },
    /// Held by dry friction, above the ground.
    Jammed,
    /// Held by a rigid ground since the time given \[s\].
    Held { since: f64 },
    /// On a compliant ground since the time given \[s\].
    Touching { since: f64 },
}

impl Phase {
    /// Whether the mass is in contact with the ground.
    #[must_use]
    pub fn in_contact(self) -> bool {
        matches!(self, Phase::Held { .. } | Phase::Touching { .. })
    }
}

impl Device {
    /// Number of states: positions, velocities, then those of film and concealed forces.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.first_term_state() + self.terms.iter().map(Term::states).sum::<usize>()
    }

    fn first_term_state(&self) -> usize {
        2 * self.structure.n + usize::from(self.film != Film::Viscous)
    }

    /// Local error bounds of all states for positions known to `tolerance` \[m\].
    #[must_use]
    pub fn tolerances(&self, tolerance: f64) -> State {
        let s = &self.structure;
        let mut out = [1.0; MAX_STATE];
        for i in 0..s.n {
            let seen = s.read_p[i].abs().max(s.read_c[i].abs()).max(1e-12);
            out[i] = tolerance / seen;
            out[s.n + i] = out[i] * 3e4;
        }
        let mut k = 2 * s.n;
        if self.film != Film::Viscous {
            out[k] = 0.1 * tolerance;
            k += 1;
        }
        for term in &self.terms {
            for _ in 0..term.states() {
                out[k] = term.state_tolerance(tolerance);
                k += 1;
            }
        }
        out
    }

    /// Proof mass and cantilever: positions and velocities.
    #[must_use]
    pub fn points(&self, y: &State) -> [f64; 4] {
        let s = &self.structure;
        [
            dot(s.n, &s.read_p, y),
            dot(s.n, &s.read_p, &y[s.n..]),
            dot(s.n, &s.read_c, y),
            dot(s.n, &s.read_c, &y[s.n..]),
        ]
    }

    /// The readings without the sensor's offsets. A lagging sensor has states of its own.
    #[must_use]
    pub fn readings(&self, y: &State) -> (f64, f64) {
        let mut k = self.first_term_state();
        for term in &self.terms {
            if let Term::SensorLag { .. } = term {
                return (y[k], y[k + 1]);
            }
            k += term.states();
        }
        let [xp, _, xc, _] = self.points(y);
        (xp, xc)
    }

    /// Changes the velocity of the mass by `change` \[m/s\] with an impulse on it alone.
    pub fn kick(&self, y: &mut State, change: f64) {
        let s = &self.structure;
        for i in 0..s.n {
            y[s.n + i] += s.push_p[i] * change / s.mobility;
        }
    }

    /// Moves the mass by `change` \[m\], as a force on it alone would.
    pub fn shift(&self, y: &mut State, change: f64) {
        let s = &self.structure;
        for i in 0..s.n {
            y[i] += s.push_p[i] * change / s.mobility;
        }
    }
}
