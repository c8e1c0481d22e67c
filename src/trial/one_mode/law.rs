//! Laws that a one-mode device may conceal, as accelerations.

use std::f64::consts::TAU;

use serde::Serialize;

/// One law with its strength. SI, per unit of mass.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OneModeLaw {
    /// `-c v |v|`, c \[1/m\].
    QuadraticDrag { c: f64 },
    /// `a` against the motion \[m/s^2\]; holds up to that at rest.
    DryFriction { a: f64 },
    /// `m |x|` against the motion, m \[1/s^2\]: a contact that the spring loads.
    LoadFriction { m: f64 },
    /// `-k x^3`, k \[1/(m^2 s^2)\].
    CubicStiffness { k: f64 },
    /// `-k x^2`, k \[1/(m s^2)\].
    EvenStiffness { k: f64 },
    /// `w^2 sin(b x)/b` in place of `w^2 x`; b \[1/m\].
    SineStiffness { b: f64, omega: f64 },
    /// Damping below zero around one position: `c v exp(-((x - at)/width)^2)`, c \[1/s\].
    NegativeDamping { c: f64, at: f64, width: f64 },
    /// A stiffness that comes and goes: `-k sin(2 pi f t) x`, k \[1/s^2\].
    PumpedStiffness { k: f64, frequency: f64 },
    /// Gusts `a u exp(1 - u)`, `u` the time since their begin over `tau`; begins \[s\] for each run.
    Gusts {
        a: f64,
        tau: f64,
        begins: Vec<Vec<f64>>,
    },
}

impl OneModeLaw {
    /// The same law `s` times as strong: its force, while it is small, is `s` times as large.
    #[must_use]
    pub fn scaled(&self, s: f64) -> Self {
        let mut law = self.clone();
        match &mut law {
            Self::QuadraticDrag { c } | Self::NegativeDamping { c, .. } => *c *= s,
            Self::DryFriction { a } | Self::Gusts { a, .. } => *a *= s,
            Self::LoadFriction { m } => *m *= s,
            Self::CubicStiffness { k }
            | Self::EvenStiffness { k }
            | Self::PumpedStiffness { k, .. } => *k *= s,
            // Its deviation from the line grows with the square.
            Self::SineStiffness { b, .. } => *b *= s.sqrt(),
        }
        law
    }

    /// Acceleration \[m/s^2\] of run number `run` at `t` \[s\], without dry friction.
    #[must_use]
    pub fn acceleration(&self, run: usize, t: f64, x: f64, v: f64) -> f64 {
        match self {
            Self::QuadraticDrag { c } => -c * v * v.abs(),
            Self::DryFriction { .. } | Self::LoadFriction { .. } => 0.0,
            Self::CubicStiffness { k } => -k * x * x * x,
            Self::EvenStiffness { k } => -k * x * x,
            Self::SineStiffness { b, omega } if b.abs() * x.abs() > 1e-4 => {
                omega * omega * (x - (b * x).sin() / b)
            }
            // The difference of nearly equal numbers, by its series.
            Self::SineStiffness { b, omega } => omega * omega * b * b * x * x * x / 6.0,
            Self::NegativeDamping { c, at, width } => {
                let u = (x - at) / width;
                c * v * (-u * u).exp()
            }
            Self::PumpedStiffness { k, frequency } => -k * (TAU * frequency * t).sin() * x,
            Self::Gusts { a, tau, begins } => begins
                .get(run)
                .into_iter()
                .flatten()
                .map(|begin| {
                    let u = ((t - begin) / tau).max(0.0);
                    a * u * (1.0 - u).exp()
                })
                .sum(),
        }
    }

    /// Whether it is a friction, which holds a mass at rest.
    #[must_use]
    pub fn is_friction(&self) -> bool {
        matches!(self, Self::DryFriction { .. } | Self::LoadFriction { .. })
    }

    /// Dry friction at `x` \[m\] against the motion \[m/s^2\].
    #[must_use]
    pub fn friction(&self, x: f64) -> f64 {
        match self {
            Self::DryFriction { a } => *a,
            Self::LoadFriction { m } => m * x.abs(),
            _ => 0.0,
        }
    }

    /// Largest acceleration at displacements up to `reach` \[m\] and speeds up to `speed` \[m/s\].
    #[must_use]
    pub fn size(&self, reach: f64, speed: f64) -> f64 {
        match self {
            Self::DryFriction { a } | Self::Gusts { a, .. } => a.abs(),
            Self::LoadFriction { m } => m.abs() * reach,
            Self::NegativeDamping { c, .. } => c.abs() * speed,
            Self::PumpedStiffness { k, .. } => k.abs() * reach,
            _ => self.acceleration(0, 0.0, reach, speed).abs(),
        }
    }
}
