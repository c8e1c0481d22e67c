//! `quadratic_drag`: inertial drag of the gas on the proof mass, `-cd xp' |xp'|`, with a linear part
//! where no spring's damping has it.
//!
//! Equation: `F = -cd xp' |xp'| - c xp'`.
//! Source: drag at high Reynolds number, e.g. Landau and Lifshitz, Fluid Mechanics, section
//! 45.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Kinematics, Need, Quantity,
    Search, Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "quadratic_drag",
    name: "quadratic drag",
    sentence: "The gas brakes fast motion more than in proportion, so that a large ring dies away faster than a small one.",
    law: "F = -cd xp' |xp'| - c xp'",
    source: "drag at high Reynolds number, e.g. Landau and Lifshitz, Fluid Mechanics, section 45",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "cd",
            symbol: "cd",
            name: "drag coefficient",
            unit: "N s^2/m^2",
            default: 1e-7,
            range: (1e-9, 1e-5),
            limits: (0.0, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "force per squared velocity; air alone gives 2e-8 to 5e-8 on this plate",
            equation: "F = -cd xp' |xp'| - c xp'",
        },
        ParameterSpec {
            id: "c",
            symbol: "c",
            name: "linear drag coefficient",
            unit: "N s/m",
            default: 0.0,
            range: (1e-9, 1e-5),
            limits: (0.0, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "force per velocity at low speed; on a spring the damping of its mode has the same part",
            equation: "F = -cd xp' |xp'| - c xp'",
        },
    ],
    build: |values, _| {
        Box::new(QuadraticDrag {
            cd: values[0],
            c: values[1],
        })
    },
    facts: Facts {
        strengths: &["cd"],
        feature_strength: Some("cd"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(|motion| {
            let cd = 1e-3 * motion.force / motion.speed.powi(2);
            // The damping of a spring's mode has the linear part already.
            if motion.is_sprung {
                return vec![Start::positive(&[cd, 0.0], 0, &[0])];
            }
            let c = 1e-3 * motion.force / motion.speed;
            vec![
                Start::positive(&[cd, 1e-3 * c], 0, &[0, 1]),
                Start::positive(&[1e-3 * cd, c], 1, &[0, 1]),
            ]
        }),
        form_errors: |values, tolerance| {
            [Quantity::Velocity, Quantity::Displacement]
                .map(|over| FormError::InWindows(tolerance.scaled(values, 0), over))
                .to_vec()
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Velocity),
};

#[derive(Debug)]
struct QuadraticDrag {
    cd: f64,
    c: f64,
}

impl Action for QuadraticDrag {
    fn does_nothing(&self) -> bool {
        self.cd == 0.0 && self.c == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        -(self.cd * at.vp.abs() + self.c) * at.vp
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_parts_oppose_the_motion() {
        let drag = QuadraticDrag { cd: 2.0, c: 3.0 };
        for (vp, force) in [(4.0, -44.0), (-4.0, 44.0), (0.0, 0.0)] {
            let at = Kinematics {
                vp,
                ..Kinematics::default()
            };
            assert!((drag.force_on_proof_mass(&at, &[]) - force).abs() < 1e-12);
        }
    }
}
