//! `extra_mode`: a further vibration mode of the structure.

use super::{Action, EffectSpec, Need};
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::structure::{Mode, Structure};

const SHAPE: (f64, f64) = (-2e5, 2e5);
const ANY: (f64, f64) = (-1e12, 1e12);

const fn shape(
    id: &'static str,
    symbol: &'static str,
    name: &'static str,
    default: f64,
    meaning: &'static str,
) -> ParameterSpec {
    ParameterSpec {
        id,
        symbol,
        name,
        unit: "kg^-1/2",
        default,
        range: SHAPE,
        limits: ANY,
        scale: Scale::Linear,
        rank: Rank::Advanced,
        meaning,
        equation: "q'' + 2 zeta w q' + w^2 q = phi . F,  x = ... + phi q",
    }
}

/// The effect. Defaults are the third bending mode of the paper's beam.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "extra_mode",
    name: "further mode",
    sentence: "A further vibration mode rings after every step and impact, in a fixed ratio of the two readings.",
    law: "q'' + 2 zeta w q' + w^2 q = phi . F,  x = ... + phi q",
    source: "modal superposition; third bending mode of the Euler-Bernoulli beam of the presets",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "f",
            symbol: "f",
            name: "frequency",
            unit: "Hz",
            default: 19175.0,
            range: (1e3, 40e3),
            limits: (1e-3, 1e7),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "undamped natural frequency of the further mode",
            equation: "q'' + 2 zeta w q' + w^2 q = phi . F",
        },
        ParameterSpec {
            id: "zeta",
            symbol: "ζ",
            name: "damping",
            unit: "",
            default: 0.01,
            range: (0.001, 0.1),
            limits: (0.0, 10.0),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "share of critical damping",
            equation: "q'' + 2 zeta w q' + w^2 q = phi . F",
        },
        shape(
            "phi_c",
            "φc",
            "shape at the cantilever",
            63144.79,
            "mass-normalised shape at the cantilever's centre, which is read",
        ),
        shape(
            "phi_p",
            "φp",
            "shape at the proof mass",
            2944.80,
            "mass-normalised shape at the proof mass, which is read and hits the ground",
        ),
        shape(
            "phi_d",
            "φd",
            "shape at the drive",
            63144.79,
            "coupling to the piezo drive; phi_c for a force on the cantilever's centre",
        ),
    ],
    build: |values, _| {
        Box::new(ExtraMode {
            mode: Mode {
                frequency: values[0],
                zeta: values[1],
                phi_c: values[2],
                phi_p: values[3],
                phi_drive: values[4],
            },
        })
    },
};

#[derive(Debug)]
struct ExtraMode {
    mode: Mode,
}

impl Action for ExtraMode {
    /// A mode that nothing moves or that nobody sees is none.
    fn does_nothing(&self) -> bool {
        let mode = &self.mode;
        let moved = mode.phi_p != 0.0 || mode.phi_drive != 0.0;
        !(moved && (mode.phi_c != 0.0 || mode.phi_p != 0.0))
    }

    fn alter_structure(&self, structure: &mut Structure) {
        structure.modes.push(self.mode);
    }
}
