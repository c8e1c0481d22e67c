//! `gravity`: the weight of the proof mass.
//!
//! Equation: `F = -m g`.
//! Source: standard gravity, CGPM 1901.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FoundBy, Kinematics, Need, Quantity, Search, Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "gravity",
    name: "gravity",
    sentence: "The weight of the proof mass pulls it down; on a spring it only moves the zero.",
    law: "F = -m g",
    source: "standard gravity, CGPM 1901",
    needs: Need::Nothing,
    parameters: &[ParameterSpec {
        id: "g",
        symbol: "g",
        name: "acceleration of gravity",
        unit: "m/s^2",
        default: 9.80665,
        range: (-20.0, 20.0),
        limits: (-1e6, 1e6),
        scale: Scale::Linear,
        rank: Rank::Advanced,
        meaning: "downward acceleration; negative when the rig is turned over",
        equation: "F = -m g",
    }],
    build: |values, around| {
        Box::new(Gravity {
            weight: around.structure.proof_mass * values[0],
        })
    },
    facts: Facts {
        strengths: &["g"],
        ..Facts::DEFAULT
    },
    search: Search {
        // On a spring it only moves the zero.
        found_by: FoundBy::Starts(|motion| {
            let start = (!motion.is_sprung).then(|| Start::signed(&[1.0], 0, &[0]));
            start.into_iter().collect()
        }),
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Displacement),
};

#[derive(Debug)]
struct Gravity {
    weight: f64,
}

impl Action for Gravity {
    fn does_nothing(&self) -> bool {
        self.weight == 0.0
    }

    fn force_on_proof_mass(&self, _at: &Kinematics, _z: &[f64]) -> f64 {
        -self.weight
    }
}
