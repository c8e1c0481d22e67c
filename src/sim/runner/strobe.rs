//! A run stopped at given instants, its whole state taken out and put back: what maps from one
//! period of the drive to the next are made of.

use super::pace::Pace;
use super::{Phase, Runner};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::error::SimError;
use crate::sim::output::SampleRange;
use crate::sim::step::Touch;
use crate::sim::stretch::StretchState;
use crate::sim::trace::Trace;

/// An instant within this many roundings of the end is the end: edges of a drive are counted by
/// periods and halves of periods, which do not add up to the same last bit.
const END_ROUNDINGS: f64 = 16.0;

/// Instants of a period at which forces that depend on time are compared with a period later.
const INSTANTS_COMPARED: usize = 61;
/// Forces that depend on time repeat if they do within this share of the largest.
const REPEATED_SHARE: f64 = 1e-6;

/// How the proof mass moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionPhase {
    /// It flies, or has sunk into a compliant ground.
    Flight,
    /// It is on the ground at `level` \[m\] since `since` \[s\].
    Held {
        /// Beginning of the contact \[s\].
        since: f64,
        /// Where \[m\].
        level: f64,
    },
    /// Friction holds it at `level` \[m\], away from a rigid ground.
    Stuck {
        /// Where \[m\].
        level: f64,
    },
}

/// All that decides how a run goes on from one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionState {
    /// The instant \[s\].
    pub time: f64,
    /// How the mass moves.
    pub phase: MotionPhase,
    /// Coordinates of that phase: modes in flight, or those of the structure with the mass held
    /// (one fewer), and the effects' extra states.
    pub coordinates: StretchState,
    /// A mass that has sunk into a compliant ground: level of that \[m\], and since when \[s\].
    pub sunk: Option<(f64, f64)>,
    /// Direction in which it slides against friction: 1, -1 or 0.
    pub sliding: f64,
}

impl Runner {
    /// Takes no samples from now on: events alone are noted.
    pub fn stop_sampling(&mut self) {
        self.samples.end = 0;
    }

    /// The present state.
    pub fn motion_state(&self) -> MotionState {
        let (q, v, phase) = match self.phase {
            Phase::Flight => (&self.q, &self.v, MotionPhase::Flight),
            Phase::Held { since, level } => (&self.r, &self.dr, MotionPhase::Held { since, level }),
            Phase::Stuck { level } => (&self.r, &self.dr, MotionPhase::Stuck { level }),
        };
        MotionState {
            time: self.t,
            phase,
            coordinates: StretchState {
                q: q.clone(),
                v: v.clone(),
                z: self.z.clone(),
            },
            sunk: self.touch.map(|touch| (touch.level, touch.since)),
            sliding: self.sliding,
        }
    }

    /// Goes on from `state`, of this device, as if it had come there. Budgets of steps and events
    /// begin anew.
    ///
    /// # Errors
    /// [`SimError::Options`] if the state has not as many coordinates as the device.
    pub fn restore(&mut self, state: &MotionState) -> Result<(), SimError> {
        let coordinates = &state.coordinates;
        let modes = match state.phase {
            MotionPhase::Flight => self.q.len(),
            _ => self.r.len(),
        };
        let given = [&coordinates.q, &coordinates.v, &coordinates.z].map(Vec::len);
        let needed = [modes, modes, self.z.len()];
        if given != needed {
            return Err(SimError::Options {
                what: "state to begin with",
                reason: format!(
                    "it has {given:?} coordinates, velocities and states of effects, the device {needed:?}; take a state of the same device"
                ),
            });
        }
        self.phase = match state.phase {
            MotionPhase::Flight => Phase::Flight,
            MotionPhase::Held { since, level } => Phase::Held { since, level },
            MotionPhase::Stuck { level } => Phase::Stuck { level },
        };
        let (q, v) = match state.phase {
            MotionPhase::Flight => (&mut self.q, &mut self.v),
            _ => (&mut self.r, &mut self.dr),
        };
        q.copy_from_slice(&coordinates.q);
        v.copy_from_slice(&coordinates.v);
        self.z.copy_from_slice(&coordinates.z);
        self.touch = state.sunk.map(|(level, since)| Touch { level, since });
        self.sliding = state.sliding;
        // An edge at that very instant is still to come: memories are brought up to date there.
        let before = state.time - END_ROUNDINGS * f64::EPSILON * state.time.abs();
        self.begin_at(state.time, before);
        Ok(())
    }

    /// Begins anew at `time` \[s\] under `drive`: at displacement \[m\] and velocity [m/s] `initial`,
    /// the model's if `None`, effects as after a long rest there without a voltage.
    ///
    /// # Errors
    /// [`SimError::Drive`]; nothing has changed then.
    pub fn begin_with(
        &mut self,
        drive: &Waveform,
        time: f64,
        initial: Option<(f64, f64)>,
    ) -> Result<(), SimError> {
        drive.check()?;
        self.drive = drive.clone();
        let initial = initial.unwrap_or(self.device.initial);
        (self.q, self.v) = super::state_at(&self.device, initial);
        let still = vec![0.0; self.v.len()];
        let rest = self.device.flight_kinematics(time, 0.0, &self.q, &still);
        self.z = self.device.settled_states(&rest);
        self.phase = Phase::Flight;
        self.touch = None;
        self.begin_at(time, time);
        self.set_out();
        Ok(())
    }

    /// Another model in place of this one, at its initial state at t = 0. What does not depend on
    /// the change is not computed again.
    ///
    /// # Errors
    /// [`SimError`]; nothing has changed then.
    pub fn replace_model(&mut self, model: &Model) -> Result<(), SimError> {
        let mut next = Self::new(model, &self.drive, &self.options)?;
        next.samples.end = self.samples.end;
        next.watch = self.watch.take();
        next.flight_tables.adopt(&mut self.flight_tables);
        next.held_tables.adopt(&mut self.held_tables);
        *self = next;
        Ok(())
    }

    /// Clock, drive and budgets for a run that begins at `time` \[s\], in the segment of the drive at
    /// `before`.
    fn begin_at(&mut self, time: f64, before: f64) {
        self.t = time;
        self.index = self.drive.index_at(before);
        self.whole = self.drive.segment(self.index);
        self.segment = self.device.piece(self.whole, time, &self.z);
        self.samples = SampleRange {
            next: (time * self.options.rate).ceil().max(0.0) as u64,
            end: self.samples.end,
        };
        self.level = 0;
        self.flight.forget();
        self.held.forget();
        (self.steps, self.events) = (0, 0);
        self.pace = Pace::of(&self.device, &self.options, time);
    }

    /// Advances to `end` \[s\] and stops there, before what an edge of the drive at that very
    /// instant brings. Events and samples are appended to `trace`.
    ///
    /// # Errors
    /// [`SimError`]; `trace` holds the results up to then.
    pub fn advance_to(&mut self, end: f64, trace: &mut Trace) -> Result<(), SimError> {
        let reached = end - END_ROUNDINGS * f64::EPSILON * end.abs();
        self.stop = end;
        let mut result = Ok(());
        while self.t < reached && result.is_ok() {
            result = self.advance_by_step(trace);
        }
        self.stop = f64::INFINITY;
        if result.is_ok() {
            self.t = end;
        }
        result
    }

    /// End of the piece of the drive in progress, or the instant at which the run stops \[s\].
    pub(super) fn piece_end(&self) -> f64 {
        self.segment.end.min(self.stop)
    }

    /// Checks that what acts on the device, but for the drive, repeats after `period` \[s\] from
    /// `from` on.
    ///
    /// # Errors
    /// What depends on time otherwise.
    pub fn check_repeats(&self, from: f64, period: f64) -> Result<(), &'static str> {
        let (mut largest, mut change) = (0.0f64, 0.0f64);
        for i in 0..INSTANTS_COMPARED {
            let t = from + period * i as f64 / INSTANTS_COMPARED as f64;
            let [now, later] = [t, t + period].map(|t| self.device.base_acceleration(t));
            largest = largest.max(now.abs()).max(later.abs());
            change = change.max((later - now).abs());
        }
        if change > REPEATED_SHARE * largest {
            return Err("the vibration of the base");
        }
        Ok(())
    }

    /// When the ground jumps for the last time \[s\].
    pub fn last_ground_jump(&self) -> Option<f64> {
        let mut last = None;
        let mut from = f64::NEG_INFINITY;
        while let Some(jump) = self.device.ground_jump(from, f64::INFINITY) {
            (last, from) = (Some(jump), jump);
        }
        last
    }

    /// Squared angular frequencies of the modes in flight, or with the mass held \[1/s^2\].
    pub fn mode_omega2(&self, held: bool) -> impl Iterator<Item = f64> + '_ {
        let modes = if held {
            &self.device.held_modes
        } else {
            &self.device.flight
        };
        modes.iter().map(|o| o.omega2)
    }

    /// Decay rates of the effects' extra states \[1/s\]; 0 for a memory.
    pub fn state_rates(&self) -> &[f64] {
        &self.device.rates
    }

    /// Displacement \[m\] and velocity [m/s] of the proof mass in a state of this device.
    pub fn mass_in(&self, state: &MotionState) -> (f64, f64) {
        match state.phase {
            MotionPhase::Flight => (
                crate::sim::device::dot(&self.device.phi_p, &state.coordinates.q),
                crate::sim::device::dot(&self.device.phi_p, &state.coordinates.v),
            ),
            MotionPhase::Held { level, .. } | MotionPhase::Stuck { level } => (level, 0.0),
        }
    }

    /// Level of the ground at `t` \[m\]; minus infinity without one.
    pub fn ground_level(&self, t: f64) -> f64 {
        self.device.ground_level(t)
    }

    /// Whether the mass sinks into the ground.
    pub fn has_compliant_ground(&self) -> bool {
        self.device.is_compliant()
    }

    /// Mass that an impulse on the proof mass moves \[kg\].
    pub fn impact_mass(&self) -> f64 {
        1.0 / self.device.mobility
    }

    /// Pull-off force above which the mass leaves the ground after `contact_time` \[s\] of
    /// contact \[N\].
    pub fn release_threshold(&self, contact_time: f64) -> f64 {
        let level = self.device.ground.map_or(0.0, |g| g.level);
        self.threshold(contact_time, level)
    }
}
