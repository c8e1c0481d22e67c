//! `velocity_restitution`: bounces that lose more the faster they are.
//!
//! Equation: `alpha(v) = alpha (v / v0)^-n, at most 1`.
//! Source: plastic contact, n = 1/4: Johnson, Contact Mechanics, 1985, section 11.5.

use super::{
    Action, ContactLaw, EffectSpec, EventFigure, EvidenceFigure, Facts, FoundBy, Need, Search,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "velocity_restitution",
    name: "velocity-dependent restitution",
    sentence: "A fast impact keeps a smaller share of its speed than a slow one.",
    law: "alpha(v) = alpha (v / v0)^-n, at most 1",
    source: "plastic contact, n = 1/4: Johnson, Contact Mechanics, 1985, section 11.5",
    needs: Need::Ground,
    parameters: &[
        ParameterSpec {
            id: "n",
            symbol: "n",
            name: "exponent",
            unit: "",
            default: 0.25,
            range: (-0.5, 0.5),
            limits: (-4.0, 4.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "0 is constant restitution, 1/4 plastic contact; negative loses less when fast",
            equation: "alpha(v) = alpha (v / v0)^-n",
        },
        ParameterSpec {
            id: "v0",
            symbol: "v0",
            name: "reference speed",
            unit: "m/s",
            default: 0.1,
            range: (1e-3, 1.0),
            limits: (1e-9, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "approach speed at which the restitution is alpha",
            equation: "alpha(v) = alpha (v / v0)^-n",
        },
    ],
    build: |values, _| {
        Box::new(VelocityRestitution {
            exponent: values[0],
            reference: values[1],
        })
    },
    facts: Facts {
        strengths: &["n"],
        feature_strength: Some("n"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::ContactEvents(ContactLaw::Restitution),
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Events(EventFigure::Restitution),
};

#[derive(Debug)]
struct VelocityRestitution {
    exponent: f64,
    reference: f64,
}

impl Action for VelocityRestitution {
    fn does_nothing(&self) -> bool {
        self.exponent == 0.0
    }

    fn acts_on_motion(&self) -> bool {
        false
    }

    fn restitution(&self, alpha: f64, speed: f64) -> f64 {
        if self.exponent == 0.0 || speed <= 0.0 {
            return alpha;
        }
        // No impact gains speed.
        (alpha * (speed / self.reference).powf(-self.exponent)).min(1.0)
    }
}
