//! A model made ready for time stepping: numbers instead of names, checked once.

use std::sync::Arc;

use crate::model::drive::Segment;
use crate::model::effects::{Action, Kinematics, Surroundings};
use crate::model::film::SqueezeFilm;
use crate::model::ground::Ground;
use crate::model::parameter::ParameterId;
use crate::model::piezo::{Branch, Piezo};
use crate::model::sensor::{Point, Sensor};
use crate::model::structure::Held;
use crate::model::{Model, ModelError};

use super::linear::Oscillator;

/// An effect's action and which of the extra states are its own.
#[derive(Debug, Clone)]
struct Attached {
    id: &'static str,
    action: Arc<dyn Action>,
    first: usize,
    count: usize,
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
    pub ground: Option<Ground>,
    film: Option<SqueezeFilm>,
    /// Thickness below which the film counts as no thinner [m]; 0 leaves it singular.
    thinnest_film: f64,
    piezo: Option<Piezo>,
    eta: f64,
    effects: Vec<Attached>,
    /// Coulomb friction of the mass [N].
    pub friction: f64,
    /// Whether the film's force is that of eq (10), at the same instant.
    pub film_is_plain: bool,
    /// Which effect's law of contact stands in place of the rigid stop.
    compliant: Option<usize>,
    /// Force on each mode, in flight and held, per acceleration of the base.
    pub flight_base: Vec<f64>,
    pub held_base: Vec<f64>,
    /// Pull-off force per held coordinate, per its velocity, per level and per drive force.
    pull_position: Vec<f64>,
    pull_velocity: Vec<f64>,
    pull_level: f64,
    pull_drive: f64,
    /// Static displacement of the cantilever per level of the held mass.
    pub anchor_c: f64,
    pub sensor: Sensor,
    pub has_cantilever: bool,
    /// Longest time over which an error in velocity grows into displacement [s].
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
        let mut effects = Vec::with_capacity(model.effects.len());
        let mut rates = Vec::new();
        for effect in &model.effects {
            let action: Arc<dyn Action> = Arc::from((effect.spec.build)(
                &effect.values,
                &Surroundings {
                    structure: &structure,
                    parameters,
                    piezo: model.piezo,
                },
            ));
            if action.does_nothing() {
                continue;
            }
            action.alter_structure(&mut structure);
            let first = rates.len();
            rates.extend_from_slice(action.state_rates());
            effects.push(Attached {
                id: effect.spec.id,
                action,
                first,
                count: rates.len() - first,
            });
        }
        if rates.len() > super::MAX_STATES {
            return Err(ModelError {
                parameter: "effects".to_owned(),
                reason: format!(
                    "the effects have {} states together, more than {}; switch some off",
                    rates.len(),
                    super::MAX_STATES
                ),
            });
        }
        let friction = effects.iter().map(|e| e.action.friction().max(0.0)).sum();
        let film_is_plain = effects.iter().all(|e: &Attached| {
            let unmoved = [0.0; super::MAX_STATES];
            e.action.film_force(1.0, &unmoved[..e.count]) == 1.0
        });
        let yields = |e: &Attached| e.action.contact_force(0.0, 0.0).is_some();
        let compliant = effects.iter().position(yields).filter(|_| model.has_ground);
        let column =
            |f: fn(&crate::model::structure::Mode) -> f64| structure.modes.iter().map(f).collect();
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
        let m = held_modes.len();
        let onto_mass = |weight: &dyn Fn(usize) -> f64| -> f64 {
            (0..flight.len()).map(|i| phi_p[i] * weight(i)).sum::<f64>() / mobility
        };
        let pull_position = (0..m)
            .map(|k| -onto_mass(&|i| flight[i].omega2 * held.basis[i * m + k]))
            .collect();
        let pull_velocity = (0..m)
            .map(|k| -onto_mass(&|i| flight[i].damping * held.basis[i * m + k]))
            .collect();
        let slowest = flight
            .iter()
            .map(|o| o.omega2.sqrt())
            .filter(|&w| w > 0.0)
            .fold(f64::INFINITY, f64::min);
        let drive_ratio = (0..flight.len())
            .map(|i| phi_d[i].abs() * phi_p[i].abs().max(phi_c[i].abs()))
            .sum::<f64>()
            / mobility;
        let film = model.has_ground.then(|| SqueezeFilm::new(parameters));
        let ground = model.has_ground.then(|| Ground::new(parameters));
        let mut device = Self {
            friction,
            film_is_plain,
            compliant,
            flight_base,
            held_base,
            drive_ratio,
            anchor_c: dot(&phi_c, &held.anchor),
            pull_level: -onto_mass(&|i| flight[i].omega2 * held.anchor[i]),
            pull_drive: onto_mass(&|i| phi_d[i]),
            pull_position,
            pull_velocity,
            flight,
            phi_p,
            phi_c,
            phi_d,
            mobility,
            held,
            held_modes,
            rates,
            ground,
            film,
            thinnest_film: 0.0,
            piezo: model.piezo,
            eta: parameters[ParameterId::Eta],
            effects,
            sensor: Sensor::new(parameters),
            has_cantilever: model.has_cantilever,
            time_scale: if slowest.is_finite() {
                1.0 / slowest
            } else {
                1.0
            },
            initial: (parameters[ParameterId::X0], parameters[ParameterId::V0]),
        };
        if device.is_compliant() {
            device.bound_film();
        }
        Ok(device)
    }

    /// Whether the mass sinks into the ground.
    pub fn is_compliant(&self) -> bool {
        self.compliant.is_some()
    }

    /// Force on the mass from a compliant ground [N]: its reaction at a depth [m] and rate
    /// [m/s], less the adhesion after `contact_time` [s].
    pub fn contact_force(&self, depth: f64, rate: f64, contact_time: f64) -> f64 {
        let law = self.compliant.and_then(|i| self.effects.get(i));
        let reaction = law.and_then(|e| e.action.contact_force(depth, rate));
        reaction.unwrap_or(0.0) - self.adhesion(contact_time).max(0.0)
    }

    /// Change of [`Self::contact_force`] per displacement and per velocity of the mass.
    pub fn contact_slopes(&self, depth: f64, rate: f64) -> (f64, f64) {
        let force = |depth, rate| self.contact_force(depth, rate, 0.0);
        let (dx, dv) = (1e-6 * depth.abs() + 1e-16, 1e-6 * rate.abs() + 1e-12);
        (
            (force(depth - dx, rate) - force(depth + dx, rate)) / (2.0 * dx),
            (force(depth, rate - dv) - force(depth, rate + dv)) / (2.0 * dv),
        )
    }

    /// Acceleration of the base [m/s^2].
    pub fn base_acceleration(&self, t: f64) -> f64 {
        self.effects
            .iter()
            .map(|e| e.action.base_acceleration(t))
            .sum()
    }

    /// Whether forces beyond film and drive act.
    pub fn has_effects(&self) -> bool {
        !self.effects.is_empty()
    }

    /// Longest step that follows the structure's motion, in flight and held [s].
    pub fn longest_step(&self) -> f64 {
        self.flight
            .iter()
            .chain(&self.held_modes)
            .map(Oscillator::longest_step)
            .fold(f64::INFINITY, f64::min)
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

    /// Lets the film grow no thinner than half of what it is at contact: a stretch that
    /// is not stopped by the ground may then reach below it.
    pub fn bound_film(&mut self) {
        if let (Some(film), Some(ground)) = (&self.film, &self.ground) {
            self.thinnest_film = 0.5 * (film.gap + ground.level);
        }
    }

    /// Film force on the proof mass [N].
    #[inline]
    pub fn film_force(&self, xp: f64, vp: f64) -> f64 {
        self.film.map_or(0.0, |film| {
            film.force(xp.max(self.thinnest_film - film.gap), vp)
        })
    }

    /// Change of the film force per displacement and per velocity.
    #[inline]
    pub fn film_slopes(&self, xp: f64, vp: f64) -> (f64, f64) {
        self.film.map_or((0.0, 0.0), |film| {
            let thickness = (xp + film.gap).max(self.thinnest_film);
            let per_velocity = -film.coefficient / (thickness * thickness * thickness);
            let thins = xp + film.gap > self.thinnest_film;
            let per_height = -3.0 * per_velocity * vp / thickness;
            (if thins { per_height } else { 0.0 }, per_velocity)
        })
    }

    /// Whether the film is singular at `xp`.
    #[inline]
    pub fn is_inside_film(&self, xp: f64) -> bool {
        self.film.is_none_or(|film| {
            film.coefficient == 0.0 || self.thinnest_film > 0.0 || xp > -film.gap
        })
    }

    /// All effects' forces on the proof mass [N], but for friction and what they make of
    /// the film.
    pub fn effect_force(&self, at: &Kinematics, z: &[f64]) -> f64 {
        self.effects
            .iter()
            .map(|e| {
                e.action
                    .force_on_proof_mass(at, &z[e.first..e.first + e.count])
            })
            .sum()
    }

    /// Film force on the proof mass with what effects make of it [N].
    pub fn altered_film_force(&self, at: &Kinematics, z: &[f64]) -> f64 {
        self.effects.iter().fold(at.film, |film, e| {
            e.action.film_force(film, &z[e.first..e.first + e.count])
        })
    }

    /// What pulls the held mass besides structure and drive [N]: effects' forces, the
    /// film that they alter, and the base.
    pub fn force_on_held(&self, at: &Kinematics, z: &[f64]) -> f64 {
        if self.effects.is_empty() {
            return 0.0;
        }
        let film = self.altered_film_force(at, z);
        self.effect_force(at, z) + film - self.base_acceleration(at.t) / self.mobility
    }

    /// Voltage that the piezo film sees [V].
    fn film_voltage(&self, at: &Kinematics, z: &[f64]) -> f64 {
        self.effects.iter().fold(at.voltage, |voltage, e| {
            let own = &z[e.first..e.first + e.count];
            e.action.drive_voltage(voltage, at, own)
        })
    }

    /// Force where the piezo drives the cantilever [N]; notes the gain in `at`.
    pub fn drive_force(&self, at: &mut Kinematics, branch: Branch, z: &[f64]) -> f64 {
        let Some(piezo) = self.piezo else {
            return 0.0;
        };
        let own = |e: &Attached| e.first..e.first + e.count;
        let voltage = self.film_voltage(at, z);
        let branches = piezo.gain(voltage, branch);
        let gain = self.effects.iter().fold(branches, |gain, e| {
            e.action.hysteresis(gain, voltage, branch, &z[own(e)])
        });
        at.gain = self
            .effects
            .iter()
            .fold(gain, |gain, e| e.action.drive_gain(gain, at, &z[own(e)]));
        self.eta * at.gain
    }

    /// Brings the effects' memories up to date where a piece of the drive ends.
    pub fn end_piece(&self, piece: &Segment, t: f64, z: &mut [f64]) {
        if self.effects.is_empty() {
            return;
        }
        let mut at = Kinematics {
            t,
            voltage: piece.shape.voltage(t),
            ..Kinematics::default()
        };
        self.drive_force(&mut at, piece.branch, z);
        at.voltage = self.film_voltage(&at, z);
        for e in &self.effects {
            e.action.end_piece(&at, &mut z[e.first..e.first + e.count]);
        }
    }

    /// The piece of a drive's segment that begins at `t` over which no effect's law breaks.
    pub fn piece(&self, segment: Segment, t: f64, z: &[f64]) -> Segment {
        let mut piece = self.effects.iter().fold(segment, |piece, e| {
            e.action.piece(piece, t, &z[e.first..e.first + e.count])
        });
        // Time goes on whatever an effect says.
        if piece.end <= t {
            piece.end = segment.end.min(t + 1e-12 * (1.0 + t.abs()));
        }
        piece
    }

    /// The piezo's force at a voltage [N], without effects.
    #[inline]
    pub fn piezo_force(&self, voltage: f64, branch: Branch) -> f64 {
        self.piezo
            .map_or(0.0, |piezo| self.eta * piezo.gain(voltage, branch))
    }

    /// Inputs of the extra states.
    pub fn state_inputs(&self, at: &Kinematics, z: &[f64], inputs: &mut [f64]) {
        for e in &self.effects {
            let own = e.first..e.first + e.count;
            e.action.state_inputs(at, &z[own.clone()], &mut inputs[own]);
        }
    }

    /// Extra states as if everything had stood at `at` for long.
    pub fn settled_states(&self, at: &Kinematics) -> Vec<f64> {
        let mut z = vec![0.0; self.rates.len()];
        let mut input = vec![0.0; z.len()];
        // States that feed on others settle one after the other.
        for _ in 0..3 {
            self.state_inputs(at, &z, &mut input);
            for ((z, u), rate) in z.iter_mut().zip(&input).zip(&self.rates) {
                *z = if *rate > 0.0 { u / rate } else { 0.0 };
            }
        }
        z
    }

    /// Extra states taken over from `other`, whose are `z`; those of effects that it has
    /// not are as in `settled`.
    pub fn adopt_states(&self, other: &Self, z: &[f64], mut settled: Vec<f64>) -> Vec<f64> {
        for own in &self.effects {
            let same = |e: &&Attached| e.id == own.id && e.count == own.count;
            if let Some(theirs) = other.effects.iter().find(same) {
                settled[own.first..own.first + own.count]
                    .copy_from_slice(&z[theirs.first..theirs.first + theirs.count]);
            }
        }
        settled
    }

    /// Level of the ground at `t` [m].
    #[inline]
    pub fn ground_level(&self, t: f64) -> f64 {
        let level = self.ground.map_or(f64::NEG_INFINITY, |g| g.level);
        self.effects
            .iter()
            .fold(level, |level, e| e.action.ground_level(level, t))
    }

    /// Adhesion after `contact_time` [N].
    #[inline]
    pub fn adhesion(&self, contact_time: f64) -> f64 {
        let adhesion = self.ground.map_or(0.0, |g| g.adhesion(contact_time));
        let at_touch = self.ground.map_or(0.0, |g| g.adhesion_start);
        self.effects.iter().fold(adhesion, |adhesion, e| {
            e.action.adhesion(adhesion, at_touch, contact_time)
        })
    }

    /// Coefficient of restitution at approach speed `speed` [m/s].
    pub fn restitution(&self, speed: f64) -> f64 {
        let alpha = self.ground.map_or(0.0, |g| g.alpha);
        self.effects
            .iter()
            .fold(alpha, |alpha, e| e.action.restitution(alpha, speed))
    }

    /// The sensor's reading of a point that is at `x` [m] at time `t`.
    #[inline]
    pub fn reading(&self, x: f64, point: Point, t: f64, z: &[f64]) -> f64 {
        self.apparent(x, point, t, z)
            + match point {
                Point::ProofMass => self.sensor.offset_p,
                Point::Cantilever => self.sensor.offset_c,
            }
    }

    /// The reading without the sensor's constant offset.
    #[inline]
    pub fn apparent(&self, x: f64, point: Point, t: f64, z: &[f64]) -> f64 {
        self.effects.iter().fold(x, |x, e| {
            e.action
                .reading(x, point, t, &z[e.first..e.first + e.count])
        })
    }

    /// Where the extra states stand that are the readings of proof mass and cantilever.
    pub fn reading_states(&self) -> Option<usize> {
        let lagged = |e: &&Attached| e.count > 0 && e.action.reads_states();
        self.effects.iter().find(lagged).map(|e| e.first)
    }

    /// Time by which all readings are late [s].
    pub fn reading_delay(&self) -> f64 {
        self.effects
            .iter()
            .map(|e| e.action.reading_delay())
            .sum::<f64>()
            .max(0.0)
    }

    /// Pull-off force, eq (13), of the held mass from held coordinates.
    #[inline]
    pub fn pull_held(&self, r: &[f64], dr: &[f64], level: f64, drive: f64, on_mass: f64) -> f64 {
        let mut pull = on_mass + self.pull_level * level + self.pull_drive * drive;
        for k in 0..r.len() {
            pull += self.pull_position[k] * r[k] + self.pull_velocity[k] * dr[k];
        }
        pull
    }

    /// Pull-off force, eq (13), as if the mass were held, from modal coordinates in flight.
    pub fn pull_flight(&self, q: &[f64], dq: &[f64], drive: f64, on_mass: f64) -> f64 {
        let structure: f64 = (0..q.len())
            .map(|i| {
                self.phi_p[i] * (self.flight[i].omega2 * q[i] + self.flight[i].damping * dq[i])
            })
            .sum();
        on_mass + self.pull_drive * drive - structure / self.mobility
    }
}

/// Sum of products.
#[inline]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
