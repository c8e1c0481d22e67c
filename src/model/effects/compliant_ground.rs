//! `compliant_ground`: a ground into which the mass sinks, in place of the rigid stop.
//!
//! Equation: `F = k d^1.5 (1 + chi d') - f_a, d = -dp - xp > 0`.
//! Source: Hunt and Crossley, J. Appl. Mech. 42, 440 (1975); adhesion as a constant pull-off
//! force while touching: Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53, 314
//! (1975).
//!
//! Contact is then a stretch of motion with a force: the reaction pushes, adhesion pulls
//! with `f_a` of eq (14) for as long as the mass is below the ground's level. The mass
//! leaves when it comes up to that level; how fast it rebounds follows from the law, and
//! `alpha` has no bearing. The film goes on as in eq (10).

use super::{Action, ContactLaw, EffectSpec, EventFigure, EvidenceFigure, FoundBy, Need, Search};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect. With the defaults a mass that comes at 0.2 m/s sinks in by a third of a
/// micrometre for some 8 us and keeps four tenths of its speed.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "compliant_ground",
    name: "compliant ground",
    sentence: "The ground yields: the mass sinks in, contacts take time, and the level while stuck moves with the load.",
    law: "F = k d^1.5 (1 + chi d') - f_a,  d = -dp - xp > 0",
    source: "Hunt and Crossley, J. Appl. Mech. 42, 440 (1975); adhesion as a constant pull-off force while touching: Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53, 314 (1975)",
    needs: Need::Ground,
    parameters: &[
        ParameterSpec {
            id: "k",
            symbol: "k",
            name: "stiffness of the ground",
            unit: "N/m^1.5",
            default: 1e5,
            range: (1e3, 1e8),
            limits: (1e-9, 1e15),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "force at a depth of 1 m by Hertz's law; hard silicon has 1e7 to 1e8, a soft layer 1e3",
            equation: "F = k d^1.5 (1 + chi d')",
        },
        ParameterSpec {
            id: "chi",
            symbol: "χ",
            name: "damping of the ground",
            unit: "s/m",
            default: 10.0,
            range: (0.0, 100.0),
            limits: (0.0, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "loss in contact; 11 s/m keeps 38 % of an approach at 0.2 m/s",
            equation: "F = k d^1.5 (1 + chi d')",
        },
    ],
    build: |values, _| {
        Box::new(CompliantGround {
            stiffness: values[0],
            damping: values[1],
        })
    },
    search: Search {
        found_by: FoundBy::ContactEvents(ContactLaw::Compliance),
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Events(EventFigure::Dwell),
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct CompliantGround {
    stiffness: f64,
    damping: f64,
}

impl Action for CompliantGround {
    fn contact_force(&self, depth: f64, rate: f64) -> Option<f64> {
        let depth = depth.max(0.0);
        Some(self.stiffness * depth * depth.sqrt() * (1.0 + self.damping * rate))
    }
}
