//! A model made ready for time stepping: numbers instead of names, checked once.

mod forces;
mod ground;
mod states;

use std::ops::Range;
use std::sync::Arc;

use super::MAX_STATES;
use super::linear::Oscillator;
use crate::model::effects::{Action, Kinematics, Surroundings};
use crate::model::film::SqueezeFilm;
use crate::model::ground::{BounceRule, Ground};
use crate::model::parameter::ParameterId;
use crate::model::piezo::Piezo;
use crate::model::sensor::Sensor;
use crate::model::structure::{Held, Mode, Structure};
use crate::model::{MAX_MODES, Model, ModelError};

/// Number of first modes whose motion limits the step length.
const OWN_MODES: usize = 2;

/// An effect's action and which of the extra states are its own.
#[derive(Debug, Clone)]
struct Attached {
    id: &'static str,
    action: Arc<dyn Action>,
    first: usize,
    count: usize,
    /// Whether its states decay more slowly than their rates somewhere.
    lasts: bool,
}

/// The device as the stepper sees it.
#[derive(Debug, Clone)]
pub(super) struct Device {
    /// Modes in flight.
    pub flight: Vec<Oscillator>,
    /// Their shapes at the proof mass, the cantilever and the drive.
    pub phi_p: Vec<f64>,
    pub phi_c: Vec<f64>,
    pub phi_d: Vec<f64>,
    /// `phi_p . phi_p` [1/kg].
    pub mobility: f64,
    /// Modes with the mass held.
    pub held: Held,
    pub held_modes: Vec<Oscillator>,
    /// Decay rates of the extra states.
    pub rates: Vec<f64>,
    /// Which of them are forces on the proof mass \[N\].
    pub force_states: Vec<bool>,
    pub ground: Option<Ground>,
    /// Which arrivals at the ground are bounces.
    bounce: BounceRule,
    film: Option<SqueezeFilm>,
    /// Thickness below which the film counts as no thinner \[m\]; 0 leaves it singular.
    thinnest_film: f64,
    piezo: Option<Piezo>,
    eta: f64,
    effects: Vec<Attached>,
    /// Extra states on which the drive's force depends.
    drive_states: Vec<Range<usize>>,
    /// Coulomb friction of the mass where it does not depend on the place \[N\].
    friction: f64,
    /// Whether it depends on the place.
    friction_varies: bool,
    /// See [`Self::is_moved_by_effects`].
    moved: bool,
    /// Whether effects change the motion through the drive alone.
    pub only_drive: bool,
    /// Whether effects change the readings.
    pub alters_readings: bool,
    /// Whether the film's force is that of eq (10), at the same instant.
    pub film_is_plain: bool,
    /// The effect whose contact law replaces the rigid stop.
    compliant: Option<usize>,
    /// Force on each mode, in flight and held, per acceleration of the base.
    pub flight_base: Vec<f64>,
    pub held_base: Vec<f64>,
    pull: Pull,
    /// Static displacement of the cantilever per level of the held mass.
    pub anchor_c: f64,
    pub sensor: Sensor,
    pub has_cantilever: bool,
    /// Longest time over which an error in velocity grows into displacement \[s\].
    pub time_scale: f64,
    /// Displacement and velocity of the proof mass at t = 0.
    pub initial: (f64, f64),
    /// Displacement of either point per drive force, over that of the proof mass per
    /// force on it: weighs errors of the drive.
    pub drive_ratio: f64,
}

impl Device {
    /// Checks and compiles `model`.
    pub fn new(model: &Model) -> Result<Self, ModelError> {
        model.check()?;
        let parameters = &model.parameters;
        let mut structure = model.structure();
        let AttachedEffects {
            effects,
            rates,
            force_states,
        } = AttachedEffects::attach(model, &mut structure)?;
        let friction_varies = effects.iter().any(|e| e.action.friction_varies());
        let friction = friction_at(&effects, 0.0);
        let film_is_plain = effects.iter().all(|e: &Attached| {
            let unmoved = [0.0; MAX_STATES];
            e.action.film_force(1.0, &unmoved[..e.count]) == 1.0
        });
        let yields = |e: &Attached| e.action.contact_force(0.0, 0.0).is_some();
        let compliant = effects.iter().position(yields).filter(|_| model.has_ground);
        let column = |f: fn(&Mode) -> f64| structure.modes.iter().map(f).collect();
        let phi_p: Vec<f64> = column(|m| m.phi_p);
        let phi_c: Vec<f64> = column(|m| m.phi_c);
        let phi_d: Vec<f64> = column(|m| m.phi_drive);
        let flight: Vec<Oscillator> = structure
            .modes
            .iter()
            .map(|m| Oscillator {
                omega2: m.omega() * m.omega(),
                damping: m.damping(),
            })
            .collect();
        let mobility = structure.mobility();
        let held = structure.held();
        let flight_base: Vec<f64> = structure.participation().iter().map(|g| -g).collect();
        let held_base = held.project(&flight_base);
        let held_modes: Vec<Oscillator> = held
            .omega2
            .iter()
            .zip(&held.damping)
            .map(|(&omega2, &damping)| Oscillator { omega2, damping })
            .collect();
        let pull = Pull::new(&flight, &held, &phi_p, &phi_d, mobility);
        let drive_ratio = (0..flight.len())
            .map(|i| phi_d[i].abs() * phi_p[i].abs().max(phi_c[i].abs()))
            .sum::<f64>()
            / mobility;
        let film = model.has_ground.then(|| SqueezeFilm::new(parameters));
        let ground = model.has_ground.then(|| Ground::new(parameters));
        let moving = || effects.iter().filter(|e| e.action.acts_on_motion());
        let mut device = Self {
            drive_states: {
                let drives = effects.iter().filter(|e| e.action.acts_on_drive());
                drives.map(|e| e.first..e.first + e.count).collect()
            },
            moved: moving().next().is_some(),
            only_drive: moving().all(|e| e.action.acts_on_drive()),
            alters_readings: effects.iter().any(|e| e.action.acts_on_readings()),
            friction,
            friction_varies,
            film_is_plain,
            compliant,
            flight_base,
            held_base,
            drive_ratio,
            anchor_c: dot(&phi_c, &held.anchor),
            pull,
            time_scale: longest_time_constant(&flight),
            flight,
            phi_p,
            phi_c,
            phi_d,
            mobility,
            held,
            held_modes,
            rates,
            force_states,
            ground,
            bounce: model.bounce,
            film,
            thinnest_film: 0.0,
            piezo: model.piezo,
            eta: parameters[ParameterId::Eta],
            effects,
            sensor: Sensor::new(parameters),
            has_cantilever: model.has_cantilever,
            initial: (parameters[ParameterId::X0], parameters[ParameterId::V0]),
        };
        if device.is_compliant() {
            device.bound_film();
        }
        Ok(device)
    }

    /// Whether there are effects of any kind.
    pub fn has_effects(&self) -> bool {
        !self.effects.is_empty()
    }

    /// Whether anything but film, drive, structure and friction acts between events.
    pub fn is_moved_by_effects(&self) -> bool {
        self.moved
    }

    /// Whether Coulomb friction acts on the mass anywhere.
    #[inline]
    pub fn has_friction(&self) -> bool {
        self.friction > 0.0 || self.friction_varies
    }

    /// Coulomb friction of the mass at `xp` \[N\], not negative.
    #[inline]
    pub fn friction(&self, xp: f64) -> f64 {
        if self.friction_varies {
            friction_at(&self.effects, xp)
        } else {
            self.friction
        }
    }

    /// Id of the effect that makes a motion hard to follow, if effects change it: that of a compliant
    /// ground, else the only one; "effects" if it can be several.
    pub fn suspect(&self) -> Option<&'static str> {
        if let Some(own) = self.compliant {
            return Some(self.effects[own].id);
        }
        let mut suspects = self
            .effects
            .iter()
            .filter(|e| e.action.acts_on_motion() || !e.action.acts_on_readings());
        let first = suspects.next()?;
        Some(suspects.next().map_or(first.id, |_| "effects"))
    }

    /// Longest step that follows the structure's motion, in flight and held \[s\].
    pub fn longest_step(&self) -> f64 {
        self.flight
            .iter()
            .chain(&self.held_modes)
            .map(Oscillator::longest_step)
            .fold(f64::INFINITY, f64::min)
    }

    /// Longest steps in flight and held where only readings are needed: those of the first two
    /// modes. The free motion of the others is exact for any step, and its effect on the forces
    /// of flight is part of a step's error estimate.
    pub fn longest_steps_to_read(&self) -> [f64; 2] {
        let own = self.flight.iter().take(OWN_MODES);
        let others = self.flight.iter().skip(OWN_MODES);
        let flight = own
            .chain(others.filter(|o| !o.swings()))
            .map(Oscillator::longest_step)
            .fold(f64::INFINITY, f64::min);
        let held = self.held_modes.iter().map(Oscillator::longest_step);
        [flight, held.fold(flight, f64::min)]
    }

    /// Whether a mode that moves the mass vibrates through more than a period in a step of flight
    /// of `h` \[s\].
    pub fn outswings(&self, h: f64) -> bool {
        let mut all = self.flight.iter().zip(&self.phi_p);
        all.any(|(o, phi)| *phi != 0.0 && h > o.longest_step())
    }

    /// What effects see in flight, from modal coordinates.
    pub fn flight_kinematics(&self, t: f64, voltage: f64, q: &[f64], v: &[f64]) -> Kinematics {
        let (xp, vp) = (dot(&self.phi_p, q), dot(&self.phi_p, v));
        Kinematics {
            t,
            xp,
            vp,
            xc: dot(&self.phi_c, q),
            vc: dot(&self.phi_c, v),
            voltage,
            gain: 0.0,
            film: self.film_force(xp, vp),
        }
    }

    /// What effects see with the mass held at `level`, from held coordinates.
    pub fn held_kinematics(
        &self,
        t: f64,
        voltage: f64,
        level: f64,
        r: &[f64],
        dr: &[f64],
    ) -> Kinematics {
        Kinematics {
            t,
            xp: level,
            vp: 0.0,
            xc: level * self.anchor_c + dot(&self.held.cantilever, r),
            vc: dot(&self.held.cantilever, dr),
            voltage,
            gain: 0.0,
            film: 0.0,
        }
    }
}

/// The effects that do something, with the extra states of all.
struct AttachedEffects {
    effects: Vec<Attached>,
    /// Decay rate of each extra state [1/s].
    rates: Vec<f64>,
    /// Whether each extra state is a force on the proof mass \[N\].
    force_states: Vec<bool>,
}

impl AttachedEffects {
    /// Builds the model's effects; those that change the structure change it here.
    fn attach(model: &Model, structure: &mut Structure) -> Result<Self, ModelError> {
        let mut effects = Vec::with_capacity(model.effects.len());
        let (mut rates, mut force_states) = (Vec::new(), Vec::new());
        // The effect that added the latest modes.
        let mut adds_modes = "effects";
        for effect in &model.effects {
            let action: Arc<dyn Action> = Arc::from((effect.spec.build)(
                &effect.values,
                &Surroundings {
                    structure,
                    parameters: &model.parameters,
                    piezo: model.piezo,
                },
            ));
            if action.does_nothing() {
                continue;
            }
            let known_modes = structure.modes.len();
            action.alter_structure(structure);
            if structure.modes.len() > known_modes {
                adds_modes = effect.spec.id;
            }
            let first = rates.len();
            let own_rates = action.state_rates();
            if let Some(rate) = own_rates.iter().find(|r| !(r.is_finite() && **r >= 0.0)) {
                return Err(ModelError {
                    parameter: effect.spec.id.to_owned(),
                    reason: format!(
                        "a state of it decays at {rate} 1/s, which cannot be followed; make its times longer"
                    ),
                });
            }
            rates.extend_from_slice(own_rates);
            force_states.resize(rates.len(), action.states_are_forces());
            effects.push(Attached {
                id: effect.spec.id,
                lasts: action.lasting() > 1.0,
                action,
                first,
                count: rates.len() - first,
            });
        }
        if structure.modes.len() > MAX_MODES {
            return Err(ModelError {
                parameter: adds_modes.to_owned(),
                reason: format!(
                    "{} modes are more than {MAX_MODES}; switch it off",
                    structure.modes.len()
                ),
            });
        }
        if rates.len() > MAX_STATES {
            return Err(ModelError {
                parameter: "effects".to_owned(),
                reason: format!(
                    "the effects have {} states together, more than {}; switch some off",
                    rates.len(),
                    MAX_STATES
                ),
            });
        }
        Ok(Self {
            effects,
            rates,
            force_states,
        })
    }
}

/// What the pull-off force, eq (13), is made of: its share per held coordinate, per velocity of
/// one, per level of the mass and per drive force.
#[derive(Debug, Clone)]
struct Pull {
    per_position: Vec<f64>,
    per_velocity: Vec<f64>,
    per_level: f64,
    per_drive: f64,
}

impl Pull {
    fn new(
        flight: &[Oscillator],
        held: &Held,
        phi_p: &[f64],
        phi_d: &[f64],
        mobility: f64,
    ) -> Self {
        let m = held.omega2.len();
        let onto_mass = |weight: &dyn Fn(usize) -> f64| -> f64 {
            (0..flight.len()).map(|i| phi_p[i] * weight(i)).sum::<f64>() / mobility
        };
        Self {
            per_position: (0..m)
                .map(|k| -onto_mass(&|i| flight[i].omega2 * held.basis[i * m + k]))
                .collect(),
            per_velocity: (0..m)
                .map(|k| -onto_mass(&|i| flight[i].damping * held.basis[i * m + k]))
                .collect(),
            per_level: -onto_mass(&|i| flight[i].omega2 * held.anchor[i]),
            per_drive: onto_mass(&|i| phi_d[i]),
        }
    }
}

/// Friction of all effects on the mass at `xp` \[N\]: not below zero.
fn friction_at(effects: &[Attached], xp: f64) -> f64 {
    let all: f64 = effects.iter().map(|e| e.action.friction(xp)).sum();
    all.max(0.0)
}

/// One over the lowest angular frequency of the modes \[s\]; 1 s if none is bound.
fn longest_time_constant(flight: &[Oscillator]) -> f64 {
    let slowest = flight
        .iter()
        .map(|o| o.omega2.sqrt())
        .filter(|&w| w > 0.0)
        .fold(f64::INFINITY, f64::min);
    if slowest.is_finite() {
        1.0 / slowest
    } else {
        1.0
    }
}

/// Sum of products.
#[inline]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
