//! Missing forces as curves over one quantity, as a diagnosis and a force balance give them.

use serde::{Deserialize, Serialize};

use super::quantity::Quantity;
use crate::static_text::{self, StaticText};

/// Force that the baseline lacks, as measured, against one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ForceCurve {
    /// What it is drawn against.
    #[serde(deserialize_with = "static_text::one")]
    pub against: StaticText,
    /// SI unit of it.
    #[serde(deserialize_with = "static_text::one")]
    pub unit: StaticText,
    /// Middle of each bin.
    pub at: Vec<f64>,
    /// Mean force on the proof mass \[N\].
    pub force: Vec<f64>,
    /// Its standard error \[N\].
    pub std_error: Vec<f64>,
    /// Force of the named effects in the same bins \[N\]; empty if none acts as a force.
    pub law: Vec<f64>,
}

/// What of a curve the baseline's own coefficients take: the recordings do not determine it, and the
/// curve is drawn without it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Absorbed {
    /// Its mean: a push moves the zero of the spring.
    pub constant: bool,
    /// Its mean slope: it is a stiffness, a damping or a gain of the drive.
    pub slope: bool,
}

/// A missing force over one quantity by the force balance: with which force, linear between the
/// curve's places, the balance is met best if the force depends on this quantity alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BalanceCurve {
    /// The quantity.
    pub quantity: Quantity,
    /// The force at its places and that of the named effects, both without what is absorbed.
    pub curve: ForceCurve,
    /// What both are without.
    pub absorbed: Absorbed,
    /// Falls of chi2 that the curve brings, on fitted and held-out recordings; the latter 0 without any.
    pub gain: (f64, f64),
    /// Fall of chi2 on fitted recordings that chance brings: the curve's degrees of freedom.
    pub by_chance: usize,
    /// Whether the falls are beyond chance.
    pub is_significant: bool,
}

impl BalanceCurve {
    /// Gain by which curves are ranked: both splits count.
    pub fn total_gain(&self) -> f64 {
        self.gain.0 + self.gain.1 - self.by_chance as f64
    }
}

/// The missing force over each quantity by the force balance.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct BalanceForces {
    /// Before any effect is named.
    pub before: Vec<BalanceCurve>,
    /// With the named effects; empty without any.
    pub after: Vec<BalanceCurve>,
}

impl BalanceForces {
    /// The curve that brings most before any effect is named.
    pub fn strongest(&self) -> Option<&BalanceCurve> {
        let more = |a: &&BalanceCurve, b: &&BalanceCurve| a.total_gain().total_cmp(&b.total_gain());
        self.before.iter().max_by(more)
    }

    /// What is still missing over `quantity` with the named effects.
    pub fn after_over(&self, quantity: Quantity) -> Option<&BalanceCurve> {
        self.after.iter().find(|c| c.quantity == quantity)
    }
}
