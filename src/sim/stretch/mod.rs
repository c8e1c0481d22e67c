//! Stretches of flight or of held motion from a given state, without looking for events:
//! what a fit compares with the data between the events that the data show.
//!
//! A [`StretchSimulator`] is a model made ready once; it is shared by all threads, and
//! its propagators are made once for all stretches. Each thread steps with a
//! [`Stretcher`](propagate::Stretcher) of its own, which allocates nothing per step but what
//! readings that lag need.

#[cfg(test)]
mod friction_tests;
mod memory;
mod motion;
pub mod prescribed_motion;
pub(crate) mod propagate;
mod sample_clock;
mod sampled_step;
#[cfg(test)]
mod tests;

use super::device::Device;
use super::error::{Options, SimError};
use super::step::tables::{Tables, phase_tables};
use crate::model::Model;
use crate::model::drive::{Segment, Shape};
use crate::model::piezo::Branch;
use crate::model::structure::Held;

/// State of the structure and of the effects at one instant. In flight `q`, `v` are the
/// modal coordinates and their velocities (as many as modes); held, those of the
/// structure with the mass held (one fewer).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StretchState {
    /// Coordinates \[kg^1/2 m\].
    pub q: Vec<f64>,
    /// Their velocities \[kg^1/2 m/s\].
    pub v: Vec<f64>,
    /// Extra states of the effects.
    pub z: Vec<f64>,
}

/// Displacements and velocities of the two points, without the sensor's offsets.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Points {
    /// Proof mass \[m\].
    pub xp: f64,
    /// Its velocity \[m/s\].
    pub vp: f64,
    /// Cantilever \[m\].
    pub xc: f64,
    /// Its velocity \[m/s\].
    pub vc: f64,
}

/// A device made ready for stretches.
#[derive(Debug, Clone)]
pub struct StretchSimulator {
    device: Device,
    flight: Tables,
    held: Tables,
    /// Level of the longest step in which a mass with friction is seen to stop.
    coarsest: usize,
    tolerance: f64,
}

impl StretchSimulator {
    /// Compiles `model`; of `options` only the tolerance counts. Below the ground, where
    /// a stretch that no event stops may come, the film stays as thick as half of what
    /// it is at contact.
    ///
    /// # Errors
    /// [`SimError`] if model or options make no sense.
    pub fn new(model: &Model, options: &Options) -> Result<Self, SimError> {
        options.check()?;
        let mut device = Device::new(model)?;
        device.bound_film();
        let [flight, held] = phase_tables(&device, options, device.longest_steps_to_read());
        // Where friction lets the mass stop, that is looked for, too.
        let coarsest = if device.has_friction() {
            flight.within(device.longest_step())
        } else {
            0
        };
        Ok(Self {
            device,
            flight,
            held,
            coarsest,
            tolerance: options.tolerance,
        })
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.device.flight.len()
    }

    /// Decay rates of the effects' extra states \[1/s\].
    pub fn state_rates(&self) -> &[f64] {
        &self.device.rates
    }

    /// Shapes of the modes in flight at the proof mass and at the cantilever.
    pub fn flight_shapes(&self) -> (&[f64], &[f64]) {
        (&self.device.phi_p, &self.device.phi_c)
    }

    /// The structure with the mass held.
    pub fn held_structure(&self) -> &Held {
        &self.device.held
    }

    /// Squared angular frequencies of the modes in flight \[1/s^2\].
    pub fn flight_omega2(&self) -> impl Iterator<Item = f64> + '_ {
        self.device.flight.iter().map(|o| o.omega2)
    }

    /// Squared angular frequencies of the modes with the mass held \[1/s^2\].
    pub fn held_omega2(&self) -> impl Iterator<Item = f64> + '_ {
        self.device.held_modes.iter().map(|o| o.omega2)
    }

    /// Where the extra states stand that are the readings of proof mass and cantilever.
    pub fn reading_states(&self) -> Option<usize> {
        self.device.reading_states()
    }

    /// Time by which readings are late \[s\].
    pub fn reading_delay(&self) -> f64 {
        self.device.reading_delay()
    }

    /// Level of the ground at `t` \[m\]; minus infinity without one.
    pub fn ground_level(&self, t: f64) -> f64 {
        self.device.ground_level(t)
    }

    /// When the ground jumps for the first time after `from`, before `to` \[s\].
    pub fn ground_jump(&self, from: f64, to: f64) -> Option<f64> {
        self.device.ground_jump(from, to)
    }

    /// Force that holds the mass on the ground after `contact_time` \[N\]: adhesion where
    /// it is not negative, and friction.
    pub fn adhesion(&self, contact_time: f64) -> f64 {
        let level = self.device.ground.map_or(0.0, |g| g.level);
        self.device.adhesion(contact_time).max(0.0) + self.device.friction(level)
    }

    /// Coefficient of restitution at an approach speed \[m/s\].
    pub fn restitution(&self, speed: f64) -> f64 {
        self.device.restitution(speed)
    }
}

/// The segment that holds `t`; the first or last one beyond the drive's ends.
fn segment_at(drive: &[Segment], t: f64) -> Segment {
    let index = drive.partition_point(|s| s.end <= t);
    let segment = drive.get(index).or(drive.last());
    segment.copied().unwrap_or(Segment {
        start: f64::NEG_INFINITY,
        end: f64::INFINITY,
        shape: Shape::Constant { voltage: 0.0 },
        branch: Branch::Poled,
    })
}
