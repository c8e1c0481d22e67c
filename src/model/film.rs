//! Squeeze film of gas between proof mass and ground, eq (10).

use super::parameter::{ParameterId, Parameters};

/// The gas film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SqueezeFilm {
    /// `Cs` [N m^2 s].
    pub coefficient: f64,
    /// `gp`, thickness at the zero position \[m\].
    pub gap: f64,
}

impl SqueezeFilm {
    /// Reads `Cs` and `gp`.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            coefficient: parameters[ParameterId::Cs],
            gap: parameters[ParameterId::Gp],
        }
    }

    /// Force on the proof mass \[N\] at displacement `xp` \[m\] and velocity `vp` [m/s].
    /// It opposes the motion. Singular at `xp = -gp`: not finite there.
    #[inline]
    pub fn force(&self, xp: f64, vp: f64) -> f64 {
        let thickness = xp + self.gap;
        -self.coefficient * vp / (thickness * thickness * thickness)
    }
}
