//! `gap_step`: the ground is higher or lower from one instant on.
//!
//! Equation: `contact at xp = -dp + h for t >= t0`.
//! Source: a particle or wear under the mass.

use super::{Action, EffectSpec, EventFigure, EvidenceFigure, Facts, FoundBy, Need, Search};
use crate::model::drive::Segment;
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "gap_step",
    name: "step of the ground",
    sentence: "From one moment on the ground is higher (a particle) or lower (wear); flight is as before.",
    law: "contact at xp = -dp + h for t >= t0",
    source: "a particle or wear under the mass",
    needs: Need::Ground,
    parameters: &[
        ParameterSpec {
            id: "h",
            symbol: "h",
            name: "height of the step",
            unit: "m",
            default: 2e-6,
            range: (-10e-6, 10e-6),
            limits: (-1e9, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "how much higher the ground is afterwards; less than dp",
            equation: "contact at xp = -dp + h",
        },
        ParameterSpec {
            id: "t0",
            symbol: "t0",
            name: "time of the step",
            unit: "s",
            default: 0.1,
            range: (0.0, 1.0),
            limits: (-1e9, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "when it happens",
            equation: "contact at xp = -dp + h for t >= t0",
        },
    ],
    build: |values, _| {
        Box::new(GapStep {
            height: values[0],
            time: values[1],
        })
    },
    facts: Facts {
        strengths: &["h"],
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::StepTime,
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Events(EventFigure::Level),
};

#[derive(Debug)]
struct GapStep {
    height: f64,
    time: f64,
}

impl Action for GapStep {
    fn does_nothing(&self) -> bool {
        self.height == 0.0
    }

    fn acts_on_motion(&self) -> bool {
        false
    }

    fn piece(&self, segment: Segment, t: f64, _z: &[f64]) -> Segment {
        if self.height == 0.0 || t >= self.time {
            return segment;
        }
        Segment {
            end: segment.end.min(self.time),
            ..segment
        }
    }

    fn ground_level(&self, level: f64, t: f64) -> f64 {
        if t >= self.time {
            level + self.height
        } else {
            level
        }
    }

    fn ground_jump(&self) -> Option<f64> {
        (!self.does_nothing()).then_some(self.time)
    }
}
