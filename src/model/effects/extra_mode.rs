//! `extra_mode`: a further vibration mode of the structure, and a second mode beside it.
//!
//! Equation: `q'' + 2 zeta w q' + w^2 q = phi . F, x = ... + phi q`.
//! Source: modal superposition; third bending mode of the Euler-Bernoulli beam of the
//! presets.

use super::{
    Action, ContactLaw, EffectSpec, EvidenceFigure, Facts, FoundBy, ModeLayout, Need, Search,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::structure::{Mode, Structure};

const LAW: &str = "q'' + 2 zeta w q' + w^2 q = phi . F,  x = ... + phi q";
const SHAPE: (f64, f64) = (-2e5, 2e5);
const ANY: (f64, f64) = (-1e12, 1e12);
/// Parameters of one mode: its frequency, its damping and its three shapes.
pub const OF_ONE: usize = 5;

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
        equation: LAW,
    }
}

const fn frequency(
    id: &'static str,
    symbol: &'static str,
    name: &'static str,
    default: f64,
    range: (f64, f64),
    meaning: &'static str,
) -> ParameterSpec {
    ParameterSpec {
        unit: "Hz",
        range,
        limits: (1e-3, 1e7),
        scale: Scale::Log,
        ..shape(id, symbol, name, default, meaning)
    }
}

const fn damping(
    id: &'static str,
    symbol: &'static str,
    name: &'static str,
    default: f64,
    meaning: &'static str,
) -> ParameterSpec {
    ParameterSpec {
        unit: "",
        range: (0.001, 0.1),
        limits: (0.0, 10.0),
        scale: Scale::Log,
        ..shape(id, symbol, name, default, meaning)
    }
}

/// The effect. Defaults are the third bending mode of the paper's beam; of the fourth, which
/// stands beside it once it has a shape at a reading, its frequency.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "extra_mode",
    name: "further mode",
    sentence: "A further vibration mode rings after every step and impact, in a fixed ratio of the two readings.",
    law: LAW,
    source: "modal superposition; third bending mode of the Euler-Bernoulli beam of the presets",
    needs: Need::Nothing,
    parameters: &[
        frequency(
            "f",
            "f",
            "frequency",
            19175.0,
            (1e3, 40e3),
            "undamped natural frequency of the further mode",
        ),
        damping("zeta", "ζ", "damping", 0.01, "share of critical damping"),
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
        frequency(
            "f2",
            "f2",
            "frequency of the second mode",
            39.2e3,
            (1e3, 100e3),
            "undamped natural frequency of the second mode",
        ),
        damping(
            "zeta2",
            "ζ2",
            "damping of the second mode",
            0.01,
            "share of critical damping of the second mode",
        ),
        shape(
            "phi_c2",
            "φc2",
            "second mode at the cantilever",
            0.0,
            "shape of the second mode at the cantilever's centre; the mode is left out where this and the next are 0",
        ),
        shape(
            "phi_p2",
            "φp2",
            "second mode at the proof mass",
            0.0,
            "shape of the second mode at the proof mass",
        ),
        shape(
            "phi_d2",
            "φd2",
            "second mode at the drive",
            63144.79,
            "coupling of the second mode to the piezo drive",
        ),
    ],
    build: |values, _| {
        Box::new(ExtraMode {
            modes: modes(values).filter(shows).collect(),
        })
    },
    facts: Facts {
        strengths: &["phi_c", "phi_p", "phi_d"],
        modes: Some(ModeLayout {
            per_mode: OF_ONE,
            frequency: 0,
            first_shape: 2,
        }),
        // How a mode rings that the impacts set off is hardly determined by the flight.
        obscures: &[ContactLaw::Compliance],
        is_felt,
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::ModeFrequency,
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::RingDown,
};

/// The modes that the values are of.
fn modes(values: &[f64]) -> impl Iterator<Item = Mode> + '_ {
    values.chunks_exact(OF_ONE).map(|v| Mode {
        frequency: v[0],
        zeta: v[1],
        phi_c: v[2],
        phi_p: v[3],
        phi_drive: v[4],
    })
}

/// Whether parameter number `i` is one of a mode that the device has.
fn is_felt(values: &[f64], i: usize) -> bool {
    modes(values)
        .nth(i / OF_ONE)
        .is_some_and(|mode| shows(&mode))
}

/// Whether a mode is moved by something and seen by somebody; otherwise it is none.
fn shows(mode: &Mode) -> bool {
    let moved = mode.phi_p != 0.0 || mode.phi_drive != 0.0;
    moved && (mode.phi_c != 0.0 || mode.phi_p != 0.0)
}

#[derive(Debug)]
struct ExtraMode {
    modes: Vec<Mode>,
}

impl Action for ExtraMode {
    fn does_nothing(&self) -> bool {
        self.modes.is_empty()
    }

    fn acts_on_motion(&self) -> bool {
        false
    }

    fn alter_structure(&self, structure: &mut Structure) {
        structure.modes.extend_from_slice(&self.modes);
    }
}

#[cfg(test)]
mod tests {
    use super::super::extra_mode::*;
    use super::super::{ActiveEffect, Surroundings};
    use crate::model::preset::Preset;

    fn count(set: &[(&str, f64)]) -> usize {
        let model = Preset::embedded("paper").unwrap().model;
        let mut effect = ActiveEffect::new(&EFFECT);
        for (id, value) in set {
            assert!(effect.set(id, *value), "{id}");
        }
        let mut structure = model.structure();
        let before = structure.modes.len();
        let around = Surroundings {
            structure: &model.structure(),
            parameters: &model.parameters,
            piezo: model.piezo,
        };
        let action = (EFFECT.build)(&effect.values, &around);
        action.alter_structure(&mut structure);
        assert_eq!(action.does_nothing(), structure.modes.len() == before);
        let told = (0..2 * OF_ONE).filter(|&i| effect.bears(i)).count();
        assert_eq!(told, OF_ONE * (structure.modes.len() - before));
        structure.modes.len() - before
    }

    #[test]
    fn one_more_begins_with_a_shape_at_a_reading() {
        assert_eq!(count(&[]), 1);
        assert_eq!(count(&[("phi_c2", 1e4)]), 2);
        assert_eq!(count(&[("phi_p2", -1e3)]), 2);
        let first = [("phi_c", 0.0), ("phi_p", 0.0)];
        assert_eq!(count(&first), 0);
        assert_eq!(count(&[first[0], first[1], ("phi_c2", 1e4)]), 1);
        // A mode that nothing moves is none.
        assert_eq!(count(&[("phi_c2", 1e4), ("phi_d2", 0.0)]), 1);
    }
}
