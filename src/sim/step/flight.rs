//! A step of flight: the film's force depends on the motion that it causes.

// The indices are those of the method's matrices; iterators would hide them.
#![allow(clippy::needless_range_loop)]

use super::elimination::eliminate;
use super::tables::{Table, Tables};
use super::{RESOLVED_FORCE_ERROR, Reject, Step, UNRESOLVED_FORCE_ERROR};
use crate::model::drive::Segment;
use crate::sim::device::{Device, dot};
use crate::sim::nodes::{S, top_coefficient};

impl Step {
    /// A step of flight from `(q, v, z)` at `t`.
    ///
    /// `tolerance` \[m\] bounds the iteration's remaining error; the discretisation's is
    /// left in `self.error` for the caller to judge.
    #[allow(clippy::too_many_arguments)]
    pub fn flight_step(
        &mut self,
        device: &Device,
        tables: &Tables,
        level: usize,
        segment: &Segment,
        t: f64,
        state: (&[f64], &[f64], &[f64]),
        tolerance: f64,
    ) -> Result<(), Reject> {
        let table = tables.get(level);
        let growth = self.start(device, table, state);
        let force_tolerance = tolerance / growth;
        match self.known_drive(device, table, segment, t, force_tolerance)? {
            Some(constant) => self.flight_plain(device, table, constant, force_tolerance)?,
            None => self.flight_with_effects(device, table, segment, t, force_tolerance)?,
        }
        self.settle(table);
        self.follow_readings(device, table, [&device.phi_p, &device.phi_c], [0.0; 2]);
        let top = dot(top_coefficient(), &self.force).abs();
        let drive_top = dot(top_coefficient(), &self.drive).abs();
        let mean = if device.outswings(table.h) {
            UNRESOLVED_FORCE_ERROR
        } else {
            RESOLVED_FORCE_ERROR
        };
        self.error = growth * (mean * top + RESOLVED_FORCE_ERROR * drive_top * device.drive_ratio);
        self.error += self.state_error(device, growth, mean) + self.base_error(device, growth);
        if self.error.is_finite() && self.xp.iter().all(|x| device.is_inside_film(*x)) {
            Ok(())
        } else {
            Err(Reject)
        }
    }

    /// Of a motion that only the film's force depends on, the drive being known; it may be
    /// `constant`.
    fn flight_plain(
        &mut self,
        device: &Device,
        table: &Table,
        constant: bool,
        force_tolerance: f64,
    ) -> Result<(), Reject> {
        let m = self.modes;
        self.xp[0] = dot(&device.phi_p, self.q_at(0));
        self.vp[0] = dot(&device.phi_p, self.v_at(0));
        // Motion of the proof mass without force on it.
        let (mut base_x, mut base_v) = ([0.0; S - 1], [0.0; S - 1]);
        for k in 0..S - 1 {
            for i in 0..m {
                let e = &table.modes[i].state[k];
                base_x[k] += device.phi_p[i] * (e[0] * self.q[i] + e[1] * self.v[i]);
                base_v[k] += device.phi_p[i] * (e[2] * self.q[i] + e[3] * self.v[i]);
            }
            let (wx, wv) = (&table.p_from_d[0][k], &table.p_from_d[1][k]);
            if constant {
                base_x[k] += self.drive[0] * wx.iter().sum::<f64>();
                base_v[k] += self.drive[0] * wv.iter().sum::<f64>();
            } else {
                base_x[k] += dot(wx, &self.drive);
                base_v[k] += dot(wv, &self.drive);
            }
        }
        // A mass with friction slides the same way all along. Friction that depends on the place is
        // an effect on the motion, and not for here.
        let friction = device.friction(self.xp[0]) * self.sliding;
        let on_mass = |xp: f64, vp: f64| device.film_force(xp, vp) - friction;
        self.force = [on_mass(self.xp[0], self.vp[0]); S];
        let mut previous = f64::INFINITY;
        let mut settled = false;
        for sweep in 0..24 {
            self.sweeps += 1;
            for k in 0..S - 1 {
                self.xp[k + 1] = base_x[k] + dot(&table.p_from_p[0][k], &self.force);
                self.vp[k + 1] = base_v[k] + dot(&table.p_from_p[1][k], &self.force);
            }
            let mut residual = [0.0; S - 1];
            let mut change = 0.0f64;
            for k in 0..S - 1 {
                if !device.is_inside_film(self.xp[k + 1]) {
                    return Err(Reject);
                }
                residual[k] = on_mass(self.xp[k + 1], self.vp[k + 1]) - self.force[k + 1];
                change = change.max(residual[k].abs());
            }
            if !change.is_finite() {
                return Err(Reject);
            }
            if change > 0.3 * previous && change > force_tolerance {
                // The film is stiff over this step: Newton's method instead.
                self.newton(device, table, &mut residual);
            }
            for k in 0..S - 1 {
                self.force[k + 1] += residual[k];
            }
            if change <= 0.02 * force_tolerance
                || change <= 4.0 * f64::EPSILON * self.force[0].abs()
            {
                settled = true;
                break;
            }
            if sweep > 1 && change > 10.0 * previous {
                return Err(Reject);
            }
            previous = change;
        }
        if !settled {
            return Err(Reject);
        }
        let (force, drive) = (self.force, self.drive);
        self.propagate(table, |i| {
            std::array::from_fn(|j| device.phi_p[i] * force[j] + device.phi_d[i] * drive[j])
        });
        Ok(())
    }

    /// Turns the residual of the film force at the points into the Newton correction.
    fn newton(&self, device: &Device, table: &Table, residual: &mut [f64; S - 1]) {
        const N: usize = S - 1;
        let mut a = [[0.0; N]; N];
        for k in 0..N {
            let (mut dx, mut dv) = if device.film_is_plain {
                device.film_slopes(self.xp[k + 1], self.vp[k + 1])
            } else {
                (0.0, 0.0)
            };
            if let Some(touch) = self.touch {
                let depth = touch.level - self.xp[k + 1];
                let ground = device.contact_slopes(depth, -self.vp[k + 1]);
                (dx, dv) = (dx + ground.0, dv + ground.1);
            }
            for j in 0..N {
                a[k][j] = -dx * table.p_from_p[0][k][j + 1] - dv * table.p_from_p[1][k][j + 1];
            }
            a[k][k] += 1.0;
        }
        eliminate(&mut a, residual);
    }

    fn flight_with_effects(
        &mut self,
        device: &Device,
        table: &Table,
        segment: &Segment,
        t: f64,
        force_tolerance: f64,
    ) -> Result<(), Reject> {
        let mut residual = [0.0; S];
        self.feel(device, segment, t, 0..1, None);
        self.act(device, segment, 0..1, false, &mut residual);
        self.force = [residual[0]; S];
        let states = self.z.len() / S;
        for k in 1..S {
            self.inputs.copy_within(0..states, k * states);
            self.back.copy_within(0..states, k * states);
        }
        // Forces and states that feel each other settle in turn: every other change may be far
        // smaller.
        let (mut previous, mut older) = (f64::INFINITY, f64::INFINITY);
        for sweep in 0..40 {
            self.sweeps += 1;
            let (force, drive, base) = (self.force, self.drive, self.base);
            self.propagate(table, |i| {
                std::array::from_fn(|j| {
                    device.phi_p[i] * force[j]
                        + device.phi_d[i] * drive[j]
                        + device.flight_base[i] * base[j]
                })
            });
            self.feel(device, segment, t, 1..S, None);
            self.propagate_states(table);
            self.act(device, segment, 1..S, false, &mut residual);
            let mut change = 0.0f64;
            for k in 1..S {
                if !device.is_inside_film(self.xp[k]) {
                    return Err(Reject);
                }
                residual[k] -= force[k];
                change = change
                    .max(residual[k].abs())
                    .max((self.drive[k] - drive[k]).abs() * device.drive_ratio);
            }
            if !change.is_finite() {
                return Err(Reject);
            }
            let mut correction: [f64; S - 1] = std::array::from_fn(|k| residual[k + 1]);
            if change > 0.3 * previous && change > force_tolerance {
                self.newton(device, table, &mut correction);
            }
            for k in 0..S - 1 {
                self.force[k + 1] += correction[k];
            }
            let size = self.force[0].abs().max(self.drive[0].abs());
            if change <= 0.02 * force_tolerance || change <= 8.0 * f64::EPSILON * size {
                return Ok(());
            }
            if sweep > 1 && change > 10.0 * previous.max(older) {
                return Err(Reject);
            }
            (older, previous) = (previous, change);
        }
        Err(Reject)
    }
}
