//! Contact with the ground: restitution, adhesion and pull-off, eqs (11)-(14).

use super::parameter::{ParameterId, Parameters};

/// The rigid, adhesive ground below the proof mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Contact level, `-dp` \[m\].
    pub level: f64,
    /// Coefficient of restitution, eq (12).
    pub alpha: f64,
    /// Growth of adhesion with contact time, `Ca` [N/s].
    pub adhesion_rate: f64,
    /// Adhesion at touch, `Ca0` \[N\].
    pub adhesion_start: f64,
}

impl Ground {
    /// Reads `dp`, `alpha`, `Ca` and `Ca0`.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            level: -parameters[ParameterId::Dp],
            alpha: parameters[ParameterId::Alpha],
            adhesion_rate: parameters[ParameterId::Ca],
            adhesion_start: parameters[ParameterId::Ca0],
        }
    }

    /// Adhesion \[N\] after `contact_time` \[s\] of contact, eq (14).
    pub fn adhesion(&self, contact_time: f64) -> f64 {
        self.adhesion_rate * contact_time + self.adhesion_start
    }
}
