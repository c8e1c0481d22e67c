//! A trial device: structure, drive, film, ground, and the forces of whatever else it
//! conceals, as accelerations of its coordinates.

use super::integrator::{MAX_STATE, State};
use super::preisach::Preisach;
use super::structure::{Dofs, Structure, dot};
use super::terms::{Load, Now, Term};
use super::voltage::Piece;
use serde::Serialize;

/// Local error bound of positions \[m\] that the trials are made with.
pub const TOLERANCE: f64 = 2e-12;

/// How the ground answers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ground {
    /// Impulses and a rigid hold.
    Rigid,
    /// A linear spring \[N/m\] and damper \[N s/m\] glued to the mass until the bond tears.
    Bonded { stiffness: f64, damping: f64 },
    /// Hertz's law with Tsuji's damping `c d^(1/4) d'`, adhesion pulling while touching.
    Hertz { stiffness: f64, damping: f64 },
}

/// Restitution against the speed of approach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Restitution {
    /// Constant.
    Constant,
    /// The share `blend` follows plastic impact, `(v/v0)^(-1/4)` (Johnson).
    Plastic { blend: f64, v0: f64 },
    /// Viscoelastic: `1 - c ((v/v0)^(1/5) - 1)`.
    Viscoelastic { c: f64, v0: f64 },
}

/// Adhesion against contact time, in the share `blend` in place of the line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Adhesion {
    /// The line `Ca t + Ca0`.
    Line,
    /// `Ca0 + dF (1 - exp(-(t/tau)^beta))`, stretched for many bridges that fill at once.
    Stretched {
        blend: f64,
        rise: f64,
        tau: f64,
        beta: f64,
    },
    /// `Ca0 + b log(1 + t/tau)`.
    Logarithm { blend: f64, rise: f64, tau: f64 },
}

/// The gas under the mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Film {
    /// Incompressible.
    Viscous,
    /// The force follows with `tau`, longer for a thinner film as `(gap/(x + gp))^power`.
    Elastic { tau: f64, gap: f64, power: i32 },
}

/// `gc` in place of, or beside, the two branches.
#[derive(Debug, Clone, PartialEq)]
pub enum Gain {
    /// The two branches.
    Branches,
    /// The share `blend` from a sum of relays with a loop of `height`.
    Relays {
        sum: Box<Preisach>,
        blend: f64,
        height: f64,
    },
    /// The voltages below `width` \[V\] are lost.
    DeadZone { width: f64 },
}

/// Everything that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// Masses and springs.
    pub structure: Structure,
    /// Newton per unit of `gc`.
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
    /// The ground rises by this \[m\] ...
    pub ground_rise: f64,
    /// ... at this time \[s\].
    pub rise_time: f64,
    /// Contact law.
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

/// What the mass is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// In the air; the sign of dry friction's motion is kept so that it cannot chatter.
    Flight { direction: f64 },
    /// In the air, held by dry friction.
    Jammed,
    /// Held by a rigid ground since the time given \[s\].
    Held { since: f64 },
    /// On a compliant ground since the time given \[s\].
    Touching { since: f64 },
}

impl Phase {
    /// Whether the ground is involved.
    #[must_use]
    pub fn in_contact(self) -> bool {
        matches!(self, Phase::Held { .. } | Phase::Touching { .. })
    }
}

/// `gc` of the two branches of the paper's table.
#[must_use]
pub fn branch(v: f64, rising: bool) -> f64 {
    if rising {
        ((0.0016 * v - 0.0255) * v - 0.7057) * v + 1.4796
    } else {
        (0.0076 * v - 0.6062) * v - 0.6350
    }
}

impl Device {
    /// States: positions, velocities, then those of film and terms.
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

    /// Level of the ground \[m\] at `t` \[s\].
    #[must_use]
    pub fn level(&self, t: f64) -> f64 {
        if t >= self.rise_time {
            self.ground_rise - self.dp
        } else {
            -self.dp
        }
    }

    /// `gc` at `t` on a piece of the drive whose voltage is `v`.
    #[must_use]
    pub fn gc(&self, piece: &Piece, v: f64) -> f64 {
        match &self.gain {
            Gain::Branches => branch(v, piece.rising),
            Gain::Relays { sum, blend, height } => {
                let middle = 0.5 * (branch(v, true) + branch(v, false));
                let loops = middle + sum.deviation(piece, v, *height);
                (1.0 - blend) * branch(v, piece.rising) + blend * loops
            }
            Gain::DeadZone { width } => {
                let left = v - v.clamp(-*width, *width);
                branch(left, piece.rising)
            }
        }
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

    /// What the readings show before the sensor's offsets: a lagging sensor has states
    /// of its own.
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

    /// Adhesion \[N\] after `t` \[s\] of contact.
    #[must_use]
    pub fn adhesion(&self, t: f64) -> f64 {
        let t = t.max(0.0);
        let line = self.ca * t + self.ca0;
        match self.adhesion {
            Adhesion::Line => line,
            Adhesion::Stretched {
                blend,
                rise,
                tau,
                beta,
            } => {
                let law = self.ca0 + rise * (1.0 - (-(t / tau).powf(beta)).exp());
                line + blend * (law - line)
            }
            Adhesion::Logarithm { blend, rise, tau } => {
                let law = self.ca0 + rise * (t / tau).ln_1p();
                line + blend * (law - line)
            }
        }
    }

    /// Restitution at the speed of approach `v` \[m/s\], within 0 and 0.98.
    #[must_use]
    pub fn restitution(&self, v: f64) -> f64 {
        let v = v.abs().max(1e-6);
        let alpha = match self.restitution {
            Restitution::Constant => return self.alpha,
            Restitution::Plastic { blend, v0 } => {
                self.alpha * (1.0 - blend + blend * (v / v0).powf(-0.25))
            }
            Restitution::Viscoelastic { c, v0 } => {
                self.alpha * (1.0 - c * ((v / v0).powf(0.2) - 1.0))
            }
        };
        alpha.clamp(0.0, 0.98)
    }

    /// Forces that do not depend on the phase, then accelerations without the hold.
    /// Returns what pulls on the mass beside the structure \[N\].
    fn free(
        &self,
        t: f64,
        y: &State,
        piece: &Piece,
        phase: Phase,
        acceleration: &mut Dofs,
        rates: &mut State,
    ) -> f64 {
        let s = &self.structure;
        let n = s.n;
        let [xp, vp, xc, vc] = self.points(y);
        let v = piece.shape.at(t);
        let gc = self.gc(piece, v);
        let now = Now {
            t,
            xp,
            vp,
            xc,
            vc,
            v,
            gc,
            height: xp - self.level(t),
            newton_per_gc: self.eta,
        };
        let mut load = Load {
            gc,
            ..Load::default()
        };
        let flying = !phase.in_contact();
        let mut k = 2 * n;
        let gap = xp + self.gp;
        let viscous = self.cs * vp / (gap * gap * gap);
        match self.film {
            Film::Viscous => {
                if flying {
                    load.p -= viscous;
                }
            }
            Film::Elastic {
                tau,
                gap: reference,
                power,
            } => {
                let tau = (tau * (reference / gap.max(1e-7)).powi(power)).clamp(1e-6, 1.0);
                let drive = if flying { viscous } else { 0.0 };
                if flying {
                    load.p -= y[k];
                }
                rates[k] = (drive - y[k]) / tau;
                k += 1;
            }
        }
        for term in &self.terms {
            let end = k + term.states();
            term.act(&now, &y[k..end], &mut load, &mut rates[k..end]);
            k = end;
        }
        if let Phase::Flight { direction } = phase {
            load.p -= self.friction * direction;
        }
        if let Phase::Touching { since } = phase {
            load.p += self.ground_force(t, -now.height, -vp, since);
        }
        let drive = self.eta * load.gc;
        for i in 0..n {
            let mut a = s.push_drive[i] * drive + s.push_p[i] * load.p + s.push_c[i] * load.c
                - s.push_base[i] * load.base;
            for j in 0..n {
                a -= s.stiffness[i][j] * y[j] + s.damping[i][j] * y[n + j];
            }
            acceleration[i] = a;
        }
        load.p
    }

    /// Force of a compliant ground \[N\] at the depth `d` \[m\].
    fn ground_force(&self, t: f64, d: f64, rate: f64, since: f64) -> f64 {
        match self.ground {
            Ground::Rigid => 0.0,
            Ground::Bonded { stiffness, damping } => stiffness * d + damping * rate,
            Ground::Hertz { stiffness, damping } => {
                let d = d.max(0.0);
                let push = stiffness * d * d.sqrt() + damping * d.sqrt().sqrt() * rate;
                push - self.adhesion(t - since)
            }
        }
    }

    /// Time derivative of the state.
    pub fn flow(&self, t: f64, y: &State, piece: &Piece, phase: Phase, out: &mut State) {
        let s = &self.structure;
        let n = s.n;
        let mut acceleration = [0.0; super::structure::MAX_DOF];
        self.free(t, y, piece, phase, &mut acceleration, out);
        if matches!(phase, Phase::Held { .. } | Phase::Jammed) {
            let hold = -dot(n, &s.read_p, &acceleration) / s.mobility;
            for i in 0..n {
                acceleration[i] += hold * s.push_p[i];
            }
        }
        for i in 0..n {
            out[i] = y[n + i];
            out[n + i] = acceleration[i];
        }
    }

    /// Force that would keep the mass at rest \[N\], and what else than the structure
    /// pulls on it.
    #[must_use]
    pub fn hold(&self, t: f64, y: &State, piece: &Piece, phase: Phase) -> (f64, f64) {
        let s = &self.structure;
        let mut acceleration = [0.0; super::structure::MAX_DOF];
        let mut rates = [0.0; MAX_STATE];
        let load = self.free(t, y, piece, phase, &mut acceleration, &mut rates);
        (-dot(s.n, &s.read_p, &acceleration) / s.mobility, load)
    }

    /// Whether the bond to a compliant ground gives way: below zero when it has.
    #[must_use]
    pub fn bond(&self, t: f64, y: &State, since: f64) -> f64 {
        let [xp, ..] = self.points(y);
        let depth = self.level(t) - xp;
        match self.ground {
            Ground::Rigid => 1.0,
            // Depth is what tears: the damper's pull does not break the bond.
            Ground::Bonded { stiffness, .. } => depth + self.adhesion(t - since) / stiffness,
            Ground::Hertz { .. } => depth,
        }
    }

    /// Changes the velocity of the mass by `change` \[m/s\] with an impulse on it alone.
    pub fn kick(&self, y: &mut State, change: f64) {
        let s = &self.structure;
        for i in 0..s.n {
            y[s.n + i] += s.push_p[i] * change / s.mobility;
        }
    }

    /// Moves the mass by `change` \[m\] as a force on it alone would.
    pub fn shift(&self, y: &mut State, change: f64) {
        let s = &self.structure;
        for i in 0..s.n {
            y[i] += s.push_p[i] * change / s.mobility;
        }
    }
}
