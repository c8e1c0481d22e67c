//! `zero_drift`: the zero of the readings moves.

use super::{Action, EffectSpec, Need};
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
            name: "drift in the end",
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
