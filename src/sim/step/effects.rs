//! Effects in a step: the drive that they change, the kinematics that they see at the points,
//! and the forces that they exert there.

// The indices are those of the method's matrices; iterators would hide them.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use super::tables::Table;
use super::{Reject, Step};
use crate::model::drive::Segment;
use crate::model::effects::Kinematics;
use crate::sim::device::Device;
use crate::sim::nodes::{NODES, S};

impl Step {
    /// The drive at the points of a step from `t`, which does not depend on the motion, and the
    /// base's acceleration; the extra states as they are at the beginning.
    fn begin_drive(&mut self, device: &Device, segment: &Segment, t: f64) {
        let states = self.z.len() / S;
        self.drive_gain = [None; S];
        for k in 0..S {
            let t = t + NODES[k] * self.h;
            self.base[k] = device.base_acceleration(t);
            self.voltage[k] = segment.shape.voltage(t);
            self.seen[k] = Kinematics {
                t,
                voltage: self.voltage[k],
                ..Kinematics::default()
            };
            self.z.copy_within(0..states, k * states);
            self.tell_drive(device, segment, k);
        }
    }

    /// The drive at the points where effects change nothing of the motion but by it, and whether
    /// it is constant; `None` where forces and states must settle together, which begins.
    pub(super) fn known_drive(
        &mut self,
        device: &Device,
        table: &Table,
        segment: &Segment,
        t: f64,
        force_tolerance: f64,
    ) -> Result<Option<bool>, Reject> {
        if !device.is_moved_by_effects() {
            return Ok(Some(self.plain_drive(device, segment, t)));
        }
        self.begin_drive(device, segment, t);
        if !device.only_drive {
            return Ok(None);
        }
        self.settle_drive(device, table, segment, force_tolerance)?;
        Ok(Some(false))
    }

    /// The drive at the points, and the extra states that depend on it alone,
    /// to within `force_tolerance` \[N\] on the mass.
    fn settle_drive(
        &mut self,
        device: &Device,
        table: &Table,
        segment: &Segment,
        force_tolerance: f64,
    ) -> Result<(), Reject> {
        if self.z.is_empty() {
            return Ok(());
        }
        // States that feed on others settle one after the other.
        for _ in 0..40 {
            self.sweeps += 1;
            let before = self.drive;
            for k in 0..S {
                self.feed(device, k);
            }
            self.propagate_states(table);
            for k in 1..S {
                self.tell_drive(device, segment, k);
            }
            let own = self.drive.iter().zip(&before);
            let change = own.fold(0.0f64, |a, (now, before)| a.max((now - before).abs()));
            if !change.is_finite() {
                return Err(Reject);
            }
            let change = change * device.drive_ratio;
            if change <= 0.02 * force_tolerance
                || change <= 8.0 * f64::EPSILON * self.drive[0].abs()
            {
                return Ok(());
            }
        }
        Err(Reject)
    }

    /// Inputs that the extra states get from what is seen at a point.
    fn feed(&mut self, device: &Device, k: usize) {
        let states = self.z.len() / S;
        let (at, z) = (&self.seen[k], &self.z[k * states..(k + 1) * states]);
        let inputs = &mut self.inputs[k * states..(k + 1) * states];
        device.state_inputs(at, z, inputs);
        device.paces(at, |i, pace| {
            let back = (1.0 - pace) * self.rates[i];
            inputs[i] = pace * inputs[i] + back * z[i];
            self.back[k * states + i] = back;
        });
    }

    /// Computes the drive's force at a point, and its gain in what is seen there. That of a memory
    /// takes long, and stays the same while the motion settles.
    fn tell_drive(&mut self, device: &Device, segment: &Segment, k: usize) {
        let states = self.z.len() / S;
        let own = k * states..(k + 1) * states;
        let (at, z) = (&mut self.seen[k], &self.z[own.clone()]);
        let known = self.drive_gain[k];
        match known.filter(|_| device.drives_alike(z, &self.drive_states[own.clone()])) {
            Some(gain) => at.gain = gain,
            None => {
                self.drive[k] = device.drive_force(at, segment.branch, z);
                self.drive_gain[k] = Some(at.gain);
                self.drive_states[own.clone()].copy_from_slice(&self.z[own]);
            }
        }
    }

    /// What effects see at some of the points, and the inputs that their extra states get from
    /// it. Held at `ground`, or in flight.
    pub(super) fn feel(
        &mut self,
        device: &Device,
        segment: &Segment,
        t: f64,
        points: Range<usize>,
        ground: Option<f64>,
    ) {
        let states = self.z.len() / S;
        for k in points {
            let (q, v, voltage) = (self.q_at(k), self.v_at(k), self.voltage[k]);
            let t = t + NODES[k] * self.h;
            let at = match ground {
                Some(ground) => device.held_kinematics(t, voltage, ground, q, v),
                None => device.flight_kinematics(t, voltage, q, v),
            };
            (self.xp[k], self.vp[k]) = (at.xp, at.vp);
            self.seen[k] = at;
            if states > 0 {
                self.tell_drive(device, segment, k);
                self.feed(device, k);
            }
        }
    }

    /// Forces of what is seen at some of the points, with the extra states as they are: on the
    /// mass into `force`, the drive's in place.
    pub(super) fn act(
        &mut self,
        device: &Device,
        segment: &Segment,
        points: Range<usize>,
        held: bool,
        force: &mut [f64; S],
    ) {
        let states = self.z.len() / S;
        for k in points {
            let (at, z) = (&self.seen[k], &self.z[k * states..(k + 1) * states]);
            force[k] = if held {
                device.force_on_held(at, z)
            } else {
                let force = device.effect_force(at, z) + device.altered_film_force(at, z);
                force - device.friction(at.xp) * self.sliding
                    + self.touch.map_or(0.0, |touch| {
                        device.contact_force(touch.level - at.xp, -at.vp, at.t - touch.since)
                    })
            };
            self.tell_drive(device, segment, k);
        }
    }
}
