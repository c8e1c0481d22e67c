//! `electrostatic`: attraction between the driven electrode and the ground.
//!
//! Equation: `F = -1/2 eps0 A V^2 / (xp + g)^2`.
//! Source: parallel plates, e.g. Senturia, Microsystem Design, 2001, section 6.4.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Kinematics, Motion, Need,
    Quantity, Search, Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// Vacuum permittivity [F/m], CODATA 2018.
const EPSILON_0: f64 = 8.854_187_812_8e-12;
/// The plates are never nearer than this share of the gap: the force stays finite.
const NEAREST: f64 = 1e-3;

/// Least distance of the electrodes at contact \[m\].
const LEAST_GAP: f64 = 2e-6;

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "electrostatic",
    name: "electrostatic attraction",
    sentence: "The voltage pulls the proof mass to the ground, whatever its sign, and the more the nearer it is.",
    law: "F = -1/2 eps0 A V^2 / (xp + g)^2",
    source: "parallel plates, e.g. Senturia, Microsystem Design, 2001, section 6.4",
    needs: Need::Drive,
    parameters: &[
        ParameterSpec {
            id: "A",
            symbol: "A",
            name: "effective area",
            unit: "m^2",
            default: 9e-8,
            range: (1e-10, 1e-6),
            limits: (0.0, 1.0),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "area of the facing electrodes, less what is shielded; cantilever and mass have 9e-8 m^2",
            equation: "F = -1/2 eps0 A V^2 / (xp + g)^2",
        },
        ParameterSpec {
            id: "g",
            symbol: "g",
            name: "electrode gap",
            unit: "m",
            default: 100e-6,
            range: (60e-6, 300e-6),
            limits: (1e-9, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "distance of the electrodes when the proof mass is at its zero position; beyond dp",
            equation: "F = -1/2 eps0 A V^2 / (xp + g)^2",
        },
    ],
    build: |values, _| {
        Box::new(Electrostatic {
            strength: 0.5 * EPSILON_0 * values[0],
            gap: values[1],
        })
    },
    facts: Facts {
        strengths: &["A"],
        force_over_displacement: true,
        feature_strength: Some("A"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        // The electrodes are apart even where the mass touches the ground.
        least_constant: |motion| motion.contact_distance + LEAST_GAP,
        form_errors: |values, tolerance| {
            [Quantity::Displacement, Quantity::Voltage]
                .map(|over| FormError::InWindows(tolerance.scaled(values, 0), over))
                .to_vec()
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Voltage),
};

/// Electrodes at different distances when the mass touches.
fn starts(motion: &Motion) -> Vec<Start> {
    if !(motion.is_driven && motion.has_ground) {
        return Vec::new();
    }
    let at = |above| Start::positive(&[9e-9, motion.contact_distance + above], 0, &[0, 1]);
    [6e-6, 15e-6, 35e-6, 100e-6].map(at).to_vec()
}

#[derive(Debug)]
struct Electrostatic {
    strength: f64,
    gap: f64,
}

impl Action for Electrostatic {
    fn does_nothing(&self) -> bool {
        self.strength == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        let distance = (at.xp + self.gap).max(NEAREST * self.gap);
        -self.strength * (at.voltage / distance).powi(2)
    }
}
