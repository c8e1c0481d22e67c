//! The input between samples: means and Legendre moments of `u(t)` over each interval.
//!
//! The input has jumps where the hysteresis branch changes, between two samples. Of what happens
//! within an interval an oscillator only sees moments: with
//! `u = sum_j (2j+1)/h m_j P_j`, `m_j = integral u P_j`, the response at the next sample is exact up
//! to the order of the expansion of its own `exp(lambda t)`, not of `u`.

use crate::model::drive::Segment;
use crate::model::piezo::Piezo;

/// Moments of each interval. With six, a mode at half the sampling rate errs by 3e-4.
pub const MOMENTS: usize = 6;

/// Nodes and weights of Gauss's rule of six points on -1 .. 1.
pub const GAUSS: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_4),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];

/// Legendre polynomials 0 to 5 at `x`.
#[must_use]
pub fn legendre(x: f64) -> [f64; MOMENTS] {
    let x2 = x * x;
    [
        1.0,
        x,
        0.5 * (3.0 * x2 - 1.0),
        0.5 * x * (5.0 * x2 - 3.0),
        0.125 * (x2 * (35.0 * x2 - 30.0) + 3.0),
        0.125 * x * (x2 * (63.0 * x2 - 70.0) + 15.0),
    ]
}

/// The input as a function of time.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// The voltage, piece by piece.
    pub pieces: &'a [Segment],
    /// The drive's branches; `None` for the voltage itself.
    pub piezo: Option<Piezo>,
    /// By how much the readings lag behind the voltage \[s\].
    pub skew: f64,
}

impl Input<'_> {
    fn in_piece(&self, piece: &Segment, t: f64) -> f64 {
        let volts = piece.shape.voltage(t);
        self.piezo.map_or(volts, |p| p.gain(volts, piece.branch))
    }

    /// Index of the piece in force at `t` \[s\] of the readings.
    #[must_use]
    pub fn piece_at(&self, t: f64) -> usize {
        let index = self.pieces.partition_point(|p| p.end <= t - self.skew);
        index.min(self.pieces.len().saturating_sub(1))
    }

    /// The input at `t`, `piece` being a guess that is moved on.
    pub fn at(&self, t: f64, piece: &mut usize) -> f64 {
        let own = t - self.skew;
        self.advance(own, piece);
        self.pieces
            .get(*piece)
            .map_or(0.0, |p| self.in_piece(p, own))
    }

    fn advance(&self, own: f64, piece: &mut usize) {
        while self.pieces.get(*piece).is_some_and(|p| p.end <= own)
            && *piece + 1 < self.pieces.len()
        {
            *piece += 1;
        }
    }

    /// Calls `add` with parts of `from..to` on which the input is smooth: part, and the piece there.
    fn parts(
        &self,
        from: f64,
        to: f64,
        piece: &mut usize,
        mut add: impl FnMut(f64, f64, &Segment),
    ) {
        let (mut at, end) = (from - self.skew, to - self.skew);
        self.advance(at, piece);
        while let Some(own) = self.pieces.get(*piece) {
            let stop = if *piece + 1 < self.pieces.len() {
                own.end.min(end)
            } else {
                end
            };
            if stop > at {
                add(at, stop, own);
                at = stop;
            }
            if at >= end || *piece + 1 >= self.pieces.len() {
                return;
            }
            *piece += 1;
        }
    }

    /// Moments over `from..to`, and the piece that holds `to`.
    pub fn moments(&self, from: f64, to: f64, piece: &mut usize) -> [f64; MOMENTS] {
        let mut sums = [0.0; MOMENTS];
        let (middle, half) = (0.5 * (from + to) - self.skew, 0.5 * (to - from));
        self.parts(from, to, piece, |a, b, own| {
            let (m, r) = (0.5 * (a + b), 0.5 * (b - a));
            for (x, w) in GAUSS {
                let t = m + r * x;
                let weighted = w * r * self.in_piece(own, t);
                for (sum, p) in sums.iter_mut().zip(legendre((t - middle) / half)) {
                    *sum += weighted * p;
                }
            }
        });
        sums
    }

    /// Mean over `from..to`.
    pub fn mean(&self, from: f64, to: f64, piece: &mut usize) -> f64 {
        // Gauss's rule of two points: the interval is a small part of a sample.
        let node = 1.0 / 3f64.sqrt();
        let mut sum = 0.0;
        self.parts(from, to, piece, |a, b, own| {
            let (m, r) = (0.5 * (a + b), 0.5 * (b - a));
            sum += r * (self.in_piece(own, m - r * node) + self.in_piece(own, m + r * node));
        });
        sum / (to - from)
    }
}
