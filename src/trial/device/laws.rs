//! Laws of ground, restitution, adhesion, film and drive: those of the plain device and
//! those that stand in their place.

use serde::Serialize;

use super::Device;
use crate::trial::concealed::preisach::Preisach;
use crate::trial::hybrid::integrator::State;
use crate::trial::voltage::Piece;

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

/// `gc` in place of, or together with, the two branches.
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

    /// Force of a compliant ground \[N\] at the depth `d` \[m\].
    pub(crate) fn ground_force(&self, t: f64, d: f64, rate: f64, since: f64) -> f64 {
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
}
