//! States at the strobe as points of a space without units, and their distance.

use crate::sim::{MotionPhase, MotionState, Runner};

/// A memory that holds an instant advances by the periods passed, to this share of them.
const CLOCK_SHARE: f64 = 1e-6;

/// What makes states of one response comparable.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    /// Angular frequency that weighs each coordinate in flight [1/s]: its own, at least that of the
    /// drive.
    flight: Vec<f64>,
    /// The same with the mass held.
    held: Vec<f64>,
    /// The drive's period \[s\].
    period: f64,
    /// Square root of the largest energy of the response, in modal velocities.
    speed: f64,
    /// Largest displacement of the mass from another \[m\], for levels at which friction holds it.
    length: f64,
    /// Largest size of each extra state.
    states: Vec<f64>,
    /// Which of them decay; others are memories.
    decays: Vec<bool>,
}

impl Scale {
    /// Of a device under a drive of `period` \[s\], before any motion is known.
    pub fn new(runner: &Runner, period: f64) -> Self {
        let slowest = std::f64::consts::TAU / period;
        let weights = |held| {
            let all = runner.mode_omega2(held);
            all.map(|omega2| omega2.sqrt().max(slowest)).collect()
        };
        Self {
            flight: weights(false),
            held: weights(true),
            period,
            speed: 0.0,
            length: 0.0,
            states: vec![0.0; runner.state_rates().len()],
            decays: runner.state_rates().iter().map(|r| *r > 0.0).collect(),
        }
    }

    fn weights(&self, phase: MotionPhase) -> &[f64] {
        match phase {
            MotionPhase::Flight => &self.flight,
            MotionPhase::Held { .. } | MotionPhase::Stuck { .. } => &self.held,
        }
    }

    /// Begins anew with the states and speeds that follow.
    pub fn forget(&mut self) {
        (self.speed, self.length) = (0.0, 0.0);
        self.states.fill(0.0);
    }

    /// Widens the scale to a state of the response.
    pub fn include(&mut self, state: &MotionState) {
        let own = &state.coordinates;
        let squares = self.weights(state.phase).iter().zip(&own.q).zip(&own.v);
        let energy: f64 = squares.map(|((w, q), v)| v * v + w * w * q * q).sum();
        self.speed = self.speed.max(energy.sqrt());
        for (size, z) in self.states.iter_mut().zip(&own.z) {
            *size = size.max(z.abs());
        }
    }

    /// Widens it to a speed of the mass [m/s] that moves `mass` \[kg\], and a span of its
    /// displacement \[m\].
    pub fn include_motion(&mut self, speed: f64, mass: f64, span: f64) {
        self.speed = self.speed.max(speed * mass.sqrt());
        self.length = self.length.max(span);
    }

    /// Distance of `later` from `earlier`, a number of periods before, as a share of the response's
    /// amplitude; infinite if the mass moves in another way.
    pub fn distance(&self, earlier: &MotionState, later: &MotionState) -> f64 {
        let ratio = |part: f64, whole: f64| if part == 0.0 { 0.0 } else { part / whole };
        let passed = later.time - earlier.time;
        let mut worst = match (earlier.phase, later.phase) {
            (MotionPhase::Flight, MotionPhase::Flight) => match (earlier.sunk, later.sunk) {
                (None, None) => 0.0,
                (Some(a), Some(b)) => self.age_change(a.1, b.1, passed),
                _ => return f64::INFINITY,
            },
            (MotionPhase::Held { since: a, .. }, MotionPhase::Held { since: b, .. }) => {
                self.age_change(a, b, passed)
            }
            (MotionPhase::Stuck { level: a }, MotionPhase::Stuck { level: b }) => {
                ratio((b - a).abs(), self.length)
            }
            _ => return f64::INFINITY,
        };
        if earlier.sliding != later.sliding {
            return f64::INFINITY;
        }
        let (a, b) = (&earlier.coordinates, &later.coordinates);
        let mut squares = 0.0;
        for (i, w) in self.weights(later.phase).iter().enumerate() {
            let (dq, dv) = (b.q[i] - a.q[i], b.v[i] - a.v[i]);
            squares += dv * dv + w * w * dq * dq;
        }
        worst = f64::max(worst, ratio(squares.sqrt(), self.speed));
        for (i, size) in self.states.iter().enumerate() {
            let change = b.z[i] - a.z[i];
            let is_clock = !self.decays[i] && (change - passed).abs() < CLOCK_SHARE * self.period;
            if !is_clock {
                worst = worst.max(ratio(change.abs(), *size));
            }
        }
        worst
    }

    /// Change of the age of a contact, over the period; none for one and the same contact, which
    /// goes on.
    fn age_change(&self, since: f64, later: f64, passed: f64) -> f64 {
        if since == later {
            0.0
        } else {
            (later - since - passed).abs() / self.period
        }
    }

    /// The coordinates that the map can be differentiated by: `None` where it cannot. The age of a
    /// contact is one if the contact ends within the cycle (`ends`).
    pub fn pack(&self, state: &MotionState, ends: bool) -> Option<Vec<f64>> {
        if state.sunk.is_some() || self.speed == 0.0 {
            return None;
        }
        let own = &state.coordinates;
        let weights = self.weights(state.phase);
        let mut packed: Vec<f64> = weights
            .iter()
            .zip(&own.q)
            .map(|(w, q)| w * q / self.speed)
            .collect();
        packed.extend(own.v.iter().map(|v| v / self.speed));
        for (i, z) in own.z.iter().enumerate() {
            if self.decays[i] && self.states[i] > 0.0 {
                packed.push(z / self.states[i]);
            }
        }
        match state.phase {
            MotionPhase::Flight => {}
            MotionPhase::Held { since, .. } if ends => {
                packed.push((state.time - since) / self.period);
            }
            MotionPhase::Held { .. } => {}
            // The level is a coordinate that friction alone decides.
            MotionPhase::Stuck { .. } => return None,
        }
        Some(packed)
    }

    /// The state of those coordinates; what they do not hold is as in `like`.
    pub fn unpack(&self, packed: &[f64], like: &MotionState) -> MotionState {
        let mut state = like.clone();
        let mut values = packed.iter();
        let weights = self.weights(like.phase);
        for (q, (w, x)) in state
            .coordinates
            .q
            .iter_mut()
            .zip(weights.iter().zip(&mut values))
        {
            *q = x * self.speed / w;
        }
        for v in &mut state.coordinates.v {
            *v = values.next().map_or(*v, |x| x * self.speed);
        }
        for (i, z) in state.coordinates.z.iter_mut().enumerate() {
            if self.decays[i] && self.states[i] > 0.0 {
                *z = values.next().map_or(*z, |x| x * self.states[i]);
            }
        }
        if let MotionPhase::Held { since, .. } = &mut state.phase
            && let Some(age) = values.next()
        {
            *since = like.time - age * self.period;
        }
        state
    }
}
