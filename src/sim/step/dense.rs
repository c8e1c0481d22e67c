//! What a step says between its points.

use super::Step;
use crate::model::MAX_MODES;
use crate::model::drive::Segment;
use crate::sim::MAX_STATES;
use crate::sim::crossing::first_below;
use crate::sim::device::Device;
use crate::sim::linear::{QUICK_DECAY, Swing, decay_at};
use crate::sim::nodes::{Dense, S};

/// Values of the extra states at one instant, without allocation.
#[derive(Debug, Clone, Copy)]
pub struct StateValues {
    values: [f64; MAX_STATES],
    count: usize,
}

impl StateValues {
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

impl Step {
    /// Free motion of the fast modes at fraction `s` of the step: displacement and velocity; none
    /// of others.
    pub fn free_at(&self, s: f64) -> [(f64, f64); MAX_MODES] {
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
        self.states_beside(s, &free)
    }

    /// The same where the free motion of fast modes there is known.
    pub fn states_beside(&self, s: f64, free: &[(f64, f64); MAX_MODES]) -> StateValues {
        let count = self.rates.len();
        let mut values = [0.0; MAX_STATES];
        for (i, value) in values[..count].iter_mut().enumerate() {
            if self.keeps(i) {
                *value = self.z[i];
                continue;
            }
            let input: [f64; S] = std::array::from_fn(|k| self.inputs[k * count + i]);
            let smooth = self.readings.smooth(i).copied();
            let z = smooth.unwrap_or_else(|| std::array::from_fn(|k| self.z[k * count + i]));
            *value = if self.rates[i] * self.h > QUICK_DECAY {
                decay_at(self.rates[i], self.h, z[0], &input, s)
            } else {
                let slopes = std::array::from_fn(|k| input[k] - self.rates[i] * z[k]);
                Dense::new(&z, &slopes, self.h).value(s)
            };
        }
        self.readings.add_answers(free, &mut values);
        StateValues { values, count }
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

    /// Velocity of a point of the structure at fraction `s`; `smooth` is its motion but for
    /// the free motion of fast modes.
    pub fn velocity_at(&self, smooth: &Dense, shape: &[f64], s: f64) -> f64 {
        let fast = |(weight, swing): (&f64, &Swing)| {
            if swing.fast {
                weight * swing.free(s * self.h).1
            } else {
                0.0
            }
        };
        let free: f64 = shape.iter().zip(&self.swings).map(fast).sum();
        smooth.value_and_slope(s, self.h).1 + free
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

    /// Fraction of the step, up to `end`, at which the mass no longer slides the way it did;
    /// `shape` is the structure's at the mass.
    pub fn first_turn(&self, shape: &[f64], end: f64) -> Option<f64> {
        let smooth = self.smooth(shape);
        if self.slides_on(&smooth, shape) {
            return None;
        }
        let fastest = self.vp.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        let speed = |s: f64| self.sliding * self.velocity_at(&smooth, shape, s);
        first_below(speed, end, 1e-12 * fastest)
    }

    /// Most speed of a point of the structure in the free motion of `which` of the modes, over
    /// the step: what is damped gets no faster.
    fn most_speed(&self, shape: &[f64], which: impl Fn(&Swing) -> bool) -> f64 {
        let own = shape.iter().zip(&self.swings).filter(|(_, s)| which(s));
        own.map(|(weight, swing)| {
            let (x, v) = swing.start;
            weight.abs() * (v * v + swing.oscillator.omega2 * x * x).sqrt()
        })
        .sum()
    }

    /// Whether it is plain that the mass slides on all over the step; `smooth` is its motion but
    /// for the free motion of fast modes.
    fn slides_on(&self, smooth: &Dense, shape: &[f64]) -> bool {
        smooth.least_slope(self.sliding, self.h) > self.most_speed(shape, |swing| swing.fast)
    }

    /// Whether the mass may stop sliding the way it does within the step, up to fraction `end`,
    /// however the modes that swing through more than a period in it stand by then.
    pub fn may_turn(&self, shape: &[f64], end: f64) -> bool {
        let smooth = self.smooth(shape);
        if self.slides_on(&smooth, shape) {
            return false;
        }
        let swings = |swing: &Swing| swing.fast && self.h > swing.oscillator.longest_step();
        let most = self.most_speed(shape, swings);
        let speed = |s: f64| {
            let own = shape.iter().zip(&self.swings);
            let free: f64 = own
                .filter(|(_, swing)| swing.fast && !swings(swing))
                .map(|(weight, swing)| weight * swing.free(s * self.h).1)
                .sum();
            self.sliding * (smooth.value_and_slope(s, self.h).1 + free) - most
        };
        speed(0.0) < 0.0 || first_below(speed, end, 0.0).is_some()
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
