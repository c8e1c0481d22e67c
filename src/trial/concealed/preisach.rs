//! A Preisach sum of relays for the piezo's hysteresis (I. Mayergoyz, Mathematical
//! Models of Hysteresis, 1991): `gc` from the whole history of the voltage, with loops
//! that close at every amplitude.

use crate::trial::voltage::{Piece, close};

/// Relays switch between minus and plus this voltage \[V\].
pub const SATURATION: f64 = 9.0;
/// Cells along each axis of the half plane of relays.
const CELLS_PER_AXIS: usize = 180;

/// The sum of relays as its Everett function on a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Preisach {
    /// `everett[i][j]`: output gained when the voltage rises from `v_j` to `v_i`.
    everett: Vec<f64>,
    /// Height of the loop at zero volts in the 8 V cycle, of this sum alone.
    height: f64,
}

impl Preisach {
    /// Relays that switch up at `a` and down at `b < a` with Gaussian weights: the
    /// coercive half width `(a - b)/2` about `coercive` with `spread`, the centre
    /// `(a + b)/2` within `reach` \[V\].
    #[must_use]
    pub fn new(coercive: f64, spread: f64, reach: f64) -> Self {
        let n = CELLS_PER_AXIS;
        let cell = 2.0 * SATURATION / n as f64;
        let mid = |i: usize| -SATURATION + (i as f64 + 0.5) * cell;
        // Everett function: weights of all relays with b >= v_j and a <= v_i.
        let mut everett = vec![0.0; (n + 1) * (n + 1)];
        let at = |i: usize, j: usize| i * (n + 1) + j;
        for i in 1..=n {
            for j in (0..i).rev() {
                let (a, b) = (mid(i - 1), mid(j));
                let half = 0.5 * (a - b);
                let centre = 0.5 * (a + b);
                let mut weight = (-0.5 * ((half - coercive) / spread).powi(2)
                    - 0.5 * (centre / reach).powi(2))
                .exp();
                if i - 1 == j {
                    weight *= 0.5;
                }
                everett[at(i, j)] = everett[at(i - 1, j)] + everett[at(i, j + 1)]
                    - everett[at(i - 1, j + 1)]
                    + weight;
            }
        }
        let mut sum = Self {
            everett,
            height: 1.0,
        };
        let up = sum.output(&[-SATURATION, 8.0, -8.0], 0.0);
        let down = sum.output(&[-SATURATION, 8.0], 0.0);
        sum.height = (down - up).abs().max(f64::MIN_POSITIVE);
        sum
    }

    fn gained(&self, high: f64, low: f64) -> f64 {
        let n = CELLS_PER_AXIS as f64;
        let place = |v: f64| ((v / SATURATION + 1.0) * 0.5 * n).clamp(0.0, n - 1e-9);
        let (x, y) = (place(high), place(low));
        if x <= y {
            return 0.0;
        }
        let (i, j) = (x as usize, y as usize);
        let (s, r) = (x - i as f64, y - j as f64);
        let e = |i: usize, j: usize| self.everett[i * (CELLS_PER_AXIS + 1) + j];
        if i == j {
            return e(i + 1, i) * (s - r).max(0.0);
        }
        e(i, j) * (1.0 - s) * (1.0 - r)
            + e(i + 1, j) * s * (1.0 - r)
            + e(i, j + 1) * (1.0 - s) * r
            + e(i + 1, j + 1) * s * r
    }

    /// Output for remembered extremes (the lower saturation first) and the voltage `v`.
    fn output(&self, memory: &[f64], v: f64) -> f64 {
        let mut sum = 0.0;
        for (k, extreme) in memory.iter().enumerate() {
            let next = memory.get(k + 1).copied().unwrap_or(v);
            sum += if k % 2 == 0 {
                self.gained(next, *extreme)
            } else {
                -self.gained(*extreme, next)
            };
        }
        sum
    }

    /// Deviation of `gc` from the loop's middle line at `t`, with a loop of `height` at
    /// zero volts when cycled by 8 V. Falling branches lie lower, as the piezo's do.
    #[must_use]
    pub fn deviation(&self, piece: &Piece, v: f64, height: f64) -> f64 {
        let scale = height / self.height;
        // `gc` falls as the voltage rises: the sum enters with a minus, and the middle
        // line of its own 8 V cycle is taken out.
        let middle = 0.5
            * (self.output(&[-SATURATION, 8.0, -8.0], v.clamp(-8.0, 8.0))
                + self.output(&[-SATURATION, 8.0], v.clamp(-8.0, 8.0)));
        let last = piece.memory.len();
        let passes = last >= 3 && {
            let beyond = piece.memory[last - 2];
            if last % 2 == 1 {
                v >= beyond
            } else {
                v <= beyond
            }
        };
        let output = if passes {
            let mut memory = piece.memory.clone();
            close(&mut memory, v);
            self.output(&memory, v)
        } else {
            self.output(&piece.memory, v)
        };
        -scale * (output - middle)
    }
}

#[cfg(test)]
mod tests {
    use super::super::preisach::*;
    use crate::trial::voltage::{Shape, remember};

    fn line(start: f64, from: f64, to: f64) -> Piece {
        Piece {
            start,
            end: start + 1.0,
            shape: Shape::Line {
                start,
                v: from,
                slope: to - from,
            },
            rising: to > from,
            memory: Vec::new(),
        }
    }

    #[test]
    fn loops_close_and_are_continuous() {
        let sum = Preisach::new(1.5, 1.0, 4.0);
        let turns = [-9.0, 8.0, -8.0, 5.0, -2.0, 3.0, -2.0, 6.0, -8.0, 8.0];
        let mut pieces: Vec<Piece> = turns
            .windows(2)
            .enumerate()
            .map(|(k, w)| line(k as f64, w[0], w[1]))
            .collect();
        remember(&mut pieces, -SATURATION);
        let value = |k: usize, v: f64| sum.deviation(&pieces[k], v, 2.0);
        for k in 1..pieces.len() {
            let v = turns[k];
            assert!((value(k - 1, v) - value(k, v)).abs() < 1e-9, "turn {k}");
        }
        // The 8 V loop has the height asked for, rising above falling.
        assert!((value(2, 0.0) - value(1, 0.0) - 2.0).abs() < 1e-9);
        // Return to -2 V closes the minor loop 3, -2.
        assert!((value(4, -2.0) - value(6, -2.0)).abs() < 1e-9);
        // The branch passes its old extreme without a kink in value.
        assert!((value(7, 5.0 - 1e-9) - value(7, 5.0 + 1e-9)).abs() < 1e-6);
        // Smooth on the scale of millivolts.
        let jumps = (0..5000).map(|i| {
            let v = -8.0 + 0.002 * f64::from(i);
            (value(2, v + 0.002) - value(2, v)).abs()
        });
        assert!(jumps.fold(0.0, f64::max) < 3e-3);
    }
}
