//! Impulses on the mass, and the change between flight coordinates and coordinates of the held
//! structure.

use super::{Phase, Runner};
use crate::sim::device::dot;

impl Runner {
    pub(super) fn proof_mass(&self) -> (f64, f64) {
        (
            dot(&self.device.phi_p, &self.q),
            dot(&self.device.phi_p, &self.v),
        )
    }

    /// Moves the proof mass to `x` with velocity `v` by an impulse on it alone.
    pub(super) fn place(&mut self, x: f64, v: f64) {
        let (x0, v0) = self.proof_mass();
        for i in 0..self.q.len() {
            let anchor = self.device.held.anchor[i];
            self.q[i] += anchor * (x - x0);
            self.v[i] += anchor * (v - v0);
        }
    }

    /// From flight coordinates to held ones on the ground.
    pub(super) fn land(&mut self, since: f64, level: f64) {
        self.hold_at(level);
        self.sliding = 0.0;
        self.phase = Phase::Held { since, level };
    }

    /// From flight coordinates to held ones.
    pub(super) fn hold_at(&mut self, level: f64) {
        let held = &self.device.held;
        let m = self.r.len();
        for k in 0..m {
            self.r[k] = 0.0;
            self.dr[k] = 0.0;
            for i in 0..self.q.len() {
                let z = held.basis[i * m + k];
                self.r[k] += z * (self.q[i] - level * held.anchor[i]);
                self.dr[k] += z * self.v[i];
            }
        }
    }

    /// From held coordinates to flight ones. The caller sets the phase.
    pub(super) fn lift(&mut self, level: f64) {
        let held = &self.device.held;
        let m = self.r.len();
        for i in 0..self.q.len() {
            let row = &held.basis[i * m..(i + 1) * m];
            self.q[i] = level * held.anchor[i] + dot(row, &self.r);
            self.v[i] = dot(row, &self.dr);
        }
    }

    /// Kinetic and elastic energy of the structure now \[J\]: `sum q'^2 / 2` and
    /// `sum w^2 q^2 / 2` over the modes.
    pub fn mechanical_energy(&self) -> (f64, f64) {
        let held = &self.device.held;
        let (level, m) = match self.phase {
            Phase::Flight => (None, 0),
            Phase::Held { level, .. } | Phase::Stuck { level } => (Some(level), self.r.len()),
        };
        let (mut kinetic, mut elastic) = (0.0, 0.0);
        for (i, mode) in self.device.flight.iter().enumerate() {
            let (q, v) = match level {
                None => (self.q[i], self.v[i]),
                Some(level) => {
                    let row = &held.basis[i * m..(i + 1) * m];
                    let q = level * held.anchor[i] + dot(row, &self.r);
                    (q, dot(row, &self.dr))
                }
            };
            kinetic += 0.5 * v * v;
            elastic += 0.5 * mode.omega2 * q * q;
        }
        (kinetic, elastic)
    }
}
