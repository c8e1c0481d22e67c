//! `load_friction`: a friction that grows or falls with the deflection, because the load on the
//! contact that rubs does.
//!
//! Equation: `F = -(ml |xp| + mq xp^2) sign(xp')`.
//! Source: Coulomb friction under a load that varies, e.g. Iwan, J. Appl. Mech. 33, 893 (1966)
//! for a load of the spring; Newton's law across the track for a curved track.
//!
//! A contact that the spring presses together carries `|k xp|`: friction `ml |xp|` with
//! `ml = mu k`, whose loop has the same share of the energy at every size of the swing.
//! A body of mass `m` on a track of radius `R`, at `xp` along it, carries
//! `m g cos(xp/R) + m xp'^2/R`, in leading terms `m g + m xp'^2/R - m g xp^2/(2 R^2)`. Its first
//! part is `dry_friction`, its second `quadratic_drag` with `cd = mu m/R`; the third is the
//! `mq = -mu m g/(2 R^2)` of this effect, which is negative where the load falls with height.
//!
//! All frictions together are not below zero. A mass that comes to rest is held by the friction
//! there.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Motion, Need, Quantity, Search,
    Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

const LAW: &str = "F = -(ml |xp| + mq xp^2) sign(xp')";

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "load_friction",
    name: "load-dependent friction",
    sentence: "Friction grows (or falls) with the deflection, as the load on the contact that rubs does.",
    law: LAW,
    source: "Coulomb friction under a varying load, e.g. Iwan, J. Appl. Mech. 33, 893 (1966); Newton's law across a curved track",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "ml",
            symbol: "ml",
            name: "friction per deflection",
            unit: "N/m",
            default: 1e-4,
            range: (0.0, 1e-3),
            limits: (0.0, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "friction per distance of the proof mass from its zero; a friction coefficient times the spring that loads the contact",
            equation: LAW,
        },
        ParameterSpec {
            id: "mq",
            symbol: "mq",
            name: "friction per squared deflection",
            unit: "N/m^2",
            default: 0.0,
            range: (-10.0, 10.0),
            limits: (-1e15, 1e15),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "negative where the load falls with deflection, as on a curved track; together with dry friction",
            equation: LAW,
        },
    ],
    build: |values, _| {
        Box::new(LoadFriction {
            linear: values[0],
            quadratic: values[1],
        })
    },
    facts: Facts {
        strengths: &["ml", "mq"],
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        form_errors: |values, tolerance| {
            let values = values.iter().map(|m| tolerance.share * m).collect();
            vec![FormError::InWindows(values, Quantity::Displacement)]
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Velocity),
};

/// Either term alone, a thousandth of the force at the largest displacement. A mass without a
/// spring has no zero from which a load could grow.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.is_sprung {
        return Vec::new();
    }
    let force = 1e-3 * motion.force;
    let (linear, quadratic) = (force / motion.length, force / motion.length.powi(2));
    vec![
        Start::positive(&[linear, 0.0], 0, &[0]),
        Start::signed(&[0.0, quadratic], 1, &[1]),
    ]
}

#[derive(Debug)]
struct LoadFriction {
    linear: f64,
    quadratic: f64,
}

impl Action for LoadFriction {
    fn does_nothing(&self) -> bool {
        self.linear == 0.0 && self.quadratic == 0.0
    }

    fn friction(&self, xp: f64) -> f64 {
        (self.linear + self.quadratic * xp.abs()) * xp.abs()
    }

    fn friction_varies(&self) -> bool {
        true
    }
}
