//! One oscillator sampled: its response to the input, its free decay, and what both owe to its
//! frequency and damping.
//!
//! `y'' + 2 zeta w y' + w^2 y = w^2 u` is `z' = lambda z + u`, `y = w^2 Im(z) / w_d`, with
//! `lambda = -zeta w + i w_d`. Responses are scaled by `w^2`, so that `y = u` in slow motion.

use realfft::num_complex::Complex;

use super::data::Stretch;
use super::input::{GAUSS, MOMENTS, legendre};

/// Numbers of an oscillator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pole {
    /// Undamped angular frequency [rad/s].
    pub omega: f64,
    /// Damping ratio, below 1.
    pub zeta: f64,
}

impl Pole {
    /// `lambda`.
    #[must_use]
    pub fn lambda(&self) -> Complex<f64> {
        let damped = (1.0 - self.zeta * self.zeta).max(1e-12).sqrt();
        Complex::new(-self.zeta * self.omega, self.omega * damped)
    }

    /// Derivatives of `lambda` by `ln w` and by `ln zeta`.
    fn slopes(&self) -> [Complex<f64>; 2] {
        let damped = (1.0 - self.zeta * self.zeta).max(1e-12).sqrt();
        let by_zeta = Complex::new(-self.zeta, -self.zeta * self.zeta / damped) * self.omega;
        [self.lambda(), by_zeta]
    }

    /// Response at frequency `f` \[Hz\] to a unit input, 1 at rest.
    #[must_use]
    pub fn receptance(&self, f: f64) -> Complex<f64> {
        let s = std::f64::consts::TAU * f;
        let w2 = self.omega * self.omega;
        Complex::from(w2) / Complex::new(w2 - s * s, 2.0 * self.zeta * self.omega * s)
    }
}

/// The propagation over one interval.
#[derive(Debug, Clone, Copy)]
struct Step {
    h: f64,
    factor: Complex<f64>,
    weights: [Complex<f64>; MOMENTS],
    /// Derivatives of the weights by `lambda`.
    slopes: [Complex<f64>; MOMENTS],
}

impl Step {
    fn new(lambda: Complex<f64>, h: f64) -> Self {
        let mut weights = [Complex::from(0.0); MOMENTS];
        let mut slopes = weights;
        for (x, w) in GAUSS {
            let left = 0.5 * h * (1.0 - x);
            let kernel = (lambda * left).exp() * (0.5 * w);
            for (j, p) in legendre(x).into_iter().enumerate() {
                let scale = (2 * j + 1) as f64 * p;
                weights[j] += kernel * scale;
                slopes[j] += kernel * (scale * left);
            }
        }
        Self {
            h,
            factor: (lambda * h).exp(),
            weights,
            slopes,
        }
    }
}

/// Columns of one oscillator over a block of samples.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// Response to the input, scaled.
    pub response: Vec<f64>,
    /// Free decay, cosine and sine.
    pub decay: [Vec<f64>; 2],
    /// Derivatives of the response by `ln w` and `ln zeta`.
    pub response_slopes: [Vec<f64>; 2],
    /// The same of the decays: `[by][cosine or sine]`.
    pub decay_slopes: [[Vec<f64>; 2]; 2],
    /// Rate of the response.
    pub rate: Vec<f64>,
}

/// An oscillator that goes along a stretch.
#[derive(Debug, Clone)]
pub struct Oscillator {
    pole: Pole,
    lambda: Complex<f64>,
    slopes: [Complex<f64>; 2],
    /// Film force per unit of input that acts with the same residue [1/N].
    film_share: f64,
    step: Step,
    z: Complex<f64>,
    dz: Complex<f64>,
    decay: Complex<f64>,
    time: f64,
}

impl Oscillator {
    /// At rest at the stretch's first sample.
    #[must_use]
    pub fn new(pole: Pole, film_share: f64, stretch: &Stretch) -> Self {
        let lambda = pole.lambda();
        Self {
            pole,
            lambda,
            slopes: pole.slopes(),
            film_share,
            step: Step::new(lambda, stretch.intervals.after(0)),
            z: Complex::from(0.0),
            dz: Complex::from(0.0),
            decay: Complex::from(1.0),
            time: 0.0,
        }
    }

    fn advance(&mut self, stretch: &Stretch, i: usize) {
        let h = stretch.intervals.after(i);
        if (h / self.step.h - 1.0).abs() > 1e-9 {
            self.step = Step::new(self.lambda, h);
        }
        let step = &self.step;
        let (mut add, mut slope) = (Complex::from(0.0), Complex::from(0.0));
        if let Some(moments) = stretch.moments.get(i) {
            for ((m, w), s) in moments.iter().zip(&step.weights).zip(&step.slopes) {
                add += w * *m;
                slope += s * *m;
            }
        }
        if let Some(moments) = stretch.film.get(i).filter(|_| self.film_share != 0.0) {
            for ((m, w), s) in moments.iter().zip(&step.weights).zip(&step.slopes) {
                add += w * (*m * self.film_share);
                slope += s * (*m * self.film_share);
            }
        }
        // d/dlambda of exp(lambda h) z + add.
        self.dz = step.factor * (self.dz + self.z * h) + slope;
        self.z = step.factor * self.z + add;
        self.decay *= step.factor;
        self.time += h;
    }

    /// Columns of samples `from..to`; each call goes on where the last one ended. Derivatives only
    /// where `slopes` is set.
    pub fn fill(
        &mut self,
        stretch: &Stretch,
        from: usize,
        to: usize,
        slopes: bool,
        out: &mut Columns,
    ) {
        let w2 = self.pole.omega * self.pole.omega;
        let damped = self.lambda.im;
        let scale = w2 / damped;
        out.response.clear();
        out.rate.clear();
        out.decay.iter_mut().for_each(Vec::clear);
        out.response_slopes.iter_mut().for_each(Vec::clear);
        out.decay_slopes.iter_mut().flatten().for_each(Vec::clear);
        for i in from..to {
            let y = scale * self.z.im;
            out.response.push(y);
            out.decay[0].push(self.decay.re);
            out.decay[1].push(self.decay.im);
            if slopes {
                out.rate.push(scale * (self.lambda * self.z).im);
                for (k, by) in self.slopes.iter().enumerate() {
                    // The scale w^2 / w_d depends on both, too.
                    let own = if k == 0 { 2.0 } else { 0.0 } - by.im / damped;
                    out.response_slopes[k].push(scale * (self.dz * by).im + own * y);
                    let decay = self.decay * by * self.time;
                    out.decay_slopes[k][0].push(decay.re);
                    out.decay_slopes[k][1].push(decay.im);
                }
            }
            self.advance(stretch, i);
        }
    }
}
