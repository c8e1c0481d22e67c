//! Laws of ground, restitution, adhesion, film and drive: those of the baseline device, and those
//! that replace them.

use serde::Serialize;

use super::Device;
use crate::trial::concealed::preisach::Preisach;
use crate::trial::hybrid::integrator::State;
use crate::trial::voltage::Piece;

/// Law of the ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ground {
    /// Bounces by impulses, and a rigid hold.
    Rigid,
    /// A linear spring \[N/m\] and damper \[N s/m\]. They are bonded to the mass until the bond
    /// tears.
    Bonded { stiffness: f64, damping: f64 },
    /// Hertz's law with Tsuji's damping `c d^(1/4) d'`. Adhesion pulls during contact.
    Hertz { stiffness: f64, damping: f64 },
}

/// Restitution as a function of the approach speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Restitution {
    /// Constant.
    Constant,
    /// A share `blend` follows plastic impact, `(v/v0)^(-1/4)` (Johnson).
    Plastic { blend: f64, v0: f64 },
    /// Viscoelastic: `1 - c ((v/v0)^(1/5) - 1)`.
    Viscoelastic { c: f64, v0: f64 },
}

/// Adhesion as a function of contact time. A share `blend` of the law replaces the line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Adhesion {
    /// The line `Ca t + Ca0`.
    Line,
    /// `Ca0 + dF (1 - exp(-(t/tau)^beta))`, a stretched exponential: many bridges fill at
    /// once.
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
    /// The force follows with the time constant `tau`, which grows in a thinner film as
    /// `(gap/(x + gp))^power`.
    Elastic { tau: f64, gap: f64, power: i32 },
}

/// Law of `gc`: the two branches, or a law that replaces or modifies them.
#[derive(Debug, Clone, PartialEq)]
pub enum Gain {
    /// The two branches.
    Branches,
    /// A share `blend` is a sum of relays with a loop of `height`.
    Relays {
        sum: Box<Preisach>,
        blend: f64,
        height: f64,
    },
    /// A dead zone: voltages below `width` \[V\] have no effect.
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

    /// `gc` on a piece of the drive, at the voltage `v`.
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

    /// Restitution at the approach speed `v` \[m/s\], limited to 0 to 0.98.
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

    /// Margin of the bond to a compliant ground. Below zero the bond has torn.
    #[must_use]
    pub fn bond(&self, t: f64, y: &State, since: f64) -> f64 {
        let [xp, ..] = self.points(y);
        let depth = self.level(t) - xp;
        match self.ground {
            Ground::Rigid => 1.0,
            // Only the spring's extension tears the bond, not the damper's force.
            Ground::Bonded { stiffness, .. } => depth + self.adhesion(t - since) / stiffness,
            Ground::Hertz { .. } => depth,
        }
    }
}
