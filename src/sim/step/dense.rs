//! Dense output: the motion and the extra states between the points of a step.

use super::Step;
use crate::model::MAX_MODES;
use crate::model::drive::Segment;
use crate::sim::MAX_STATES;
use crate::sim::device::Device;
use crate::sim::linear::{QUICK_DECAY, QuickDecay};
use crate::sim::nodes::{Dense, S};

/// Values of the extra states at one instant, without allocation.
#[derive(Debug, Clone, Copy)]
pub struct StateValues {
    values: [f64; MAX_STATES],
    count: usize,
}

/// The course of an extra state over a step.
#[derive(Debug, Clone, Copy)]
pub enum Course {
    /// It stays what it is.
    Kept(f64),
    /// It decays within the step.
    Quick(QuickDecay),
    /// A polynomial.
    Smooth(Dense),
}

impl Course {
    /// At fraction `s` of the step.
    fn at(&self, s: f64) -> f64 {
        match self {
            Self::Kept(z) => *z,
            Self::Quick(decay) => decay.at(s),
            Self::Smooth(dense) => dense.value(s),
        }
    }
}

impl StateValues {
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

impl Step {
    /// Free motion of the fast modes at fraction `s` of the step: displacement and velocity; none
    /// of others.
    fn free_at(&self, s: f64) -> [(f64, f64); MAX_MODES] {
        let mut free = [(0.0, 0.0); MAX_MODES];
        for (free, swing) in free.iter_mut().zip(&self.swings) {
            if swing.fast {
                *free = swing.free(s * self.h);
            }
        }
        free
    }

    /// Extra states at fraction `s` of the step.
    pub fn states_at(&self, s: f64) -> StateValues {
        let free = if self.readings.first.is_some() {
            self.free_at(s)
        } else {
            [(0.0, 0.0); MAX_MODES]
        };
        let all = (0..self.rates.len()).map(|i| (i, self.course(i).at(s)));
        self.values(all, &free)
    }

    /// Extra states of those values, but for what they make of the free motion of fast modes; zero
    /// for others.
    fn values(&self, own: impl Iterator<Item = (usize, f64)>, free: &[(f64, f64)]) -> StateValues {
        let mut values = [0.0; MAX_STATES];
        own.for_each(|(i, value)| values[i] = value);
        self.readings.add_answers(free, &mut values);
        let count = self.rates.len();
        StateValues { values, count }
    }

    /// The courses over the step of the extra states that readings show.
    pub fn courses(&self, device: &Device) -> Vec<(usize, Course)> {
        let shown = device.shown_states();
        shown.map(|i| (i, self.course(i))).collect()
    }

    /// Those states at fraction `s`, where the free motion of fast modes there is known; zero for
    /// others.
    pub fn states_with_readings(
        &self,
        courses: &[(usize, Course)],
        s: f64,
        free: &[(f64, f64)],
    ) -> StateValues {
        self.values(courses.iter().map(|(i, course)| (*i, course.at(s))), free)
    }

    /// How an extra state goes between the points, but for what it makes of the free motion of
    /// fast modes.
    fn course(&self, i: usize) -> Course {
        let count = self.rates.len();
        if self.keeps(i) {
            return Course::Kept(self.z[i]);
        }
        let input: [f64; S] = std::array::from_fn(|k| self.inputs[k * count + i]);
        let smooth = self.readings.smooth(i).copied();
        let z = smooth.unwrap_or_else(|| std::array::from_fn(|k| self.z[k * count + i]));
        if self.rates[i] * self.h > QUICK_DECAY {
            Course::Quick(QuickDecay::new(self.rates[i], self.h, z[0], &input))
        } else {
            let slopes = std::array::from_fn(|k| input[k] - self.rates[i] * z[k]);
            Course::Smooth(Dense::new(&z, &slopes, self.h))
        }
    }

    /// Modal state at fraction `s` of the step, written to `q` and `v`.
    pub fn modal_at(&self, s: f64, q: &mut [f64], v: &mut [f64]) {
        let m = self.modes;
        for (i, swing) in self.swings.iter().enumerate() {
            let mut dense = if swing.fast {
                Dense::default()
            } else {
                Dense::new(
                    &std::array::from_fn(|k| self.q[k * m + i]),
                    &std::array::from_fn(|k| self.v[k * m + i]),
                    self.h,
                )
            };
            dense.add(1.0, &swing.particular);
            (q[i], v[i]) = dense.value_and_slope(s, self.h);
            if swing.fast {
                let (x, dx) = swing.free(s * self.h);
                q[i] += x;
                v[i] += dx;
            }
        }
    }

    /// Motion of a point of the structure over the step, but for the free motion of
    /// fast modes.
    pub fn smooth(&self, shape: &[f64]) -> Dense {
        let m = self.modes;
        let slow = |values: &[f64], k: usize| -> f64 {
            (0..m)
                .filter(|&i| !self.swings[i].fast)
                .map(|i| shape[i] * values[k * m + i])
                .sum()
        };
        let mut dense = if self.swings.iter().all(|swing| swing.fast) {
            Dense::default()
        } else {
            Dense::new(
                &std::array::from_fn(|k| slow(&self.q, k)),
                &std::array::from_fn(|k| slow(&self.v, k)),
                self.h,
            )
        };
        for (weight, swing) in shape.iter().zip(&self.swings) {
            dense.add(*weight, &swing.particular);
        }
        dense
    }

    /// Free motion of the fast modes at a point of the structure at fraction `s`.
    pub fn fast_at(&self, shape: &[f64], s: f64) -> f64 {
        shape
            .iter()
            .zip(&self.swings)
            .filter(|(_, swing)| swing.fast)
            .map(|(weight, swing)| weight * swing.free(s * self.h).0)
            .sum()
    }

    /// Pull-off force at fraction `s` of a held step from `t`, with the mass at `level`.
    pub fn held_pull(&self, device: &Device, segment: &Segment, t: f64, s: f64, level: f64) -> f64 {
        let (mut r, mut dr) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        let (r, dr) = (&mut r[..self.modes], &mut dr[..self.modes]);
        self.modal_at(s, r, dr);
        let t = t + s * self.h;
        let voltage = segment.shape.voltage(t);
        let mut at = device.held_kinematics(t, voltage, level, r, dr);
        let states = self.states_at(s);
        let z = states.as_slice();
        let drive = device.drive_force(&mut at, segment.branch, z);
        device.pull_held(r, dr, level, drive, device.force_on_held(&at, z))
    }
}
