//! `adhesion_saturation`: adhesion that grows ever more slowly with contact time.
//!
//! Equation: `f_a = Ca0 + dF ((1 - s)(1 - exp(-t/tau)) + s ln(1 + t/tau)) + l Ca t`.
//! Source: capillary nucleation: Szoszkiewicz and Riedo, Phys. Rev. Lett. 95, 135502 (2005).

use super::{
    Action, ContactLaw, EffectSpec, EventFigure, EvidenceFigure, Facts, FoundBy, Need, Search,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "adhesion_saturation",
    name: "saturating adhesion",
    sentence: "Adhesion grows fast at first and then levels off, in place of a straight line in contact time or on top of one.",
    law: "f_a = Ca0 + dF ((1 - s)(1 - exp(-t/tau)) + s ln(1 + t/tau)) + l Ca t",
    source: "capillary nucleation: Szoszkiewicz and Riedo, Phys. Rev. Lett. 95, 135502 (2005)",
    needs: Need::Ground,
    parameters: &[
        ParameterSpec {
            id: "dF",
            symbol: "dF",
            name: "growth of adhesion",
            unit: "N",
            default: 100e-9,
            range: (0.0, 500e-9),
            limits: (0.0, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "how much adhesion gains in the end; 0 leaves the straight line",
            equation: "f_a = Ca0 + dF (1 - exp(-t/tau))",
        },
        ParameterSpec {
            id: "tau",
            symbol: "τ",
            name: "time of growth",
            unit: "s",
            default: 5e-3,
            range: (0.1e-3, 200e-3),
            limits: (1e-9, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "contact time over which adhesion grows",
            equation: "f_a = Ca0 + dF (1 - exp(-t/tau))",
        },
        ParameterSpec {
            id: "log_share",
            symbol: "s",
            name: "logarithmic share",
            unit: "",
            default: 0.0,
            range: (0.0, 1.0),
            limits: (0.0, 1.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "0 levels off, 1 grows as ln(1 + t/tau)",
            equation: "f_a = Ca0 + dF ln(1 + t/tau)",
        },
        ParameterSpec {
            id: "line_share",
            symbol: "l",
            name: "share of the straight line",
            unit: "",
            default: 0.0,
            range: (0.0, 1.0),
            limits: (0.0, 1.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "0: in place of the straight line, 1: on top of it",
            equation: "f_a = Ca0 + dF (...) + l Ca t",
        },
    ],
    build: |values, _| {
        Box::new(AdhesionSaturation {
            growth: values[0],
            tau: values[1],
            log_share: values[2],
            line_share: values[3],
        })
    },
    facts: Facts {
        strengths: &["dF"],
        largest_force: Some(|values, _| values[0]),
        feature_strength: Some("dF"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::ContactEvents(ContactLaw::Adhesion),
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Events(EventFigure::Adhesion),
};

#[derive(Debug)]
struct AdhesionSaturation {
    growth: f64,
    tau: f64,
    log_share: f64,
    line_share: f64,
}

impl Action for AdhesionSaturation {
    fn does_nothing(&self) -> bool {
        self.growth == 0.0
    }

    fn acts_on_motion(&self) -> bool {
        false
    }

    fn adhesion(&self, adhesion: f64, at_touch: f64, contact_time: f64) -> f64 {
        if self.growth == 0.0 {
            return adhesion;
        }
        let s = contact_time.max(0.0) / self.tau;
        let levels_off = -(-s).exp_m1();
        let bend = (1.0 - self.log_share) * levels_off + self.log_share * s.ln_1p();
        at_touch + self.growth * bend + self.line_share * (adhesion - at_touch)
    }
}
