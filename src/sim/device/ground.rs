//! The ground as effects alter it: its level, its law of contact, adhesion, restitution.

use super::Device;
use crate::model::ground::{BounceRule, StickSpeed};

impl Device {
    /// Whether the mass sinks into the ground.
    pub fn is_compliant(&self) -> bool {
        self.compliant.is_some()
    }

    /// Force on the mass from a compliant ground \[N\]: its reaction at a depth \[m\] and rate
    /// [m/s], less the adhesion after `contact_time` \[s\].
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

    /// Level of the ground at `t` \[m\].
    #[inline]
    pub fn ground_level(&self, t: f64) -> f64 {
        let level = self.ground.map_or(f64::NEG_INFINITY, |g| g.level);
        self.effects
            .iter()
            .fold(level, |level, e| e.action.ground_level(level, t))
    }

    /// When the ground jumps for the first time after `from`, before `to` \[s\].
    pub fn ground_jump(&self, from: f64, to: f64) -> Option<f64> {
        let jumps = self.effects.iter().filter_map(|e| e.action.ground_jump());
        jumps.filter(|&t| from < t && t < to).min_by(f64::total_cmp)
    }

    /// Adhesion after `contact_time` \[N\].
    #[inline]
    pub fn adhesion(&self, contact_time: f64) -> f64 {
        let adhesion = self.ground.map_or(0.0, |g| g.adhesion(contact_time));
        let at_touch = self.ground.map_or(0.0, |g| g.adhesion_start);
        self.effects.iter().fold(adhesion, |adhesion, e| {
            e.action.adhesion(adhesion, at_touch, contact_time)
        })
    }

    /// Whether a mass that arrives with `speed` [m/s] and would leave with `after` [m/s], pressed
    /// onto the ground with a force of `press` \[N\], rebounds although the structure does not pull
    /// it off. `resolved` \[m\] is the lowest hop that a run follows.
    ///
    /// A pressed mass that loses a share of its speed at each bounce makes infinitely many in a
    /// finite time. The last of them, lower than `resolved`, are left out: the mass is at rest
    /// earlier by the time that they would take, `2 v / (a (1 - alpha))` of a speed `v` that
    /// rises by no more than `resolved`.
    pub fn rebounds(&self, (speed, after): (f64, f64), press: f64, resolved: f64) -> bool {
        let BounceRule::Restitution(stick) = self.bounce else {
            return false;
        };
        let fast = match stick {
            StickSpeed::Given(limit) => speed > limit,
            StickSpeed::AdhesionOver(reach) => {
                let energy = self.adhesion(0.0).max(0.0) * reach;
                after * after > 2.0 * energy * self.mobility
            }
        };
        let rise = if press > 0.0 {
            0.5 * after * after / (press * self.mobility)
        } else {
            f64::INFINITY
        };
        fast && after > 0.0 && rise > resolved
    }

    /// How clearly a mass that would leave with `after` [m/s] bounces or sticks, from 0: what decides
    /// apart from its limit, as a share of both together. `pull` is the pull-off force \[N\] right
    /// after, `threshold` the one that frees the mass. Infinite where nothing is to be decided.
    pub fn bounce_share(&self, after: f64, pull: f64, threshold: f64) -> f64 {
        let share = |value: f64, limit: f64| {
            let both = value.abs() + limit.abs();
            if both > 0.0 {
                (value - limit).abs() / both
            } else {
                0.0
            }
        };
        let by_pull = share(pull, threshold);
        let by_speed = match self.bounce {
            BounceRule::PullOff => return by_pull,
            BounceRule::Restitution(StickSpeed::Given(limit)) => {
                share(after, self.restitution(limit) * limit)
            }
            BounceRule::Restitution(StickSpeed::AdhesionOver(reach)) => {
                let energy = self.adhesion(0.0).max(0.0) * reach;
                share(after, (2.0 * energy * self.mobility).sqrt())
            }
        };
        // Either rule alone makes it bounce.
        if pull > threshold {
            by_pull.max(by_speed)
        } else {
            by_speed
        }
    }

    /// Coefficient of restitution at approach speed `speed` [m/s].
    pub fn restitution(&self, speed: f64) -> f64 {
        let alpha = self.ground.map_or(0.0, |g| g.alpha);
        self.effects
            .iter()
            .fold(alpha, |alpha, e| e.action.restitution(alpha, speed))
    }
}
