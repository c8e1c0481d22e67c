//! `long_range_attraction`: the ground pulls before it is touched.
//!
//! Equation: `F = -A (h0 / (xp + dp + h0))^n`.
//! Source: power laws of surface forces, e.g. Israelachvili, Intermolecular and Surface
//! Forces, 2011, chapter 13.

use super::{
    Action, ContactLaw, EffectSpec, EvidenceFigure, Facts, FallOff, FormError, FoundBy, Kinematics,
    Motion, Need, Quantity, Search, Start,
};
use crate::model::parameter::{ParameterId, ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "long_range_attraction",
    name: "long-range attraction",
    sentence: "Charges or van der Waals forces pull the mass over the last micrometres before it touches.",
    law: "F = -A (h0 / (xp + dp + h0))^n",
    source: "power laws of surface forces, e.g. Israelachvili, Intermolecular and Surface Forces, 2011, chapter 13",
    needs: Need::Ground,
    parameters: &[
        ParameterSpec {
            id: "A",
            symbol: "A",
            name: "attraction at touch",
            unit: "N",
            default: 20e-9,
            range: (0.0, 200e-9),
            limits: (0.0, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "attraction when the mass touches the ground",
            equation: "F = -A (h0 / (xp + dp + h0))^n",
        },
        ParameterSpec {
            id: "h0",
            symbol: "h0",
            name: "range",
            unit: "m",
            default: 2e-6,
            range: (50e-9, 50e-6),
            limits: (1e-12, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "height over which the attraction falls off",
            equation: "F = -A (h0 / (xp + dp + h0))^n",
        },
        ParameterSpec {
            id: "n",
            symbol: "n",
            name: "exponent",
            unit: "",
            default: 2.0,
            range: (2.0, 6.0),
            limits: (0.5, 12.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "2 for a sphere on a plane, 3 for plates; many for what falls off as an exponential, as charge patches do",
            equation: "F = -A (h0 / (xp + dp + h0))^n",
        },
    ],
    build: |values, around| {
        Box::new(LongRangeAttraction {
            strength: values[0],
            range: values[1],
            exponent: values[2],
            dp: around.parameters[ParameterId::Dp],
        })
    },
    facts: Facts {
        strengths: &["A"],
        force_over_displacement: true,
        falls_off: Some(|values| FallOff {
            reach: values[1],
            exponent: values[2],
        }),
        // It makes slow bounces slower and pulls at the end of each contact.
        obscures: &[ContactLaw::Restitution, ContactLaw::Adhesion],
        feature_strength: Some("A"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        // From a sphere on a plane to what falls off as an exponential does.
        bounds: &[(2, (2.0, 12.0))],
        form_errors: |values, tolerance| {
            let values = tolerance.scaled(values, 0);
            vec![FormError::InWindows(values, Quantity::Displacement)]
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Displacement),
};

/// Three ranges, each for a sphere on a plane and for plates.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.has_ground {
        return Vec::new();
    }
    let ranges = [0.6e-6, 2e-6, 6e-6];
    let all = ranges.map(|range| [(range, 2.0), (range, 3.0)]).concat();
    let start = |(range, power)| Start::positive(&[3e-9, range, power], 0, &[0, 1]);
    all.into_iter()
        .map(|own| start(own).shaped_by(&[2]))
        .collect()
}

#[derive(Debug)]
struct LongRangeAttraction {
    strength: f64,
    range: f64,
    exponent: f64,
    dp: f64,
}

impl Action for LongRangeAttraction {
    fn does_nothing(&self) -> bool {
        self.strength == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        // On the ground, or in one that gives way, the mass is no nearer than in touch.
        let height = (at.xp + self.dp).max(0.0);
        -self.strength * (self.range / (height + self.range)).powf(self.exponent)
    }
}
