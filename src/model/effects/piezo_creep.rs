//! `piezo_creep`: the drive goes on growing slowly after a step of the voltage.

use super::{Action, EffectSpec, Kinematics, Need};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "piezo_creep",
    name: "piezo creep",
    sentence: "After each step of the voltage the drive creeps on for a while, in both readings and while stuck.",
    law: "F = eta (gc + c z + c2 z2),  tau z' = gc - z,  tau2 z2' = gc - z2",
    source: "linear creep operator: Jung and Gweon, Rev. Sci. Instrum. 71, 1896 (2000)",
    needs: Need::Drive,
    parameters: &[
        ParameterSpec {
            id: "c",
            symbol: "c",
            name: "share of creep",
            unit: "",
            default: 0.05,
            range: (-0.3, 0.3),
            limits: (-0.9, 10.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "what creep adds in the end, as a share of the drive",
            equation: "F = eta (gc + c z + c2 z2)",
        },
        ParameterSpec {
            id: "tau",
            symbol: "τ",
            name: "time of creep",
            unit: "s",
            default: 20e-3,
            range: (1e-3, 1.0),
            limits: (1e-7, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "time over which the drive creeps on",
            equation: "tau z' = gc - z",
        },
        ParameterSpec {
            id: "c2",
            symbol: "c2",
            name: "share of further creep",
            unit: "",
            default: 0.0,
            range: (-0.3, 0.3),
            limits: (-0.9, 10.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "what creep of a second time adds in the end, as a share of the drive; creep by the logarithm of time has many times",
            equation: "F = eta (gc + c z + c2 z2)",
        },
        ParameterSpec {
            id: "tau2",
            symbol: "τ2",
            name: "time of further creep",
            unit: "s",
            default: 0.2,
            range: (1e-3, 1.0),
            limits: (1e-7, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "second time over which the drive creeps on",
            equation: "tau2 z2' = gc - z2",
        },
    ],
    build: |values, _| {
        let elements = values.chunks_exact(2).filter(|e| e[0] != 0.0);
        let (shares, rates) = elements.map(|e| (e[0], 1.0 / e[1])).unzip();
        Box::new(PiezoCreep { shares, rates })
    },
};

/// Whether parameter number `i` bears on anything: see [`super::ActiveEffect::bears`].
pub(super) fn bears(values: &[f64], i: usize) -> bool {
    i < 2 || values[2] != 0.0
}

#[derive(Debug)]
struct PiezoCreep {
    /// Share of each element, and the rate at which it settles \[1/s\].
    shares: Vec<f64>,
    rates: Vec<f64>,
}

impl PiezoCreep {
    fn creep(&self, z: &[f64]) -> f64 {
        self.shares.iter().zip(z).map(|(share, z)| share * z).sum()
    }
}

impl Action for PiezoCreep {
    fn acts_on_drive(&self) -> bool {
        true
    }

    fn does_nothing(&self) -> bool {
        self.rates.is_empty()
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn states_feel_motion(&self) -> bool {
        false
    }

    fn state_inputs(&self, at: &Kinematics, z: &[f64], inputs: &mut [f64]) {
        let gain = at.gain - self.creep(z);
        for (input, rate) in inputs.iter_mut().zip(&self.rates) {
            *input = rate * gain;
        }
    }

    fn drive_gain(&self, gain: f64, _at: &Kinematics, z: &[f64]) -> f64 {
        gain + self.creep(z)
    }
}
