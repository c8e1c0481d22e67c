//! What an effect does: the places of the simulation at which it can attach.

use std::fmt;

use crate::model::drive::Segment;
use crate::model::parameter::Parameters;
use crate::model::piezo::{Branch, Piezo};
use crate::model::sensor::Point;
use crate::model::structure::Structure;

/// The device that an effect is built into.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    /// Its structure, with what effects before this one added.
    pub structure: &'a Structure,
    /// Its parameters.
    pub parameters: &'a Parameters,
    /// Its drive; `None` without one.
    pub piezo: Option<Piezo>,
}

/// Shortest time constant of an extra state \[s\]: far below what any recording or step resolves.
/// Its rate is still a number, and so is that rate times any input.
const SHORTEST_TIME_CONSTANT: f64 = 1e-30;

/// The time constant with which an extra state is followed \[s\], from the one asked for, above 0.
/// A shorter one than any that shows acts as its limit, none at all.
pub fn followed_time_constant(asked: f64) -> f64 {
    asked.max(SHORTEST_TIME_CONSTANT)
}

/// State of the device as an effect sees it. SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Kinematics {
    /// Time \[s\].
    pub t: f64,
    /// Displacement of the proof mass \[m\].
    pub xp: f64,
    /// Velocity of the proof mass [m/s].
    pub vp: f64,
    /// Displacement of the cantilever's centre \[m\].
    pub xc: f64,
    /// Velocity of the cantilever's centre [m/s].
    pub vc: f64,
    /// Voltage at the terminals \[V\].
    pub voltage: f64,
    /// `gc` that drives at present, all effects included; not known to
    /// [`Action::drive_voltage`] and [`Action::drive_gain`], which make it.
    pub gain: f64,
    /// Force of the gas film by eq (10) \[N\], 0 while the mass is held. Where a mass has sunk
    /// into a compliant ground, the film is as thick as at touch.
    pub film: f64,
}

/// What an effect does, at each of the places where it can attach. Every method
/// defaults to doing nothing. `z` are the effect's own extra states.
pub trait Action: Send + Sync + fmt::Debug {
    /// Whether the effect has strength zero: the device is then made without it, and its
    /// motion is the baseline's to the last bit.
    fn does_nothing(&self) -> bool {
        false
    }

    /// Whether it changes forces or drive while the mass flies or is held, or has states that
    /// are no readings. What it makes of structure, ground and sensor is none of that, nor is an
    /// [`Action::friction`] that is the same everywhere.
    fn acts_on_motion(&self) -> bool {
        true
    }

    /// Structure: adds or changes modes before the simulation starts.
    fn alter_structure(&self, _structure: &mut Structure) {}

    /// Extra states: decay rate of each [1/s]. State `k` obeys `z_k' = -rate_k z_k + u_k`.
    /// A state of rate 0 without input is a memory: it changes at the ends of pieces only,
    /// by [`Action::end_piece`].
    fn state_rates(&self) -> &[f64] {
        &[]
    }

    /// Extra states: the inputs `u_k`.
    fn state_inputs(&self, _at: &Kinematics, _z: &[f64], _inputs: &mut [f64]) {}

    /// Extra states: share of their rates at which they go here, above 0 to 1:
    /// `z_k' = pace (-rate_k z_k + u_k)`.
    fn pace(&self, _at: &Kinematics) -> f64 {
        1.0
    }

    /// Extra states: the reciprocal of the least such share.
    fn lasting(&self) -> f64 {
        1.0
    }

    /// Extra states: whether they are forces on the proof mass \[N\], which then need be no more
    /// exact than its motion asks for; others are told as exactly for their size as that is.
    fn states_are_forces(&self) -> bool {
        false
    }

    /// Extra states: whether their inputs feel the motion, and not the drive alone.
    fn states_feel_motion(&self) -> bool {
        !self.state_rates().is_empty()
    }

    /// Extra states: what a memory holds where everything has stood at `at` for long; states
    /// that decay are there already.
    fn settle(&self, _at: &Kinematics, _z: &mut [f64]) {}

    /// Drive: the piece of `segment` that begins at `t` over which the effect's law has no
    /// break; its end may be earlier, its hysteresis branch another.
    fn piece(&self, segment: Segment, _t: f64, _z: &[f64]) -> Segment {
        segment
    }

    /// Drive: whether all it does is to change the force of the drive, which goes by the voltage,
    /// the time and the states of such effects, and those by nothing of the motion.
    fn acts_on_drive(&self) -> bool {
        false
    }

    /// Drive: the voltage that the piezo film sees, from the one it would see without.
    fn drive_voltage(&self, voltage: f64, _at: &Kinematics, _z: &[f64]) -> f64 {
        voltage
    }

    /// Extra states: brings a memory up to date where a piece of the drive ends, the film
    /// seeing `film` \[V\]. Of `at` only `t`, `voltage` and `gain` are given.
    fn end_piece(&self, _at: &Kinematics, _film: f64, _z: &mut [f64]) {}

    /// Drive: the transducer's law `gc(V)` in place of the two branches, from theirs.
    /// `voltage` is what the film sees. Before [`Action::drive_gain`].
    fn hysteresis(&self, gain: f64, _voltage: f64, _branch: Branch, _z: &[f64]) -> f64 {
        gain
    }

    /// Drive: `gc`, from the one without.
    fn drive_gain(&self, gain: f64, _at: &Kinematics, _z: &[f64]) -> f64 {
        gain
    }

    /// Force on the proof mass \[N\], in flight and while it is held.
    fn force_on_proof_mass(&self, _at: &Kinematics, _z: &[f64]) -> f64 {
        0.0
    }

    /// Force of the gas film \[N\], from the one without; also while the mass is held, where
    /// the one without is 0.
    fn film_force(&self, film: f64, _z: &[f64]) -> f64 {
        film
    }

    /// Coulomb friction of the mass at `xp` \[m\], in newtons: it opposes the mass's motion with
    /// this force, and holds a mass at rest against any smaller one. That of all effects together
    /// is not below zero, of one it may be.
    fn friction(&self, _xp: f64) -> f64 {
        0.0
    }

    /// Whether [`Action::friction`] depends on where the mass is.
    fn friction_varies(&self) -> bool {
        false
    }

    /// Acceleration of the base [m/s^2], up positive. All displacements are relative to
    /// the base; the ground and the sensor move with it.
    fn base_acceleration(&self, _t: f64) -> f64 {
        0.0
    }

    /// Contact: reaction \[N\] of a ground into which the mass sinks, at a depth \[m\] and its
    /// rate [m/s], in place of the rigid stop. `None` leaves the ground rigid.
    fn contact_force(&self, _depth: f64, _rate: f64) -> Option<f64> {
        None
    }

    /// Contact: level of the ground \[m\], from the level without.
    fn ground_level(&self, level: f64, _t: f64) -> f64 {
        level
    }

    /// Contact: when the level of the ground jumps \[s\], if it does.
    fn ground_jump(&self) -> Option<f64> {
        None
    }

    /// Contact: adhesion \[N\] after `contact_time` \[s\], from the adhesion without and from
    /// what it is at touch.
    fn adhesion(&self, adhesion: f64, _at_touch: f64, _contact_time: f64) -> f64 {
        adhesion
    }

    /// Impact: restitution at approach speed `speed` > 0 [m/s], from the one without.
    fn restitution(&self, alpha: f64, _speed: f64) -> f64 {
        alpha
    }

    /// Sensor: whether it changes the readings.
    fn acts_on_readings(&self) -> bool {
        false
    }

    /// Sensor: the reading of a point at `t` \[m\], from the one without.
    fn reading(&self, reading: f64, _point: Point, _t: f64, _z: &[f64]) -> f64 {
        reading
    }

    /// Sensor: whether the effect's two states are the readings of proof mass and
    /// cantilever, so that a recording tells where they begin.
    fn reads_states(&self) -> bool {
        false
    }

    /// Sensor: time by which readings are late as a whole \[s\], not negative.
    fn reading_delay(&self) -> f64 {
        0.0
    }
}

/// An action that does nothing: that of an [`super::EffectSpec`] that states none.
#[derive(Debug)]
pub(super) struct Inert;

impl Action for Inert {
    fn does_nothing(&self) -> bool {
        true
    }

    fn acts_on_motion(&self) -> bool {
        false
    }
}
