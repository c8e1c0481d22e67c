//! Readings that lag, over a step.
//!
//! A lag `y' = r (x - y)` of a motion that goes to and fro within a step needs no shorter steps:
//! what it makes of the free motion of a fast mode is known exactly, and what is left of the
//! motion is as smooth as the forces.

use super::Step;
use super::tables::Table;
use crate::sim::device::{Device, dot};
use crate::sim::nodes::{NODES, S, top_coefficient};

/// The two readings of a step, of the proof mass and of the cantilever.
#[derive(Debug, Clone, Default)]
pub(super) struct Readings {
    /// Which of the extra states is the first of them; `None` if they do not lag.
    pub first: Option<usize>,
    /// The readings at the points \[m\], but for the answer to the free motion of fast modes.
    smooth: [[f64; S]; 2],
    /// That answer, per displacement and per velocity of each mode's free motion.
    answers: Vec<[(f64, f64); 2]>,
}

impl Readings {
    /// A smooth part at the points, if extra state `i` is a reading.
    pub fn smooth(&self, i: usize) -> Option<&[f64; S]> {
        self.smooth.get(i.checked_sub(self.first?)?)
    }

    /// Adds the answer to the free motion of fast modes, `free`, to the extra states `values`.
    pub fn add_answers(&self, free: &[(f64, f64)], values: &mut [f64]) {
        let Some(first) = self.first else {
            return;
        };
        for ((x, v), answer) in free.iter().zip(&self.answers) {
            for (value, (per_x, per_v)) in values[first..].iter_mut().zip(answer) {
                *value += per_x * x + per_v * v;
            }
        }
    }
}

impl Step {
    /// Brings readings that lag along once the motion has settled; `shapes` are those of the
    /// structure at proof mass and cantilever, `levels` \[m\] where they are without its motion.
    pub(super) fn follow_readings(
        &mut self,
        device: &Device,
        table: &Table,
        shapes: [&[f64]; 2],
        levels: [f64; 2],
    ) {
        self.readings.first = device.reading_states();
        let Some(first) = self.readings.first else {
            return;
        };
        let (m, states) = (self.modes, self.rates.len());
        let rate = self.rates[first];
        self.readings.answers.clear();
        let (mut smooth, mut answered) = (levels.map(|level| [level; S]), [[0.0; S]; 2]);
        for (i, swing) in self.swings.iter().enumerate() {
            let answer = swing.oscillator.lagged(rate).filter(|_| swing.fast);
            let (per_x, per_v) = answer.unwrap_or_default();
            let own = shapes.map(|shape| (shape[i] * per_x, shape[i] * per_v));
            self.readings.answers.push(own);
            for (k, node) in NODES.iter().enumerate() {
                let (q, v) = (self.q[k * m + i], self.v[k * m + i]);
                let (x, dx) = match answer {
                    Some(_) => swing.answer_to_force(*node, self.h),
                    None => (q, v),
                };
                for r in 0..2 {
                    smooth[r][k] += shapes[r][i] * x;
                    answered[r][k] += own[r].0 * (q - x) + own[r].1 * (v - dx);
                }
            }
        }
        for r in 0..2 {
            let at = first + r;
            let decay = &table.decays[at];
            let input = smooth[r].map(|x| rate * x);
            let begun = self.z[at] - answered[r][0];
            self.readings.smooth[r] = std::array::from_fn(|k| match k.checked_sub(1) {
                None => begun,
                Some(k) => decay.state[k] * begun + dot(&decay.input[k], &input),
            });
            for k in 0..S {
                self.inputs[k * states + at] = input[k];
            }
            for k in 1..S {
                self.z[k * states + at] = self.readings.smooth[r][k] + answered[r][k];
            }
        }
    }

    /// What of the readings' motion is not followed \[m\].
    pub(super) fn reading_error(&self, i: usize, input: &[f64; S]) -> Option<f64> {
        self.readings.smooth(i)?;
        let within = self.h.min(1.0 / self.rates[i]);
        Some(dot(top_coefficient(), input).abs() * within)
    }
}
