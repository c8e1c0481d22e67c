//! Conversions of states: displacements of the points, the change between flight and held
//! coordinates, impulses, and the pull-off force.

use super::{Points, StretchSimulator, StretchState, segment_at};
use crate::model::MAX_MODES;
use crate::model::drive::Segment;
use crate::sim::device::dot;

impl StretchSimulator {
    /// Displacements and velocities in flight.
    pub fn flight_points(&self, state: &StretchState) -> Points {
        let d = &self.device;
        Points {
            xp: dot(&d.phi_p, &state.q),
            vp: dot(&d.phi_p, &state.v),
            xc: dot(&d.phi_c, &state.q),
            vc: dot(&d.phi_c, &state.v),
        }
    }

    /// Displacements and velocities with the mass held at `level` \[m\].
    pub fn held_points(&self, level: f64, state: &StretchState) -> Points {
        let d = &self.device;
        Points {
            xp: level,
            vp: 0.0,
            xc: level * d.anchor_c + dot(&d.held.cantilever, &state.q),
            vc: dot(&d.held.cantilever, &state.v),
        }
    }

    /// Brings the proof mass to displacement `x` and velocity `v` by an impulse on it
    /// alone.
    pub fn kick(&self, x: f64, v: f64, state: &mut StretchState) {
        let now = self.flight_points(state);
        for (i, anchor) in self.device.held.anchor.iter().enumerate() {
            state.q[i] += anchor * (x - now.xp);
            state.v[i] += anchor * (v - now.vp);
        }
    }

    /// From flight to held at `level` \[m\]: what motion of the mass is left is taken out.
    pub fn land(&self, level: f64, state: &mut StretchState) {
        let held = &self.device.held;
        let (n, m) = (self.modes(), self.device.held_modes.len());
        let (mut r, mut dr) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        for k in 0..m {
            for i in 0..n {
                let z = held.basis[i * m + k];
                r[k] += z * (state.q[i] - level * held.anchor[i]);
                dr[k] += z * state.v[i];
            }
        }
        state.q.clear();
        state.v.clear();
        state.q.extend_from_slice(&r[..m]);
        state.v.extend_from_slice(&dr[..m]);
    }

    /// From held at `level` \[m\] to flight.
    pub fn lift(&self, level: f64, state: &mut StretchState) {
        let held = &self.device.held;
        let (n, m) = (self.modes(), self.device.held_modes.len());
        let (mut q, mut v) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        for i in 0..n {
            let row = &held.basis[i * m..(i + 1) * m];
            q[i] = level * held.anchor[i] + dot(row, &state.q);
            v[i] = dot(row, &state.v);
        }
        state.q.clear();
        state.v.clear();
        state.q.extend_from_slice(&q[..n]);
        state.v.extend_from_slice(&v[..n]);
    }

    /// Pull-off force, eq (13), of the mass held at `level` \[m\] at time `t` \[N\].
    pub fn pull_off(&self, drive: &[Segment], t: f64, level: f64, state: &StretchState) -> f64 {
        let d = &self.device;
        let segment = segment_at(drive, t);
        let voltage = segment.shape.voltage(t);
        let mut at = d.held_kinematics(t, voltage, level, &state.q, &state.v);
        let force = d.drive_force(&mut at, segment.branch, &state.z);
        let on_mass = d.force_on_held(&at, &state.z);
        d.pull_held(&state.q, &state.v, level, force, on_mass)
    }
}
