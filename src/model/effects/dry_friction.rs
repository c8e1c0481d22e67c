//! `dry_friction`: a constant force against the motion of the mass.
//!
//! Equation: `F = -fc sign(xp'), |F| <= fc at rest`.
//! Source: Coulomb friction, e.g. den Hartog, Mechanical Vibrations, 1934, section 8.4.
//!
//! The jump of the force where the motion turns is met as an event, not smoothed over: a
//! mass whose velocity comes to zero goes on the other way, or stays where it is until the
//! structure pulls it with more than `fc`. On the ground friction adds to adhesion.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Need, Quantity, Search, Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "dry_friction",
    name: "dry friction",
    sentence: "A constant force opposes the motion: a ring decays linearly, and small forces no longer move the mass.",
    law: "F = -fc sign(xp'),  |F| <= fc at rest",
    source: "Coulomb friction, e.g. den Hartog, Mechanical Vibrations, 1934, section 8.4",
    needs: Need::Nothing,
    parameters: &[ParameterSpec {
        id: "fc",
        symbol: "fc",
        name: "friction",
        unit: "N",
        default: 5e-9,
        range: (0.0, 50e-9),
        limits: (0.0, 1e9),
        scale: Scale::Linear,
        rank: Rank::Advanced,
        meaning: "force against the motion of the proof mass, whatever its speed",
        equation: "F = -fc sign(xp')",
    }],
    build: |values, _| Box::new(DryFriction { force: values[0] }),
    facts: Facts {
        strengths: &["fc"],
        friction_force: Some(0),
        feature_strength: Some("fc"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(|motion| {
            // A free mass rubs against nothing.
            let held = motion
                .is_sprung
                .then(|| Start::positive(&[1e-3 * motion.force], 0, &[0]));
            held.into_iter().collect()
        }),
        form_errors: |values, tolerance| {
            let force = tolerance.share * values[0];
            vec![FormError::ForceInWindows(force, Quantity::Velocity)]
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Velocity),
};

#[derive(Debug)]
struct DryFriction {
    force: f64,
}

impl Action for DryFriction {
    fn does_nothing(&self) -> bool {
        self.force == 0.0
    }

    fn acts_on_motion(&self) -> bool {
        // Other than by its force, which is the same as long as the mass slides one way.
        false
    }

    fn friction(&self, _xp: f64) -> f64 {
        self.force
    }
}
