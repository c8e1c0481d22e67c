//! `base_vibration`: the whole device is shaken.
//!
//! Equation: `F = -M [1, 1] a sin(2 pi f t + phase)`.
//! Source: base excitation, e.g. Clough and Penzien, Dynamics of Structures, 1993, section
//! 2-5.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Action, EffectSpec, Facts, FormError, FoundBy, Need, Search};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "base_vibration",
    name: "vibration of the base",
    sentence: "The base vibrates steadily and moves both points, also while the mass is stuck.",
    law: "F = -M [1, 1] a sin(2 pi f t + phase)",
    source: "base excitation, e.g. Clough and Penzien, Dynamics of Structures, 1993, section 2-5",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "a",
            symbol: "a",
            name: "acceleration",
            unit: "m/s^2",
            default: 10.0,
            range: (0.0, 100.0),
            limits: (0.0, 1e9),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "amplitude of the base's acceleration; readings are relative to the base",
            equation: "F = -M [1, 1] a sin(2 pi f t + phase)",
        },
        ParameterSpec {
            id: "f",
            symbol: "f",
            name: "frequency",
            unit: "Hz",
            default: 50.0,
            range: (10.0, 2e3),
            limits: (0.0, 1e7),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "frequency of the base's vibration",
            equation: "F = -M [1, 1] a sin(2 pi f t + phase)",
        },
        ParameterSpec {
            id: "phase",
            symbol: "φ",
            name: "phase",
            unit: "rad",
            default: 0.0,
            range: (-PI, PI),
            limits: (-1e6, 1e6),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "phase of the vibration at t = 0",
            equation: "F = -M [1, 1] a sin(2 pi f t + phase)",
        },
    ],
    build: |values, _| {
        Box::new(BaseVibration {
            amplitude: values[0],
            frequency: values[1],
            phase: values[2],
        })
    },
    facts: Facts {
        strengths: &["a"],
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Frequency,
        // Its second and third harmonic, as sine and cosine.
        form_errors: |values, tolerance| {
            let phases = |harmonic| [(harmonic, 0.0), (harmonic, FRAC_PI_2)];
            let size = tolerance.share * values[0];
            let add =
                |(harmonic, phase)| FormError::Everywhere(vec![size, harmonic * values[1], phase]);
            [2.0, 3.0].into_iter().flat_map(phases).map(add).collect()
        },
        ..Search::DEFAULT
    },
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct BaseVibration {
    amplitude: f64,
    frequency: f64,
    phase: f64,
}

impl Action for BaseVibration {
    fn does_nothing(&self) -> bool {
        self.amplitude == 0.0
    }

    fn base_acceleration(&self, t: f64) -> f64 {
        // Whole turns are taken off first, so that late periods are as exact as early ones.
        let turns = (self.frequency * t).fract();
        self.amplitude * (TAU * turns + self.phase).sin()
    }
}
