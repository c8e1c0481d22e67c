//! What the device is; no time stepping.

pub mod bisection;
pub mod design;
pub mod drive;
pub mod effects;
pub mod film;
pub mod ground;
pub mod parameter;
pub mod piezo;
pub mod preisach;
pub mod preset;
pub mod sensor;
pub mod slew_rate_limiter;
mod stored_effects;
pub mod structure;
pub mod unit;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use self::effects::{ActiveEffect, EffectSpec, Need, Surroundings};
use self::ground::{BounceRule, StickSpeed};
use self::parameter::{ParameterId, Parameters};
use self::piezo::Piezo;
use self::structure::Structure;
use self::unit::Coordinate;

/// A model that makes no sense, with the parameter to change.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{parameter}: {reason}")]
pub struct ModelError {
    /// Id of the parameter, or the key of the preset, at fault.
    pub parameter: String,
    /// What is wrong and what would be right.
    pub reason: String,
}

impl ModelError {
    fn new(parameter: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            parameter: parameter.into(),
            reason: reason.into(),
        }
    }
}

/// Most modes that a structure may have.
pub const MAX_MODES: usize = 32;

/// Parameters that hold frequency and damping ratio of the first modes.
const MODE_PARAMETERS: [(ParameterId, ParameterId); 2] = [
    (ParameterId::F1, ParameterId::Zeta1),
    (ParameterId::F2, ParameterId::Zeta2),
];

/// A device with values for all its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Name of the preset it came from.
    pub name: String,
    /// Values of the table, SI.
    pub parameters: Parameters,
    /// Mode shapes, and the modes beyond the second whole. Frequency and damping of the
    /// first two modes stand in `parameters`.
    pub modes: Vec<structure::Mode>,
    /// Rigid mass at the tip \[kg\].
    pub proof_mass: f64,
    /// The piezo's hysteresis branches; `None` for a device without drive.
    pub piezo: Option<Piezo>,
    /// Whether there is a ground, with its film and adhesion.
    pub has_ground: bool,
    /// Which arrivals at the ground are bounces.
    #[serde(default, skip_serializing_if = "BounceRule::is_pull_off")]
    pub bounce: BounceRule,
    /// Whether the cantilever's centre is a point of its own, with a reading.
    pub has_cantilever: bool,
    /// Whether the readings are displacements or angles.
    #[serde(default, skip_serializing_if = "Coordinate::is_length")]
    pub coordinate: Coordinate,
    /// Effects beyond the baseline.
    #[serde(with = "stored_effects")]
    pub effects: Vec<ActiveEffect>,
}

impl Default for Model {
    /// The `paper` preset.
    fn default() -> Self {
        preset::Preset::default().model
    }
}

impl Model {
    /// Whether a parameter has any bearing on this device.
    pub fn uses(&self, id: ParameterId) -> bool {
        use self::parameter::ParameterId as P;
        match id {
            P::Cs | P::Gp | P::Ca | P::Ca0 | P::Alpha | P::Dp => self.has_ground,
            P::Eta => self.piezo.is_some(),
            P::F2 | P::Zeta2 => self.modes.len() >= 2,
            P::OffsetC | P::ShapeC1 => self.has_cantilever,
            P::ShapeC2 => self.has_cantilever && self.modes.len() >= 2,
            P::ShapeP2 => self.modes.len() >= 2,
            P::DriveP => self.piezo.is_some() && self.modes.len() >= 2,
            P::Zeta1 => self.parameters[P::F1] > 0.0,
            P::F1 | P::X0 | P::V0 | P::OffsetP | P::Noise => true,
        }
    }

    /// Whether an effect could do anything on this device.
    pub fn allows(&self, effect: &EffectSpec) -> bool {
        match effect.needs {
            Need::Nothing => true,
            Need::Ground => self.has_ground,
            Need::Drive => self.piezo.is_some(),
        }
    }

    /// The structure with frequencies and dampings from the parameters, without what the
    /// effects add.
    pub fn structure(&self) -> Structure {
        use self::parameter::ParameterId as P;
        let mut modes = self.modes.clone();
        for (mode, (frequency, zeta)) in modes.iter_mut().zip(MODE_PARAMETERS) {
            mode.frequency = self.parameters[frequency];
            mode.zeta = self.parameters[zeta];
        }
        let p = &self.parameters;
        let factors = [(P::ShapeC1, None), (P::ShapeC2, Some(P::ShapeP2))];
        for (mode, (c, shape_p)) in modes.iter_mut().zip(factors) {
            mode.phi_c *= p[c];
            mode.phi_p *= shape_p.map_or(1.0, |s| p[s]);
        }
        if p[P::DriveP] != 0.0 {
            for mode in &mut modes {
                mode.phi_drive += p[P::DriveP] * mode.phi_p;
            }
        }
        Structure {
            modes,
            proof_mass: self.proof_mass,
        }
    }

    /// The structure with what the effects add.
    pub fn structure_with_effects(&self) -> Structure {
        let mut structure = self.structure();
        for effect in &self.effects {
            let around = Surroundings {
                structure: &structure,
                parameters: &self.parameters,
                piezo: self.piezo,
            };
            let action = (effect.spec.build)(&effect.values, &around);
            action.alter_structure(&mut structure);
        }
        structure
    }

    /// Ids of the effects' parameters that bear on anything, as `effect.parameter`.
    pub fn effect_ids(&self) -> Vec<String> {
        let of = |effect: &ActiveEffect| {
            let all = effect.spec.parameters.iter().enumerate();
            let own = all.filter(|(i, _)| effect.bears(*i));
            own.map(|(_, p)| format!("{}.{}", effect.spec.id, p.id))
                .collect::<Vec<_>>()
        };
        self.effects.iter().flat_map(of).collect()
    }

    /// Checks everything that the simulator relies on.
    ///
    /// # Errors
    /// The first [`ModelError`], naming the parameter and the remedy.
    pub fn check(&self) -> Result<(), ModelError> {
        for (id, value) in self.parameters.iter() {
            if let Some(reason) = id.spec().refusal(value).filter(|_| self.uses(id)) {
                return Err(ModelError::new(id.spec().id, reason));
            }
        }
        if self.has_ground {
            self.check_ground()?;
        }
        if self.modes.is_empty() {
            return Err(ModelError::new(
                "mode",
                "there is no mode; give at least one",
            ));
        }
        if self.modes.len() > MAX_MODES {
            return Err(ModelError::new(
                "mode",
                format!("{} modes are more than {MAX_MODES}", self.modes.len()),
            ));
        }
        if !(self.proof_mass > 0.0 && self.proof_mass.is_finite()) {
            return Err(ModelError::new(
                "proof_mass",
                format!("the proof mass must be above 0 kg, not {}", self.proof_mass),
            ));
        }
        for (i, mode) in self.modes.iter().enumerate() {
            let finite = [
                mode.frequency,
                mode.zeta,
                mode.phi_c,
                mode.phi_p,
                mode.phi_drive,
            ]
            .iter()
            .all(|v| v.is_finite());
            if !finite || mode.frequency < 0.0 || mode.zeta < 0.0 {
                return Err(ModelError::new(
                    format!("mode {}", i + 1),
                    "frequency, damping and shape must be finite, the first two not negative",
                ));
            }
        }
        let mobility: f64 = self.modes.iter().map(|m| m.phi_p * m.phi_p).sum();
        if !(mobility > 0.0 && mobility.is_finite()) {
            return Err(ModelError::new(
                "phi_p",
                "no mode moves the proof mass: give phi_p of at least one mode",
            ));
        }
        for effect in &self.effects {
            for (spec, value) in effect.spec.parameters.iter().zip(&effect.values) {
                if let Some(reason) = spec.refusal(*value) {
                    return Err(ModelError::new(
                        format!("{}.{}", effect.spec.id, spec.id),
                        reason,
                    ));
                }
            }
        }
        Ok(())
    }

    fn check_ground(&self) -> Result<(), ModelError> {
        use self::parameter::ParameterId as P;
        if let BounceRule::Restitution(stick) = self.bounce {
            let (key, value, unit) = match stick {
                StickSpeed::Given(speed) => ("stick_speed", speed, "m/s"),
                StickSpeed::AdhesionOver(reach) => ("adhesion_reach", reach, "m"),
            };
            if !(0.0..=1e9).contains(&value) {
                return Err(ModelError::new(
                    key,
                    format!("{key} must lie between 0 and 1e9 {unit}, not {value}"),
                ));
            }
        }
        let (gp, dp, x0) = (
            self.parameters[P::Gp],
            self.parameters[P::Dp],
            self.parameters[P::X0],
        );
        let write = |v| unit::format_quantity(v, "m", 5);
        if gp <= dp {
            return Err(ModelError::new(
                "gp",
                format!(
                    "gp = {} must exceed dp = {}: else the film force is singular before contact",
                    write(gp),
                    write(dp)
                ),
            ));
        }
        if x0 <= -dp {
            return Err(ModelError::new(
                "x0",
                format!(
                    "x0 = {} lies in the ground at {}; start above it",
                    write(x0),
                    write(-dp)
                ),
            ));
        }
        Ok(())
    }

    /// SI unit of a parameter, or of an active effect's as `effect.parameter`.
    pub fn unit_of(&self, id: &str) -> Option<&'static str> {
        if let Some(parameter) = ParameterId::from_id(id) {
            return Some(self.coordinate.unit(parameter.spec().unit));
        }
        let (effect, parameter) = id.split_once('.')?;
        let active = self.effects.iter().find(|e| e.spec.id == effect)?;
        let spec = active.spec.parameters.iter().find(|p| p.id == parameter)?;
        Some(self.coordinate.unit(spec.unit))
    }

    /// Value of a parameter, or of an active effect's as `effect.parameter`, SI.
    pub fn get(&self, id: &str) -> Option<f64> {
        if let Some(parameter) = ParameterId::from_id(id) {
            return Some(self.parameters[parameter]);
        }
        let (effect, parameter) = id.split_once('.')?;
        let active = self.effects.iter().find(|e| e.spec.id == effect)?;
        let place = active
            .spec
            .parameters
            .iter()
            .position(|p| p.id == parameter)?;
        active.values.get(place).copied()
    }

    /// Sets a parameter, or an effect's as `effect.parameter`, by id.
    ///
    /// # Errors
    /// [`ModelError`] if there is none of that id, with the ids there are.
    pub fn set(&mut self, id: &str, value: f64) -> Result<(), ModelError> {
        if let Some(parameter) = ParameterId::from_id(id) {
            self.parameters.set(parameter, value);
            return Ok(());
        }
        if let Some((effect, parameter)) = id.split_once('.')
            && let Some(active) = self.effects.iter_mut().find(|e| e.spec.id == effect)
            && active.set(parameter, value)
        {
            return Ok(());
        }
        let known: Vec<&str> = ParameterId::ALL.iter().map(|p| p.spec().id).collect();
        Err(ModelError::new(
            id,
            format!("there is no such parameter; there are {}", known.join(", ")),
        ))
    }
}

/// `model` with one more effect, in place of one of the same kind.
///
/// # Examples
/// ```
/// use impactscope::model::effects::{ActiveEffect, CATALOGUE};
/// use impactscope::model::{preset::Preset, with_effect};
///
/// let spec = CATALOGUE[0];
/// let mut effect = ActiveEffect::new(spec);
/// assert!(effect.set(spec.parameters[0].id, spec.parameters[0].range.1));
/// let model = with_effect(&Preset::default().model, effect);
/// let id = format!("{}.{}", spec.id, spec.parameters[0].id);
/// assert_eq!(model.get(&id), Some(spec.parameters[0].range.1));
/// ```
pub fn with_effect(model: &Model, effect: ActiveEffect) -> Model {
    let mut with = model.clone();
    with.effects.retain(|e| e.spec != effect.spec);
    with.effects.push(effect);
    with
}
