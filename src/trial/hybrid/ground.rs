//! What ends a phase, and what follows: touch, bounce, hold, release, and dry friction.

use super::integrator::{MAX_STATE, State};
use super::{Event, Kind, Traveller};
use crate::trial::device::{Ground, Phase};
use crate::trial::voltage::Piece;

/// Time over which rates are taken as differences \[s\].
const RATE_INTERVAL: f64 = 1e-9;

impl Traveller<'_> {
    /// Into the air: chooses the direction of dry friction, or jams.
    pub(crate) fn fly(&mut self, piece: &Piece) {
        self.phase = Phase::Flight { direction: 0.0 };
        if self.device.friction == 0.0 {
            return;
        }
        let velocity = self.device.points(&self.y)[1];
        if velocity.abs() > 1e-9 {
            self.phase = Phase::Flight {
                direction: velocity.signum(),
            };
            return;
        }
        let (hold, _) = self.device.hold(self.t, &self.y, piece, self.phase);
        if hold.abs() <= self.device.friction {
            self.device.kick(&mut self.y, -velocity);
            self.phase = Phase::Jammed;
        } else {
            // It starts to move the way it is pulled.
            self.phase = Phase::Flight {
                direction: -hold.signum(),
            };
        }
    }

    /// Below zero once the phase ends.
    pub(crate) fn guard(&self, t: f64, y: &State, piece: &Piece) -> [f64; 2] {
        let device = self.device;
        match self.phase {
            Phase::Flight { direction } => {
                let [xp, vp, ..] = device.points(y);
                let turn = if device.friction > 0.0 && direction != 0.0 {
                    vp * direction
                } else {
                    1.0
                };
                [xp - device.level(t), turn]
            }
            Phase::Jammed => {
                let (hold, _) = device.hold(t, y, piece, self.phase);
                [device.friction - hold.abs(), 1.0]
            }
            Phase::Held { since } => {
                let (hold, _) = device.hold(t, y, piece, self.phase);
                // The ground pulls with `hold` below zero as the structure pulls up.
                [device.adhesion(t - since) + hold, 1.0]
            }
            Phase::Touching { since } => [device.bond(t, y, since), 1.0],
        }
    }

    /// What follows when guard number `which` fell below zero.
    pub(crate) fn switch(&mut self, which: usize, piece: &Piece, torn: bool) {
        let device = self.device;
        let [xp, vp, ..] = device.points(&self.y);
        let level = device.level(self.t);
        match self.phase {
            Phase::Flight { .. } if which == 0 => self.touch(piece, xp, vp, level),
            Phase::Flight { .. } => {
                device.kick(&mut self.y, -vp);
                self.fly(piece);
            }
            Phase::Jammed => self.fly(piece),
            Phase::Held { since } | Phase::Touching { since } => {
                let (hold, load) = device.hold(self.t, &self.y, piece, self.phase);
                self.run.events.push(Event {
                    time: self.t,
                    kind: Kind::Release,
                    before: vp,
                    after: vp,
                    level,
                    pull: -hold - load,
                    pull_rate: self.growth(piece),
                    contact: self.t - since,
                    torn,
                });
                self.close_stretch();
                self.fly(piece);
                if device.friction > 0.0 {
                    self.phase = Phase::Flight { direction: 1.0 };
                }
                self.stretch = (self.t, self.y, self.phase);
            }
        }
    }

    /// How fast the structure's pull on the held mass grows \[N/s\].
    fn growth(&self, piece: &Piece) -> f64 {
        let device = self.device;
        let mut rates = [0.0; MAX_STATE];
        device.flow(self.t, &self.y, piece, self.phase, &mut rates);
        let mut soon = self.y;
        for (y, rate) in soon.iter_mut().zip(rates) {
            *y += RATE_INTERVAL * rate;
        }
        let pull = |t: f64, y: &State| {
            let (hold, load) = device.hold(t, y, piece, self.phase);
            -hold - load
        };
        (pull(self.t + RATE_INTERVAL, &soon) - pull(self.t, &self.y)) / RATE_INTERVAL
    }

    /// The mass has met the ground.
    fn touch(&mut self, piece: &Piece, xp: f64, vp: f64, level: f64) {
        let device = self.device;
        let since = self.t;
        self.close_stretch();
        if device.ground != Ground::Rigid {
            self.phase = Phase::Touching { since };
            self.stretch = (self.t, self.y, self.phase);
            return;
        }
        device.shift(&mut self.y, level - xp);
        let down = vp.min(0.0);
        let after = -device.restitution(down) * down;
        device.kick(&mut self.y, after - vp);
        let held = Phase::Held { since };
        let (hold, load) = device.hold(self.t, &self.y, piece, held);
        let bounces = -hold > device.adhesion(0.0).max(0.0);
        let mut event = Event {
            time: self.t,
            kind: Kind::Impact,
            before: vp,
            after,
            level,
            pull: -hold - load,
            pull_rate: 0.0,
            contact: 0.0,
            torn: false,
        };
        if bounces {
            self.fly(piece);
            if device.friction > 0.0 {
                self.phase = Phase::Flight { direction: 1.0 };
            }
        } else {
            device.kick(&mut self.y, -after);
            self.phase = held;
            event.kind = Kind::Stick;
            event.after = 0.0;
        }
        self.run.events.push(event);
        self.stretch = (self.t, self.y, self.phase);
    }
}
