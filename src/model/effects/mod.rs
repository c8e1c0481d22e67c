//! Physics beyond the baseline, one file per effect.
//!
//! An effect is an [`EffectSpec`] (what it is, its parameters) that builds an
//! [`Action`] (what it does). A new effect is a new file and a line in [`CATALOGUE`];
//! the simulator, the sliders and the command line find it there.

mod gravity;
mod quadratic_drag;

use std::fmt;

use super::parameter::ParameterSpec;
use super::structure::Structure;

/// All effects that are known.
pub static CATALOGUE: &[&EffectSpec] = &[&quadratic_drag::EFFECT, &gravity::EFFECT];

/// What an effect is.
pub struct EffectSpec {
    /// Fixed id, as typed on the command line.
    pub id: &'static str,
    /// The term of the field.
    pub name: &'static str,
    /// One plain sentence for the window.
    pub sentence: &'static str,
    /// Its law, as written in the window.
    pub law: &'static str,
    /// Where the law is from.
    pub source: &'static str,
    /// Its parameters, with defaults and ranges.
    pub parameters: &'static [ParameterSpec],
    /// Builds the action for values in the order of `parameters`.
    pub build: fn(&[f64], &Structure) -> Box<dyn Action>,
}

impl fmt::Debug for EffectSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "EffectSpec({})", self.id)
    }
}

impl PartialEq for EffectSpec {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// Finds an effect by its id.
pub fn find(id: &str) -> Option<&'static EffectSpec> {
    CATALOGUE.iter().copied().find(|effect| effect.id == id)
}

/// An effect with values for its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveEffect {
    /// Which effect.
    pub spec: &'static EffectSpec,
    /// Values in the order of `spec.parameters`, SI.
    pub values: Vec<f64>,
}

impl ActiveEffect {
    /// The effect at its defaults.
    pub fn new(spec: &'static EffectSpec) -> Self {
        Self {
            spec,
            values: spec.parameters.iter().map(|p| p.default).collect(),
        }
    }

    /// Sets a parameter by id; false if the effect has none of that id.
    pub fn set(&mut self, id: &str, value: f64) -> bool {
        let place = self.spec.parameters.iter().position(|p| p.id == id);
        if let Some(i) = place {
            self.values[i] = value;
        }
        place.is_some()
    }
}

/// State of the device as an effect sees it. SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Kinematics {
    /// Time [s].
    pub t: f64,
    /// Displacement of the proof mass [m].
    pub xp: f64,
    /// Velocity of the proof mass [m/s].
    pub vp: f64,
    /// Displacement of the cantilever's centre [m].
    pub xc: f64,
    /// Velocity of the cantilever's centre [m/s].
    pub vc: f64,
    /// Voltage at the terminals [V].
    pub voltage: f64,
}

/// What an effect does, at each of the places where it can attach. Every method
/// defaults to doing nothing. `z` are the effect's own extra states.
pub trait Action: Send + Sync + fmt::Debug {
    /// Structure: adds or changes modes before the simulation starts.
    fn alter_structure(&self, _structure: &mut Structure) {}

    /// Extra states: decay rate of each [1/s]. State `k` obeys `z_k' = -rate_k z_k + u_k`.
    fn state_rates(&self) -> &[f64] {
        &[]
    }

    /// Extra states: the inputs `u_k`.
    fn state_inputs(&self, _at: &Kinematics, _z: &[f64], _inputs: &mut [f64]) {}

    /// Drive: the voltage that the piezo film sees, from the one it would see without.
    fn drive_voltage(&self, voltage: f64, _at: &Kinematics, _z: &[f64]) -> f64 {
        voltage
    }

    /// Drive: further force where the piezo drives the cantilever [N].
    fn drive_force(&self, _at: &Kinematics, _z: &[f64]) -> f64 {
        0.0
    }

    /// Force on the proof mass [N], in flight and while it is held.
    fn force_on_proof_mass(&self, _at: &Kinematics, _z: &[f64]) -> f64 {
        0.0
    }

    /// Contact: level of the ground [m], from the level without.
    fn ground_level(&self, level: f64, _t: f64) -> f64 {
        level
    }

    /// Contact: adhesion [N] after `contact_time` [s], from the adhesion without.
    fn adhesion(&self, adhesion: f64, _contact_time: f64) -> f64 {
        adhesion
    }

    /// Impact: restitution at approach speed `speed` > 0 [m/s], from the one without.
    fn restitution(&self, alpha: f64, _speed: f64) -> f64 {
        alpha
    }

    /// Sensor: changes a uniformly sampled reading [m] in place; first sample at `t0`,
    /// interval `dt` [s].
    fn alter_reading(&self, _reading: &mut [f64], _t0: f64, _dt: f64) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn catalogue_is_sound() {
        for (i, effect) in CATALOGUE.iter().enumerate() {
            assert_eq!(find(effect.id), Some(*effect));
            assert!(CATALOGUE[..i].iter().all(|other| other.id != effect.id));
            assert!(effect.sentence.ends_with('.'), "{}", effect.id);
            for parameter in effect.parameters {
                assert!(
                    parameter.refusal(parameter.default).is_none(),
                    "{} {}",
                    effect.id,
                    parameter.id
                );
            }
        }
    }
}
