//! Coloured noise: a white part, a part with memory, and a zero that walks.
//!
//! The noise of a reading is white noise, a first-order process (Ornstein-Uhlenbeck) and a random walk
//! of the zero. Residuals are whitened by the innovations of a Kalman filter of the last two. Least
//! squares then weighs slow and fast misfits as the noise does, and the mean square of the residuals
//! is 1 if the model is complete.

/// Colour of a reading's noise. The standard deviation of the white part and the part with memory
/// together is given elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// Share of the variance that has a memory, 0 to 1.
    pub share: f64,
    /// Correlation of that part from one sample to the next, 0 to 1.
    pub keep: f64,
    /// Variance by which the zero walks from one sample to the next, in units of that of the other
    /// parts.
    pub walk: f64,
    /// Variance of the zero at the start of a segment, in the same units.
    pub level: f64,
}

/// What the filter expects of the part with memory and of the zero, with its covariance.
struct Expectation {
    remembered: f64,
    zero: f64,
    /// Variance of the first, covariance, variance of the second.
    covariance: [f64; 3],
}

impl Expectation {
    fn new(colour: &Colour) -> Self {
        Self {
            remembered: 0.0,
            zero: 0.0,
            covariance: [colour.share, 0.0, colour.level],
        }
    }

    /// Goes on by one sample with `residual`; the innovation and its variance.
    fn advance(&mut self, colour: &Colour, residual: f64) -> (f64, f64) {
        let Colour {
            share, keep, walk, ..
        } = *colour;
        let [a, b, c] = self.covariance;
        let white = (1.0 - share).max(LEAST_WHITE_SHARE);
        let total = a + 2.0 * b + c + white;
        let gains = ((a + b) / total, (b + c) / total);
        let innovation = residual - self.remembered - self.zero;
        self.remembered = keep * (self.remembered + gains.0 * innovation);
        self.zero += gains.1 * innovation;
        let a = a - gains.0 * gains.0 * total;
        let b = b - gains.0 * gains.1 * total;
        let c = c - gains.1 * gains.1 * total;
        self.covariance = [
            keep * keep * a + (1.0 - keep * keep) * share,
            keep * b,
            c + walk,
        ];
        (innovation, total)
    }
}

/// Least share of white noise, so that the filter stays regular.
const LEAST_WHITE_SHARE: f64 = 1e-6;

impl Colour {
    /// No memory.
    pub const WHITE: Self = Self {
        share: 0.0,
        keep: 0.0,
        walk: 0.0,
        level: 0.0,
    };

    /// Noise of which `share` has a memory and keeps `keep` of itself from sample to sample.
    pub fn with_memory(share: f64, keep: f64) -> Self {
        Self {
            share,
            keep,
            ..Self::WHITE
        }
    }

    /// Turns residuals of consecutive samples, in units of the noise, into as many that
    /// are independent and of variance 1 if the residuals are noise of this colour.
    pub fn whiten(&self, residuals: &mut [f64]) {
        if self.share <= 0.0 && self.walk <= 0.0 && self.level <= 0.0 {
            return;
        }
        let mut expected = Expectation::new(self);
        for r in residuals {
            let (innovation, variance) = expected.advance(self, *r);
            *r = innovation / variance.sqrt();
        }
    }

    /// Sum of the logarithms of the innovations' variances over `count` samples.
    pub fn log_determinant(&self, count: usize) -> f64 {
        let mut expected = Expectation::new(self);
        let variances = (0..count).map(|_| expected.advance(self, 0.0).1);
        variances.map(f64::ln).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::coloured_noise::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn whitening_is_the_inverse_root_of_the_covariance() {
        let colour = Colour {
            share: 0.4,
            keep: 0.9,
            walk: 0.03,
            level: 0.5,
        };
        let n = 6;
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            let apart = i.abs_diff(j) as i32;
            let walked = 0.5 + 0.03 * i.min(j) as f64;
            walked + 0.4 * 0.9f64.powi(apart) + if i == j { 0.6 } else { 0.0 }
        });
        let r = [1.0, -0.5, 2.0, 0.3, 0.0, -1.0];
        let mut w = r;
        colour.whiten(&mut w);
        let whole = DVector::from_row_slice(&r);
        let inverse = covariance.clone().try_inverse().unwrap();
        let expected = (whole.transpose() * inverse * &whole)[(0, 0)];
        let sum: f64 = w.iter().map(|w| w * w).sum();
        assert!((sum / expected - 1.0).abs() < 1e-12);
        let logarithm = covariance.determinant().ln();
        assert!((colour.log_determinant(n) - logarithm).abs() < 1e-12);
    }
}
