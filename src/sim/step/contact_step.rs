//! A step with the proof mass held at a level: the motion of the rest of the structure.

use super::tables::{Table, Tables};
use super::{RESOLVED_FORCE_ERROR, Reject, Step};
use crate::model::MAX_MODES;
use crate::model::drive::Segment;
use crate::sim::device::{Device, dot};
use crate::sim::nodes::{S, top_coefficient};

impl Step {
    /// A step with the proof mass held at `level` \[m\]. `q`, `v` are held coordinates.
    #[allow(clippy::too_many_arguments)]
    pub fn held_step(
        &mut self,
        device: &Device,
        tables: &Tables,
        level: usize,
        segment: &Segment,
        t: f64,
        state: (&[f64], &[f64], &[f64]),
        ground: f64,
        tolerance: f64,
    ) -> Result<(), Reject> {
        let table = tables.get(level);
        let growth = self.start(device, table, state);
        let (m, held) = (self.modes, &device.held);
        let drive = self.known_drive(device, table, segment, t, tolerance / growth)?;
        let pull = match drive {
            Some(_) => {
                self.held_plain(device, table, ground);
                std::array::from_fn(|k| self.pull(device, k, ground, 0.0))
            }
            None => {
                self.held_with_effects(device, table, segment, (t, ground), tolerance / growth)?
            }
        };
        self.settle(table);
        let none = [0.0; MAX_MODES];
        let levels = [ground, ground * device.anchor_c];
        self.follow_readings(device, table, [&none[..m], &held.cantilever], levels);
        self.force = pull;
        let drive_top = dot(top_coefficient(), &self.drive).abs();
        self.error = RESOLVED_FORCE_ERROR * growth * drive_top * device.drive_ratio;
        self.error += self.state_error(device, growth, RESOLVED_FORCE_ERROR)
            + self.base_error(device, growth);
        if self.error.is_finite() && self.q.iter().all(|q| q.is_finite()) {
            Ok(())
        } else {
            Err(Reject)
        }
    }

    /// The step where effects act through the drive alone, which is known: the modes are linear.
    fn held_plain(&mut self, device: &Device, table: &Table, ground: f64) {
        let (m, held) = (self.modes, &device.held);
        let drive = self.drive;
        let own = |i: usize| drive.map(|d| held.drive[i] * d + held.level_force[i] * ground);
        if !table.damped.is_empty() {
            // Velocities without damping between modes but for that at the start.
            let undamped = &mut self.v_before;
            for i in 0..m {
                let (q0, v0) = (self.q[i], self.v[i]);
                let mut force = own(i);
                force[0] -= dot(&held.cross_damping[i * m..(i + 1) * m], &self.v[..m]);
                let mode = &table.modes[i];
                for k in 0..S - 1 {
                    let e = &mode.state[k];
                    undamped[k * m + i] = e[2] * q0 + e[3] * v0 + dot(&mode.velocity[k], &force);
                }
            }
            let n = (S - 1) * m;
            for (v, row) in self.v[m..].iter_mut().zip(table.damped.chunks_exact(n)) {
                *v = dot(row, &undamped[..n]);
            }
        }
        self.propagate_held(device, table, own);
    }

    /// [`Self::propagate`] of held modes that are damped by each other's velocities as these are.
    fn propagate_held(
        &mut self,
        device: &Device,
        table: &Table,
        per_mode: impl Fn(usize) -> [f64; S],
    ) {
        let m = self.modes;
        self.v_before.copy_from_slice(&self.v);
        let v_before = std::mem::take(&mut self.v_before);
        self.propagate(table, |i| {
            let mut force = per_mode(i);
            if !table.damped.is_empty() {
                let row = &device.held.cross_damping[i * m..(i + 1) * m];
                for (force, v) in force.iter_mut().zip(v_before.chunks_exact(m)) {
                    *force -= dot(row, v);
                }
            }
            force
        });
        self.v_before = v_before;
    }

    /// The step where effects depend on the motion that they cause. Forces and motion are iterated
    /// until the pull-off force, which is returned, changes by less than `force_tolerance` \[N\].
    fn held_with_effects(
        &mut self,
        device: &Device,
        table: &Table,
        segment: &Segment,
        (t, ground): (f64, f64),
        force_tolerance: f64,
    ) -> Result<[f64; S], Reject> {
        let (m, held) = (self.modes, &device.held);
        for k in 1..S {
            self.q.copy_within(0..m, k * m);
            self.v.copy_within(0..m, k * m);
        }
        let mut on_mass = [0.0; S];
        let mut previous = [f64::INFINITY; S];
        for _ in 0..=40 {
            self.sweeps += 1;
            self.feel(device, segment, t, 0..S, Some(ground));
            self.act(device, segment, 0..S, true, &mut on_mass);
            let (drive, base) = (self.drive, self.base);
            self.propagate_held(device, table, |i| {
                std::array::from_fn(|j| {
                    let shaken = device.held_base[i] * base[j];
                    held.drive[i] * drive[j] + held.level_force[i] * ground + shaken
                })
            });
            self.propagate_states(table);
            let pull = std::array::from_fn(|k| self.pull(device, k, ground, on_mass[k]));
            let change = (0..S)
                .map(|k: usize| (pull[k] - previous[k]).abs())
                .fold(0.0f64, f64::max);
            if change <= 0.02 * force_tolerance || change <= 1e-14 * pull[0].abs() {
                return Ok(pull);
            }
            previous = pull;
        }
        Err(Reject)
    }

    /// Pull-off force at a point, the mass held at `ground` \[m\], with `on_mass` \[N\] on it.
    fn pull(&self, device: &Device, k: usize, ground: f64, on_mass: f64) -> f64 {
        let drive = self.drive[k];
        device.pull_held(self.q_at(k), self.v_at(k), ground, drive, on_mass)
    }
}
