//! Independent oscillators and decays, advanced exactly under polynomial forces.

// The indices are those of the method's matrices; iterators would hide them.
#![allow(clippy::needless_range_loop)]

use super::nodes::{NODES, S, gauss, interpolant, lagrange};

/// `x'' + damping x' + omega2 x = force per unit modal mass`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Oscillator {
    /// Squared angular frequency [1/s^2]; 0 is a free mass.
    pub omega2: f64,
    /// Damping [1/s].
    pub damping: f64,
}

impl Oscillator {
    /// Response to a unit impulse and its time derivative at `t` \[s\].
    ///
    /// Under-, over- and critically damped in one form without cancellation.
    pub fn impulse_response(&self, t: f64) -> (f64, f64) {
        let a = 0.5 * self.damping;
        let d = self.omega2 - a * a;
        if d >= 0.0 {
            let w = d.sqrt();
            let decay = (-a * t).exp();
            let x = w * t;
            // That of the standard library calls the platform's, which on some takes longer to set
            // its rounding than to compute.
            let (sin, cos) = libm::sincos(x);
            let sinc = if x < 1e-4 {
                t * (1.0 - x * x / 6.0)
            } else {
                sin / w
            };
            (decay * sinc, decay * (cos - a * sinc))
        } else {
            let k = (-d).sqrt();
            // -a + k, written so that a weak spring is not lost in rounding.
            let slow = (-self.omega2 / (a + k) * t).exp();
            let y = 2.0 * k * t;
            let sinhc = if y < 1e-8 {
                t * (1.0 - 0.5 * y)
            } else {
                -(-y).exp_m1() / (2.0 * k)
            };
            (slow * sinhc, slow * (0.5 * (1.0 + (-y).exp()) - a * sinhc))
        }
    }

    /// Longest step \[s\] over which the motion is followed exactly between the points, and
    /// its crests are not overlooked: a period of a vibration, which [`Swing`] carries, but less than one time
    /// constant of a creeping motion, which the polynomial carries. Infinite for a free
    /// mass.
    pub fn longest_step(&self) -> f64 {
        let a = 0.5 * self.damping;
        let d = a * a - self.omega2;
        if d > 0.0 {
            0.5 / (a + d.sqrt())
        } else {
            6.0 / self.omega2.sqrt()
        }
    }

    /// Whether it goes to and fro.
    pub fn swings(&self) -> bool {
        self.damping * self.damping < 4.0 * self.omega2
    }

    /// What a lag `y' = rate (x - y)` of free motion `x` goes over to, per displacement and per
    /// velocity \[s\]; `None` if the motion does not go to and fro, and may decay as the lag does.
    pub fn lagged(&self, rate: f64) -> Option<(f64, f64)> {
        let per_velocity = 1.0 / (self.damping - rate - self.omega2 / rate);
        self.swings()
            .then_some((per_velocity * (self.damping - rate), per_velocity))
    }

    /// From displacement and velocity to those after `t` \[s\] of free motion:
    /// `[xx, xv, vx, vv]`.
    pub fn free_motion(&self, t: f64) -> [f64; 4] {
        let (s, ds) = self.impulse_response(t);
        [ds + self.damping * s, s, -self.omega2 * s, ds]
    }
}

/// The motion of a fast oscillator over one step: the particular answer to its force,
/// a polynomial, and free motion on top, which no polynomial follows well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    /// The oscillator.
    pub oscillator: Oscillator,
    /// Whether it is fast enough over this step to need this form.
    pub fast: bool,
    /// Particular answer, coefficients in `u`.
    pub particular: [f64; S],
    /// Displacement and velocity of the free motion at the step's start.
    pub start: (f64, f64),
}

impl Swing {
    /// Below this many radians per step a polynomial is exact to rounding.
    const MAX_POLYNOMIAL_PHASE: f64 = 0.5;

    /// From the state at the start of a step of `h` \[s\] and the forces at its points.
    pub fn new(oscillator: Oscillator, h: f64, x: f64, v: f64, force: &[f64; S]) -> Self {
        let mut swing = Self {
            oscillator,
            fast: oscillator.omega2 * h * h
                > Self::MAX_POLYNOMIAL_PHASE * Self::MAX_POLYNOMIAL_PHASE,
            particular: [0.0; S],
            start: (x, v),
        };
        if !swing.fast {
            return swing;
        }
        let f = interpolant(force);
        let k = 2.0 / h;
        let p = &mut swing.particular;
        for n in (0..S).rev() {
            let order = n as f64;
            let above = |m: usize| p.get(m).copied().unwrap_or(0.0);
            p[n] = (f[n]
                - oscillator.damping * k * (order + 1.0) * above(n + 1)
                - k * k * (order + 1.0) * (order + 2.0) * above(n + 2))
                / oscillator.omega2;
        }
        swing.set_out(h, x, v);
        swing
    }

    /// The free motion with which the whole starts at `x` and `v`.
    fn set_out(&mut self, h: f64, x: f64, v: f64) {
        let p = &self.particular;
        // At u = -1.
        let value = p[0] - p[1] + p[2] - p[3] + p[4];
        let slope = 2.0 / h * (p[1] - 2.0 * p[2] + 3.0 * p[3] - 4.0 * p[4]);
        self.start = (x - value, v - slope);
    }

    /// Particular answer at fraction `s` of a step of `h` \[s\]: displacement and velocity.
    pub fn answer_to_force(&self, s: f64, h: f64) -> (f64, f64) {
        let (u, p) = (2.0 * s - 1.0, &self.particular);
        let value = p[0] + u * (p[1] + u * (p[2] + u * (p[3] + u * p[4])));
        let slope = p[1] + u * (2.0 * p[2] + u * (3.0 * p[3] + u * 4.0 * p[4]));
        (value, 2.0 / h * slope)
    }

    /// Most speed of the free motion over the step: what is damped gets no faster.
    pub fn most_speed(&self) -> f64 {
        let (x, v) = self.start;
        (v * v + self.oscillator.omega2 * x * x).sqrt()
    }

    /// Free motion at `t` \[s\] after the step's start: displacement and velocity.
    pub fn free(&self, t: f64) -> (f64, f64) {
        apply(&self.oscillator.free_motion(t), self.start)
    }
}

/// Applies `[xx, xv, vx, vv]` to a displacement and a velocity.
#[inline]
pub fn apply(motion: &[f64; 4], (x, v): (f64, f64)) -> (f64, f64) {
    (motion[0] * x + motion[1] * v, motion[2] * x + motion[3] * v)
}

/// One oscillator's exact answer over a step of given length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Propagator {
    /// The oscillator.
    pub oscillator: Oscillator,
    /// At each point but the first: from (x0, v0) to x and v, `[xx, xv, vx, vv]`.
    pub state: [[f64; 4]; S - 1],
    /// At each point but the first: displacement per force value at each point.
    pub displacement: [[f64; S]; S - 1],
    /// Likewise velocity.
    pub velocity: [[f64; S]; S - 1],
    /// Length of the step \[s\].
    h: f64,
    /// The [`Swing`] of each force of 1 at a point and 0 at the others: what the particular answer
    /// has per force, by point.
    answers: [[f64; S]; S],
    /// See [`Swing::fast`].
    fast: bool,
}

impl Propagator {
    /// Over a step of `h` \[s\].
    pub fn new(oscillator: Oscillator, h: f64) -> Self {
        let mut result = Self {
            oscillator,
            h,
            ..Self::default()
        };
        for k in 0..S - 1 {
            result.state[k] = oscillator.free_motion(NODES[k + 1] * h);
        }
        let swings: [Swing; S] = std::array::from_fn(|j| {
            let force = std::array::from_fn(|i| f64::from(u8::from(i == j)));
            Swing::new(oscillator, h, 0.0, 0.0, &force)
        });
        result.fast = swings[0].fast;
        result.answers = swings.map(|swing| swing.particular);
        if oscillator.swings() && h > oscillator.longest_step() {
            // No quadrature follows many periods; the answer to a polynomial is one.
            for (j, swing) in swings.iter().enumerate() {
                for k in 0..S - 1 {
                    let (x, v) = swing.answer_to_force(NODES[k + 1], h);
                    let (free_x, free_v) = swing.free(NODES[k + 1] * h);
                    result.displacement[k][j] = x + free_x;
                    result.velocity[k][j] = v + free_v;
                }
            }
            return result;
        }
        for k in 0..S - 1 {
            let end = NODES[k + 1] * h;
            for &(point, weight) in gauss() {
                let (s, ds) = oscillator.impulse_response(end * (1.0 - point));
                let basis = lagrange(NODES[k + 1] * point);
                for j in 0..S {
                    result.displacement[k][j] += end * weight * s * basis[j];
                    result.velocity[k][j] += end * weight * ds * basis[j];
                }
            }
        }
        result
    }

    /// [`Swing::new`] over the step.
    pub fn swing(&self, x: f64, v: f64, force: &[f64; S]) -> Swing {
        let mut swing = Swing {
            oscillator: self.oscillator,
            fast: self.fast,
            particular: [0.0; S],
            start: (x, v),
        };
        if swing.fast {
            for (answer, force) in self.answers.iter().zip(force) {
                for (p, answer) in swing.particular.iter_mut().zip(answer) {
                    *p += answer * force;
                }
            }
            swing.set_out(self.h, x, v);
        }
        swing
    }
}

/// Time constants after which `exp` of a decay is zero in double precision.
const MAX_DECAY_TIMES: f64 = 746.0;

/// One decay `z' = -rate z + input` over a step of given length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DecayPropagator {
    /// At each point but the first: factor of z0.
    pub state: [f64; S - 1],
    /// At each point but the first: z per input value at each point.
    pub input: [[f64; S]; S - 1],
}

impl DecayPropagator {
    /// Over a step of `h` \[s\], however fast the decay.
    pub fn new(rate: f64, h: f64) -> Self {
        let mut result = Self::default();
        for k in 0..S - 1 {
            let end = NODES[k + 1] * h;
            result.state[k] = (-rate * end).exp();
            // Panels that grow from the step's end, where the kernel is largest. Beyond the last
            // one it is zero to rounding.
            let (mut from, mut width) = (0.0, if rate > 0.0 { 1.0 / rate } else { end });
            while from < end && rate * from < MAX_DECAY_TIMES {
                let to = (from + width).min(end);
                for &(point, weight) in gauss() {
                    let back = from + (to - from) * point;
                    let kernel = (to - from) * weight * (-rate * back).exp();
                    let basis = lagrange((end - back) / h);
                    for j in 0..S {
                        result.input[k][j] += kernel * basis[j];
                    }
                }
                from = to;
                width *= 2.0;
            }
        }
        result
    }
}

/// Above this many time constants per step a decay is followed by [`QuickDecay`], below by
/// a polynomial.
pub(super) const QUICK_DECAY: f64 = 0.5;

/// A quick decay `z' = -rate z + u` within a step: the particular answer to the polynomial through
/// the inputs, and what decays from the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct QuickDecay {
    /// Particular answer, coefficients in `u`.
    particular: [f64; S],
    start: f64,
    /// Over the step.
    decay: f64,
}

impl QuickDecay {
    /// Over a step of `h` \[s\] from `start`, with the inputs at its points.
    pub fn new(rate: f64, h: f64, start: f64, input: &[f64; S]) -> Self {
        let u = interpolant(input);
        let mut p = [0.0; S];
        for n in (0..S).rev() {
            let above = p.get(n + 1).copied().unwrap_or(0.0);
            p[n] = (u[n] - 2.0 / h * (n + 1) as f64 * above) / rate;
        }
        let mut decay = Self {
            particular: p,
            start: 0.0,
            decay: rate * h,
        };
        decay.start = start - decay.answer(0.0);
        decay
    }

    fn answer(&self, s: f64) -> f64 {
        let u = 2.0 * s - 1.0;
        self.particular.iter().rev().fold(0.0, |sum, c| sum * u + c)
    }

    /// At fraction `s` of the step.
    pub fn at(&self, s: f64) -> f64 {
        self.answer(s) + self.start * (-self.decay * s).exp()
    }
}

#[cfg(test)]
#[path = "linear_tests.rs"]
mod tests;
