//! `piezo_creep`: the drive goes on growing slowly after a step of the voltage.

use super::{Action, EffectSpec, Kinematics, Need};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "piezo_creep",
    name: "piezo creep",
    sentence: "After each step of the voltage the drive creeps on for a while, in both readings and while stuck.",
    law: "F = eta (gc + c z),  tau z' = gc - z",
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
            equation: "F = eta (gc + c z)",
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
    ],
    build: |values, _| {
        let creeps = values[0] != 0.0;
        Box::new(PiezoCreep {
            share: values[0],
            rates: if creeps {
                vec![1.0 / values[1]]
            } else {
                Vec::new()
            },
        })
    },
};

#[derive(Debug)]
struct PiezoCreep {
    share: f64,
    rates: Vec<f64>,
}

impl PiezoCreep {
    fn creep(&self, z: &[f64]) -> f64 {
        z.first().map_or(0.0, |z| self.share * z)
    }
}

impl Action for PiezoCreep {
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
        if let ([rate], [input]) = (self.rates.as_slice(), inputs) {
            *input = rate * (at.gain - self.creep(z));
        }
    }

    fn drive_gain(&self, gain: f64, _at: &Kinematics, z: &[f64]) -> f64 {
        gain + self.creep(z)
    }
}
