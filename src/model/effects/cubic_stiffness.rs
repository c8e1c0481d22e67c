//! `cubic_stiffness`: a spring that hardens or softens with deflection, less or more so the
//! further it goes.

use super::{Action, EffectSpec, Kinematics, Need};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "cubic_stiffness",
    name: "cubic stiffness",
    sentence: "The spring hardens (or softens) with deflection, so that the frequency of a ring changes with its size.",
    law: "F = -k3 xp^3 - k5 xp^5",
    source: "Duffing's oscillator, e.g. Nayfeh and Mook, Nonlinear Oscillations, 1979",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "k3",
            symbol: "k3",
            name: "cubic stiffness",
            unit: "N/m^3",
            default: 2e4,
            range: (-1e5, 1e5),
            limits: (-1e15, 1e15),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "force per cubed displacement of the proof mass; negative softens",
            equation: "F = -k3 xp^3 - k5 xp^5",
        },
        ParameterSpec {
            id: "k5",
            symbol: "k5",
            name: "quintic stiffness",
            unit: "N/m^5",
            default: 0.0,
            range: (-1e12, 1e12),
            limits: (-1e25, 1e25),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "the next term: of the other sign than k3 where the spring levels off",
            equation: "F = -k3 xp^3 - k5 xp^5",
        },
    ],
    build: |values, _| {
        Box::new(CubicStiffness {
            k3: values[0],
            k5: values[1],
        })
    },
};

#[derive(Debug)]
struct CubicStiffness {
    k3: f64,
    k5: f64,
}

impl Action for CubicStiffness {
    fn does_nothing(&self) -> bool {
        self.k3 == 0.0 && self.k5 == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        let square = at.xp * at.xp;
        -(self.k3 + self.k5 * square) * square * at.xp
    }
}
