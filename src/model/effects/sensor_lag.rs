//! `sensor_lag`: the readings are late.
//!
//! Equation: `y(t) = r(t - d), tau r' = x - r`.
//! Source: delay of a vibrometer's decoder and filters.

use super::{
    Action, EdgeLag, EffectSpec, EvidenceFigure, Facts, FoundBy, Kinematics, LagKind, Motion, Need,
    Quantity, Search, Start, followed_time_constant,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::sensor::Point;

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "sensor_lag",
    name: "late readings",
    sentence: "Both readings are late against the voltage: by a fixed delay, a first-order lag, or both.",
    law: "y(t) = r(t - d),  tau r' = x - r",
    source: "delay of a vibrometer's decoder and filters",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "tau",
            symbol: "τ",
            name: "lag",
            unit: "s",
            default: 20e-6,
            range: (0.0, 200e-6),
            limits: (0.0, 1e3),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "time constant of the reading's first-order lag",
            equation: "tau r' = x - r",
        },
        ParameterSpec {
            id: "delay",
            symbol: "d",
            name: "delay",
            unit: "s",
            default: 0.0,
            range: (0.0, 200e-6),
            limits: (0.0, 1e3),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "time by which the reading is late as a whole",
            equation: "y(t) = r(t - d)",
        },
    ],
    build: |values, _| {
        Box::new(SensorLag {
            rates: if values[0] > 0.0 {
                vec![1.0 / followed_time_constant(values[0]); 2]
            } else {
                Vec::new()
            },
            delay: values[1],
        })
    },
    facts: Facts {
        strengths: &["tau", "delay"],
        reading_delay: Some(1),
        edge_lags: &[EdgeLag {
            parameter: 0,
            kind: LagKind::Readings,
        }],
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Residual(Quantity::Velocity),
};

/// Lags and delays as shares of the time between samples. Together with a shift of the clocks a
/// lag acts as its square.
fn starts(motion: &Motion) -> Vec<Start> {
    // Without a drive or a ground there is no instant that a reading could be late by.
    if !motion.is_driven && !motion.has_ground {
        return Vec::new();
    }
    let lag = |share| Start::positive(&[share * motion.interval, 0.0], 0, &[0]);
    let delay = |share| Start::positive(&[0.0, share * motion.interval], 1, &[1]);
    let lags = [0.1, 0.25, 0.6, 2.0].map(lag);
    lags.into_iter().chain([0.05, 0.25].map(delay)).collect()
}

/// States: the lagged reading of the proof mass and of the cantilever \[m\].
#[derive(Debug)]
struct SensorLag {
    rates: Vec<f64>,
    delay: f64,
}

impl Action for SensorLag {
    fn does_nothing(&self) -> bool {
        self.rates.is_empty() && self.delay == 0.0
    }

    fn acts_on_motion(&self) -> bool {
        false
    }

    fn acts_on_readings(&self) -> bool {
        true
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn state_inputs(&self, at: &Kinematics, _z: &[f64], inputs: &mut [f64]) {
        if let ([rate, _], [p, c]) = (self.rates.as_slice(), inputs) {
            *p = rate * at.xp;
            *c = rate * at.xc;
        }
    }

    fn reading(&self, reading: f64, point: Point, _t: f64, z: &[f64]) -> f64 {
        match (z, point) {
            ([p, _], Point::ProofMass) => *p,
            ([_, c], Point::Cantilever) => *c,
            _ => reading,
        }
    }

    fn reads_states(&self) -> bool {
        !self.rates.is_empty()
    }

    fn reading_delay(&self) -> f64 {
        self.delay
    }
}
