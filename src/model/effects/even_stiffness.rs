//! `even_stiffness`: a spring that is stiffer on one side of its zero than on the other.
//!
//! Equation: `F = -k2 xp^2`.
//! Source: the quadratic (Helmholtz) oscillator, e.g. Nayfeh and Mook, Nonlinear Oscillations, 1979.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Kinematics, Motion, Need,
    Quantity, Search, Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "even_stiffness",
    name: "even stiffness",
    sentence: "The spring is stiffer on one side than on the other, so that a ring swings farther to the soft side the larger it is.",
    law: "F = -k2 xp^2",
    source: "the quadratic (Helmholtz) oscillator, e.g. Nayfeh and Mook, Nonlinear Oscillations, 1979",
    needs: Need::Nothing,
    parameters: &[ParameterSpec {
        id: "k2",
        symbol: "k2",
        name: "even stiffness",
        unit: "N/m^2",
        default: 1.0,
        range: (-5.0, 5.0),
        limits: (-1e15, 1e15),
        scale: Scale::Linear,
        rank: Rank::Advanced,
        meaning: "downward force per squared displacement of the proof mass; negative pushes up",
        equation: "F = -k2 xp^2",
    }],
    build: |values, _| Box::new(EvenStiffness { k2: values[0] }),
    facts: Facts {
        strengths: &["k2"],
        force_over_displacement: true,
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        form_errors: |values, tolerance| {
            let values = tolerance.scaled(values, 0);
            vec![FormError::InWindows(values, Quantity::Displacement)]
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Displacement),
};

/// A thousandth of the force at the largest displacement, on a device with a spring.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.is_sprung {
        return Vec::new();
    }
    let k2 = 1e-3 * motion.force / motion.length.powi(2);
    vec![Start::signed(&[k2], 0, &[0])]
}

#[derive(Debug)]
struct EvenStiffness {
    k2: f64,
}

impl Action for EvenStiffness {
    fn does_nothing(&self) -> bool {
        self.k2 == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        -self.k2 * at.xp * at.xp
    }
}
