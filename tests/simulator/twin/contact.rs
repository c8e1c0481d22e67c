//! What ends a phase, and what follows: impact, hold, release, friction, a ground that
//! steps.

use super::{Machine, Phase, Run, State};

const ALPHA: f64 = 0.378;

impl Machine<'_> {
    pub(super) fn set_velocity(&self, s: &mut State, to: f64) {
        let [kc, kp, kq] = self.kick();
        let phi = self.e().mode[3];
        let impulse = (to - s[3] - phi * s[5]) / (kp + phi * kq);
        s[2] += kc * impulse;
        s[3] += kp * impulse;
        s[5] += kq * impulse;
    }

    fn shift(&self, s: &mut State, to: f64) {
        let [kc, kp, kq] = self.kick();
        let phi = self.e().mode[3];
        let way = (to - s[1] - phi * s[4]) / (kp + phi * kq);
        s[0] += kc * way;
        s[1] += kp * way;
        s[4] += kq * way;
    }

    /// Not negative while the phase lasts.
    pub(super) fn guard(&self, t: f64, s: &State) -> f64 {
        let (xp, vp, _, _) = self.points(s);
        let fc = self.friction(xp);
        match self.phase {
            Phase::Held(since) => {
                let pull = -self.rates(t, s).1;
                self.adhesion(t - since) + fc - pull
            }
            Phase::Stuck => fc - self.rates(t, s).1.abs(),
            Phase::Flight => {
                let gap = match (self.twin.has_ground, self.touch) {
                    (false, _) => f64::INFINITY,
                    (true, None) => xp - self.level(t),
                    (true, Some(_)) => self.level(t) - xp,
                };
                // Both as shares of what is small.
                if self.rubs() {
                    (gap / 1e-6).min(self.sliding * vp / 1e-3)
                } else {
                    gap / 1e-6
                }
            }
        }
    }

    pub(super) fn event(&mut self, t: f64, s: &mut State, run: &mut Run) {
        let (xp, vp, _, _) = self.points(s);
        let level = self.level(t);
        let fc = self.friction(xp);
        match self.phase {
            Phase::Held(since) => {
                run.contacts.push((since, t));
                self.phase = Phase::Flight;
                self.sliding = 1.0;
            }
            Phase::Stuck => {
                // Slides against the force that held it.
                self.sliding = -self.rates(t, s).1.signum();
                self.phase = Phase::Flight;
            }
            Phase::Flight if self.rubs() && self.sliding * vp < 1e-9 => {
                self.set_velocity(s, 0.0);
                self.halt(t, s);
            }
            Phase::Flight if self.touch.is_some() => {
                run.contacts.push((self.touch.take().unwrap(), t));
            }
            Phase::Flight if self.e().ground.0 > 0.0 => self.touch = Some(t),
            Phase::Flight => {
                let _ = xp;
                self.shift(s, level);
                let (n, v0) = self.e().restitution;
                let alpha = if n == 0.0 {
                    ALPHA
                } else {
                    (ALPHA * (-vp / v0).powf(-n)).min(1.0)
                };
                self.set_velocity(s, -alpha * vp);
                let pull = self.pull(t, s);
                if pull > self.adhesion(0.0) + fc {
                    self.sliding = 1.0;
                } else {
                    self.set_velocity(s, 0.0);
                    self.phase = Phase::Held(t);
                    self.sliding = 0.0;
                }
            }
        }
    }

    /// The force that must be exerted downward to keep the mass from accelerating, with no
    /// friction in it, as if its velocity were zero but the modes moved as they do.
    fn pull(&mut self, t: f64, s: &State) -> f64 {
        let (phase, sliding) = (self.phase, self.sliding);
        (self.phase, self.sliding) = (Phase::Stuck, 0.0);
        let pull = -self.rates(t, s).1;
        (self.phase, self.sliding) = (phase, sliding);
        pull
    }

    /// At rest with friction: held, or off in the direction of the force.
    pub(super) fn halt(&mut self, t: f64, s: &State) {
        let pull = self.pull(t, s);
        let (xp, ..) = self.points(s);
        if pull.abs() > self.friction(xp) {
            self.sliding = pull.signum();
            self.phase = Phase::Flight;
        } else {
            self.sliding = 0.0;
            self.phase = Phase::Stuck;
        }
    }

    /// The ground has stepped.
    pub(super) fn follow(&mut self, t: f64, s: &mut State, run: &mut Run) {
        let level = self.level(t);
        let (xp, vp, _, _) = self.points(s);
        match self.phase {
            Phase::Held(since) if level < xp => {
                run.contacts.push((since, t));
                self.phase = Phase::Flight;
            }
            Phase::Held(_) => self.shift(s, level),
            _ if xp < level => {
                self.shift(s, level);
                self.set_velocity(s, vp.max(0.0));
            }
            _ => {}
        }
    }
}
