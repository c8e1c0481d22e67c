//! Integrates lagging readings over a step, and estimates their error.

use super::Step;
use super::tables::Table;
use crate::sim::device::{Device, dot};
use crate::sim::nodes::{NODES, S, top_coefficient};

impl Step {
    /// Integrates the lagging readings once the motion has converged; `shapes` are those of the
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

    /// Error of a reading over the step \[m\]; `None` if extra state `i` is no reading.
    pub(super) fn reading_error(&self, i: usize, input: &[f64; S]) -> Option<f64> {
        self.readings.smooth(i)?;
        let within = self.h.min(1.0 / self.rates[i]);
        Some(dot(top_coefficient(), input).abs() * within)
    }
}
