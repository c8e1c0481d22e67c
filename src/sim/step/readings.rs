//! Readings that lag, over a step.
//!
//! A lag `y' = r (x - y)` of a motion that vibrates within a step needs no shorter steps. Its
//! response to the free motion of a fast mode is known in closed form, and the remaining motion
//! is as smooth as the forces.

use crate::sim::nodes::S;

/// The two readings of a step, of the proof mass and of the cantilever.
#[derive(Debug, Clone, Default)]
pub(super) struct Readings {
    /// Which of the extra states is the first of them; `None` if they do not lag.
    pub first: Option<usize>,
    /// The readings at the points \[m\], but for the answer to the free motion of fast modes.
    pub smooth: [[f64; S]; 2],
    /// That answer, per displacement and per velocity of each mode's free motion.
    pub answers: Vec<[(f64, f64); 2]>,
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
