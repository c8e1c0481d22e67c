//! `zero_drift`: the zero of the readings moves.
//!
//! Equation: `reading += a (1 - exp(-t/tau)) + b t`.
//! Source: settling of an instrument; the paper saw up to 20 um from cycle to cycle.

use super::{
    Action, EffectSpec, EventFigure, EvidenceFigure, Facts, FormError, FoundBy, Need, Search, Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::sensor::Point;

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "zero_drift",
    name: "drift of the zero",
    sentence: "The zero of both readings moves with time: all levels, the contact level too, move together.",
    law: "reading += a (1 - exp(-t/tau)) + b t",
    source: "settling of an instrument; the paper saw up to 20 um from cycle to cycle",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "a",
            symbol: "a",
            name: "final drift",
            unit: "m",
            default: 1e-6,
            range: (-20e-6, 20e-6),
            limits: (-1e9, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "how far the zero has moved in the end",
            equation: "reading += a (1 - exp(-t/tau))",
        },
        ParameterSpec {
            id: "tau",
            symbol: "τ",
            name: "time of the drift",
            unit: "s",
            default: 0.1,
            range: (5e-3, 10.0),
            limits: (1e-9, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "time over which the zero settles",
            equation: "reading += a (1 - exp(-t/tau))",
        },
        ParameterSpec {
            id: "b",
            symbol: "b",
            name: "rate of the drift",
            unit: "m/s",
            default: 0.0,
            range: (-1e-4, 1e-4),
            limits: (-1e9, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "steady motion of the zero",
            equation: "reading += b t",
        },
    ],
    build: |values, _| {
        Box::new(ZeroDrift {
            size: values[0],
            tau: values[1],
            rate: values[2],
        })
    },
    facts: Facts {
        strengths: &["a", "b"],
        is_zero_course: true,
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(|motion| {
            let settling = [0.02, 0.1].map(|tau| {
                let values = [3e-3 * motion.length, tau, 0.0];
                Start::signed(&values, 0, &[0, 1]).shaped_by(&[2])
            });
            let steady = Start::signed(&[0.0, 0.1, 0.02 * motion.length], 2, &[2]);
            settling.into_iter().chain([steady]).collect()
        }),
        form_errors: |values, tolerance| {
            let slower = |factor| {
                let mut values = tolerance.scaled(values, 0);
                values[1] *= factor;
                FormError::Everywhere(values)
            };
            tolerance.times.map(slower).to_vec()
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Events(EventFigure::Level),
};

#[derive(Debug)]
struct ZeroDrift {
    size: f64,
    tau: f64,
    rate: f64,
}

impl Action for ZeroDrift {
    fn does_nothing(&self) -> bool {
        self.size == 0.0 && self.rate == 0.0
    }

    fn acts_on_motion(&self) -> bool {
        false
    }

    fn acts_on_readings(&self) -> bool {
        true
    }

    fn reading(&self, reading: f64, _point: Point, t: f64, _z: &[f64]) -> f64 {
        reading - self.size * (-t / self.tau).exp_m1() + self.rate * t
    }
}
