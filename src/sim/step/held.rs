//! A step with the proof mass held: what its structure does while the mass stays where it is.

use super::tables::Tables;
use super::{FOLLOWED, Reject, Step};
use crate::model::MAX_MODES;
use crate::model::drive::Segment;
use crate::sim::device::{Device, dot};
use crate::sim::nodes::{S, top_coefficient};

impl Step {
    /// A step with the proof mass held at `level` [m]. `q`, `v` are held coordinates.
    #[allow(clippy::too_many_arguments)]
    pub fn held(
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
        self.h = table.h;
        let (q0, v0, z0) = state;
        self.start(q0, v0, z0);
        let m = self.modes;
        let held = &device.held;
        let growth = device.mobility * table.h * device.time_scale.max(table.h);
        let drive = self.known_drive(device, table, segment, t, tolerance / growth)?;
        let effects = drive.is_none();
        for k in 1..S {
            self.q.copy_within(0..m, k * m);
            self.v.copy_within(0..m, k * m);
        }
        // Without effects and damping between modes the first answer is exact.
        let sweeps = if effects || m > 1 { 40 } else { 1 };
        let mut on_mass = [0.0; S];
        let mut previous = [f64::INFINITY; S];
        for sweep in 0..=sweeps {
            if effects {
                self.feel(device, segment, t, 0..S, Some(ground));
                self.act(device, segment, 0..S, true, &mut on_mass);
            }
            let (drive, base) = (self.drive, self.base);
            self.v_before.copy_from_slice(&self.v);
            let v_before = std::mem::take(&mut self.v_before);
            self.propagate(table, |i| {
                std::array::from_fn(|j| {
                    let row = i * m..(i + 1) * m;
                    let cross = dot(&held.cross_damping[row], &v_before[j * m..(j + 1) * m]);
                    let shaken = if effects {
                        device.held_base[i] * base[j]
                    } else {
                        0.0
                    };
                    held.drive[i] * drive[j] + held.level_force[i] * ground + shaken - cross
                })
            });
            self.v_before = v_before;
            if effects {
                self.propagate_states(table);
            }
            let pull: [f64; S] = std::array::from_fn(|k| {
                device.pull_held(
                    self.q_at(k),
                    self.v_at(k),
                    ground,
                    self.drive[k],
                    on_mass[k],
                )
            });
            let change = (0..S)
                .map(|k| (pull[k] - previous[k]).abs())
                .fold(0.0, f64::max);
            previous = pull;
            if sweeps == 1 || change * growth <= 0.02 * tolerance || change <= 1e-14 * pull[0].abs()
            {
                break;
            }
            if sweep == sweeps {
                return Err(Reject);
            }
        }
        self.settle(table);
        let none = [0.0; MAX_MODES];
        let levels = [ground, ground * device.anchor_c];
        self.follow_readings(device, table, [&none[..m], &held.cantilever], levels);
        self.force = previous;
        let drive_top = dot(top_coefficient(), &self.drive).abs();
        self.error = FOLLOWED * growth * drive_top * device.drive_ratio;
        self.error += self.state_error(device, growth, FOLLOWED) + self.base_error(device, growth);
        if self.error.is_finite() && self.q.iter().all(|q| q.is_finite()) {
            Ok(())
        } else {
            Err(Reject)
        }
    }
}
