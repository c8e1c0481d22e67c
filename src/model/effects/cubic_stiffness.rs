//! `cubic_stiffness`: a spring that hardens or softens with deflection, less or more so the
//! further it goes.
//!
//! Equation: `F = -k3 xp^3 - k5 xp^5`.
//! Source: Duffing's oscillator, e.g. Nayfeh and Mook, Nonlinear Oscillations, 1979.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Kinematics, Motion, Need,
    Quantity, Search, Start,
};
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
            meaning: "quintic term; opposite in sign to k3 if the spring levels off",
            equation: "F = -k3 xp^3 - k5 xp^5",
        },
    ],
    build: |values, _| {
        Box::new(CubicStiffness {
            k3: values[0],
            k5: values[1],
        })
    },
    facts: Facts {
        strengths: &["k3", "k5"],
        force_over_displacement: true,
        feature_strength: Some("k3"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        // Both terms are one force.
        form_errors: |values, tolerance| {
            let values = values.iter().map(|k| tolerance.share * k).collect();
            vec![FormError::InWindows(values, Quantity::Displacement)]
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Displacement),
};

/// A cubic term; the quintic one shapes it, unless a fit's step of that is too large for a device
/// that moves by centimetres.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.is_sprung {
        return Vec::new();
    }
    let k3 = 1e-3 * motion.force / motion.length.powi(3);
    vec![Start {
        shape: &[1],
        shape_force: Some(motion.length.powi(5)),
        ..Start::signed(&[k3, 0.0], 0, &[0])
    }]
}

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
