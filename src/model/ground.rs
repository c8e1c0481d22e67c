//! Contact with the ground: restitution, adhesion and pull-off, eqs (11)-(14), and the rule by
//! which the mass bounces or sticks.

use serde::{Deserialize, Serialize};

use super::parameter::{ParameterId, Parameters};

/// Which arrivals at the ground are bounces. A mass that does not bounce is held until the pull-off
/// force exceeds the adhesion, whatever the rule.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BounceRule {
    /// The paper's: it bounces if the structure pulls it off with more than the adhesion right
    /// after the bounce. A mass that something presses onto the ground sticks at any speed.
    #[default]
    PullOff,
    /// It rebounds with `alpha` from every arrival that is fast enough, and from those of the
    /// paper's rule.
    Restitution(StickSpeed),
}

/// Up to which speed of arrival a mass sticks that rebounds by restitution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StickSpeed {
    /// The speed itself [m/s], not negative.
    Given(f64),
    /// The speed whose rebound has the energy of the adhesion at touch over this distance \[m\], not
    /// negative: `alpha v = sqrt(2 Ca0 h / m)`, `m` the mass that an impulse on the proof mass
    /// moves.
    AdhesionOver(f64),
}

impl Default for StickSpeed {
    /// An adhesion without reach, which takes no energy.
    fn default() -> Self {
        Self::AdhesionOver(0.0)
    }
}

impl BounceRule {
    /// Whether it is the paper's.
    pub fn is_pull_off(&self) -> bool {
        *self == Self::PullOff
    }

    /// The rule in words, for a window or a report.
    pub fn sentence(&self) -> String {
        let write = |v, unit| super::unit::format_quantity(v, unit, 3);
        match *self {
            Self::PullOff => "bounces if the structure pulls it off at once".to_owned(),
            Self::Restitution(StickSpeed::Given(speed)) => {
                format!("rebounds from arrivals above {}", write(speed, "m/s"))
            }
            Self::Restitution(StickSpeed::AdhesionOver(0.0)) => {
                "rebounds from every arrival".to_owned()
            }
            Self::Restitution(StickSpeed::AdhesionOver(reach)) => format!(
                "rebounds if it overcomes the adhesion over {}",
                write(reach, "m")
            ),
        }
    }
}

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
