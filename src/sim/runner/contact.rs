//! Contact and friction: the events that end a phase, and the phase that follows.

use super::{Phase, Runner};
use crate::sim::crossing::first_below;
use crate::sim::error::SimError;
use crate::sim::nodes;
use crate::sim::output::Sink;
use crate::sim::step::Touch;
use crate::sim::trace::{EventKind, Trace};

/// Heights over the ground below this share of its level are rounding.
const LEVEL_SLACK: f64 = 1e-10;

/// An event that ends a step of flight early.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stop {
    /// The mass meets the ground.
    Hit,
    /// The mass leaves a compliant ground.
    Leave,
    /// The velocity of the mass becomes zero, where friction changes its sign.
    Turn,
}

impl Runner {
    /// Begins flight with friction. The mass slides in the direction of its velocity. At rest it
    /// slides in the direction of the force on it, or friction holds it.
    pub(super) fn set_out(&mut self) {
        if !self.device.has_friction() {
            self.sliding = 0.0;
            return;
        }
        let (x, v) = self.proof_mass();
        self.sliding = if v == 0.0 { 0.0 } else { v.signum() };
        if v == 0.0 {
            self.turn(x);
        }
    }

    /// The mass is at rest at `x` for an instant, in flight coordinates. Friction holds it, or it
    /// slides in the direction of the force.
    pub(super) fn turn(&mut self, x: f64) {
        self.place(x, 0.0);
        let pull = self.pull_if_held() + self.reaction(x, 0.0, self.t);
        if pull.abs() > self.device.friction(x) {
            self.sliding = pull.signum();
        } else {
            self.hold_at(x);
            self.sliding = 0.0;
            self.phase = Phase::Stuck { level: x };
        }
    }

    /// Force of a compliant ground on the mass at `x` with velocity `v`. It is 0 without contact.
    pub(super) fn reaction(&self, x: f64, v: f64, t: f64) -> f64 {
        self.touch.map_or(0.0, |touch| {
            self.device
                .contact_force(touch.level - x, -v, t - touch.since)
        })
    }

    /// Follows a ground that an effect has moved. A rising ground lifts the mass; a falling one
    /// leaves it in the air.
    pub(super) fn follow_ground(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        let level = self.device.ground_level(self.t);
        if let Phase::Held { since, level: old } = self.phase {
            if level > old {
                self.lift(old);
                self.place(level, 0.0);
                self.land(since, level);
            } else if level < old {
                let pull = self.pull_at_rest(old);
                self.release(since, old, pull, trace)?;
            }
            return Ok(());
        }
        let height = match (self.touch, self.phase) {
            (Some(touch), _) if touch.level == level => return Ok(()),
            (_, Phase::Stuck { level: at }) if at >= level && self.touch.is_none() => {
                return Ok(());
            }
            (None, Phase::Flight) if self.proof_mass().0 >= level => return Ok(()),
            (touch, _) => touch.map(|touch| touch.level - level),
        };
        if let Phase::Stuck { level: at } = self.phase {
            self.lift(at);
            self.phase = Phase::Flight;
        }
        let (x, v) = self.proof_mass();
        match height {
            // In a compliant ground the mass keeps its depth while it is lifted.
            Some(fall) if fall < 0.0 => {
                self.place(x - fall, v);
                self.touch = self.touch.map(|touch| Touch { level, ..touch });
            }
            Some(_) => self.leave(trace)?,
            None => self.place(level, v.max(0.0)),
        }
        self.set_out();
        Ok(())
    }

    /// First event in a step of flight before the fraction `end`, and its fraction.
    pub(super) fn first_stop(&self, h: f64, end: f64) -> Option<(f64, Stop)> {
        let contact = match self.touch {
            Some(touch) => self.first_leave(touch, end).map(|s| (s, Stop::Leave)),
            None if self.device.ground.is_some() => self.first_hit(h, end).map(|s| (s, Stop::Hit)),
            None => None,
        };
        if !self.device.has_friction() {
            return contact;
        }
        let end = contact.map_or(end, |(s, _)| s);
        let shape = &self.device.phi_p;
        self.flight
            .first_stop(&self.flight.smooth(shape), shape, end)
            .map(|s| (s, Stop::Turn))
            .or(contact)
    }

    /// Fraction of the step at which the mass rises to the level of a compliant ground.
    pub(super) fn first_leave(&self, touch: Touch, end: f64) -> Option<f64> {
        let smooth = self.flight.smooth(&self.device.phi_p);
        let depth =
            |s: f64| touch.level - smooth.value(s) - self.flight.fast_at(&self.device.phi_p, s);
        first_below(depth, end, LEVEL_SLACK * touch.level.abs())
    }

    /// Fraction of the step at which the mass meets the ground.
    pub(super) fn first_hit(&self, h: f64, end: f64) -> Option<f64> {
        let step = &self.flight;
        let ground = self.device.ground_level(self.t);
        let lowest = step.xp.iter().fold(f64::INFINITY, |a, &x| a.min(x));
        let fastest = step.vp.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        // Points are at most 0.33 h apart: two radians of the fastest mode. Its largest velocity is
        // more than half as large at one of them. An effect may move the ground: no shortcut then.
        let far = lowest - ground > 0.35 * h * fastest;
        if far && !self.device.has_effects() {
            return None;
        }
        let smooth = step.smooth(&self.device.phi_p);
        let slack = LEVEL_SLACK * ground.abs();
        let gap = |s: f64| {
            let x = smooth.value(s) + step.fast_at(&self.device.phi_p, s);
            x - self.device.ground_level(self.t + s * h)
        };
        first_below(gap, end, slack)
    }

    /// Begins contact with a compliant ground.
    pub(super) fn enter(&mut self, v: f64, trace: &mut Trace) -> Result<(), SimError> {
        let level = self.device.ground_level(self.t);
        let since = self.t;
        self.touch = Some(Touch { level, since });
        Sink::open_contact(trace, since, since);
        let pull = self.pull_if_held();
        self.note_arrival(v, f64::INFINITY);
        self.report(trace, EventKind::Stick, [v; 2], pull, 0.0)
    }

    /// Ends contact with a compliant ground.
    pub(super) fn leave(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        let Some(touch) = self.touch.take() else {
            return Ok(());
        };
        Sink::open_contact(trace, touch.since, self.t);
        let (_, v) = self.proof_mass();
        let pull = self.pull_if_held();
        let duration = self.t - touch.since;
        self.report(trace, EventKind::Release, [v; 2], pull, duration)
    }

    pub(super) fn impact(&mut self, v: f64, trace: &mut Trace) -> Result<(), SimError> {
        let level = self.device.ground_level(self.t);
        let before = v.min(0.0);
        let after = -self.device.restitution(-before) * before;
        self.place(level, after);
        let pull = self.pull_if_held();
        let threshold = self.threshold(0.0, level);
        self.note_arrival(before, self.device.bounce_share(after, pull, threshold));
        let resolved = self.options.tolerance.max(LEVEL_SLACK * level.abs());
        let rebounds = self.device.rebounds((-before, after), -pull, resolved);
        if rebounds || pull > threshold {
            self.sliding = 1.0;
            return self.report(trace, EventKind::Impact, [before, after], pull, 0.0);
        }
        self.place(level, 0.0);
        self.land(self.t, level);
        Sink::open_contact(trace, self.t, self.t);
        self.report(trace, EventKind::Stick, [before, 0.0], pull, 0.0)
    }

    /// Begins a hold by friction, away from a rigid ground.
    pub(super) fn rest(&mut self, level: f64, trace: &mut Trace) -> Result<(), SimError> {
        let net = self.pull_at_rest(level) + self.reaction(level, 0.0, self.t);
        let friction = self.device.friction(level);
        if net.abs() > friction {
            self.slide(level, net);
            return Ok(());
        }
        let h = self.step(trace)?;
        let end = ((self.piece_end() - self.t) / h).min(1.0);
        let net = |s: f64| self.held_pull(s, level) + self.reaction(level, 0.0, self.t + s * h);
        let freed = first_below(|s| friction - net(s).abs(), end, 0.0).map(|s| (s, net(s)));
        let s = freed.map_or(end, |(s, _)| s);
        self.emit_held(h, s, None, level, trace);
        self.note_held(h, s, None, level, freed.is_some());
        self.take_held(h, s, freed.is_none());
        if let Some(touch) = self.touch {
            Sink::open_contact(trace, touch.since, self.t);
        }
        if let Some((_, net)) = freed {
            self.slide(level, net);
        }
        Ok(())
    }

    /// Ends a hold by friction: the force `net` exceeds it.
    pub(super) fn slide(&mut self, level: f64, net: f64) {
        self.lift(level);
        self.sliding = net.signum();
        self.phase = Phase::Flight;
    }

    /// Eq (13) in flight coordinates.
    pub(super) fn pull_if_held(&self) -> f64 {
        let voltage = self.segment.shape.voltage(self.t);
        let mut at = self
            .device
            .flight_kinematics(self.t, voltage, &self.q, &self.v);
        let branch = self.segment.branch;
        let drive = self.device.drive_force(&mut at, branch, &self.z);
        (at.vp, at.film) = (0.0, 0.0);
        let on_mass = self.device.force_on_held(&at, &self.z);
        self.device.pull_flight(&self.q, &self.v, drive, on_mass)
    }

    /// Present pull-off force of the mass held at `level`.
    pub(super) fn pull_at_rest(&self, level: f64) -> f64 {
        let voltage = self.segment.shape.voltage(self.t);
        let device = &self.device;
        let mut at = device.held_kinematics(self.t, voltage, level, &self.r, &self.dr);
        let drive = device.drive_force(&mut at, self.segment.branch, &self.z);
        let on_mass = device.force_on_held(&at, &self.z);
        device.pull_held(&self.r, &self.dr, level, drive, on_mass)
    }

    /// Pull-off force that releases the mass from a ground at `level` \[m\] after `contact_time`
    /// \[s\]: adhesion plus friction.
    pub(super) fn threshold(&self, contact_time: f64, level: f64) -> f64 {
        self.device.adhesion(contact_time).max(0.0) + self.device.friction(level)
    }

    /// Fraction of the held step at which the pull-off force exceeds adhesion, and the force.
    pub(super) fn first_release(
        &self,
        h: f64,
        end: f64,
        since: f64,
        level: f64,
    ) -> Option<(f64, f64)> {
        let step = &self.held;
        let margin: [f64; nodes::S] = std::array::from_fn(|k| {
            let t = self.t + nodes::NODES[k] * h;
            self.threshold(t - since, level) - step.force[k]
        });
        let lowest = margin.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let highest = margin.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        if lowest > 0.75 * (highest - lowest) {
            return None;
        }
        let pull = |s: f64| self.held_pull(s, level);
        first_below(
            |s| self.threshold(self.t + s * h - since, level) - pull(s),
            end,
            0.0,
        )
        .map(|s| (s, pull(s)))
    }

    /// Pull-off force at fraction `s` of the held step.
    pub(super) fn held_pull(&self, s: f64, level: f64) -> f64 {
        self.held
            .held_pull(&self.device, &self.segment, self.t, s, level)
    }

    pub(super) fn hold(
        &mut self,
        since: f64,
        level: f64,
        trace: &mut Trace,
    ) -> Result<(), SimError> {
        let pull = self.pull_at_rest(level);
        if pull > self.threshold(self.t - since, level) {
            return self.release(since, level, pull, trace);
        }
        let h = self.step(trace)?;
        let end = ((self.piece_end() - self.t) / h).min(1.0);
        let freed = self.first_release(h, end, since, level);
        let s = freed.map_or(end, |(s, _)| s);
        self.emit_held(h, s, Some(since), level, trace);
        self.note_held(h, s, Some(since), level, freed.is_some());
        self.take_held(h, s, freed.is_none());
        Sink::open_contact(trace, since, self.t);
        match freed {
            Some((_, pull)) => self.release(since, level, pull, trace),
            None => Ok(()),
        }
    }

    pub(super) fn release(
        &mut self,
        since: f64,
        level: f64,
        pull: f64,
        trace: &mut Trace,
    ) -> Result<(), SimError> {
        self.slide(level, 1.0);
        Sink::open_contact(trace, since, self.t);
        self.report(trace, EventKind::Release, [0.0; 2], pull, self.t - since)
    }
}
