//! Coloured noise: a white part and a part with memory.
//!
//! The noise of a reading is white noise plus a first-order process (Ornstein-Uhlenbeck). Residuals
//! are whitened by the innovations of a scalar Kalman filter. Least squares then weighs slow and
//! fast misfits as the noise does, and the mean square of the residuals is 1 if the model is
//! complete.

/// Colour of a reading's noise, whose standard deviation is given elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// Share of the variance that has a memory, 0 to 1.
    pub share: f64,
    /// Correlation of that part from one sample to the next, 0 to 1.
    pub keep: f64,
}

impl Colour {
    /// No memory.
    pub const WHITE: Self = Self {
        share: 0.0,
        keep: 0.0,
    };

    /// Turns residuals of consecutive samples, in units of the noise, into as many that
    /// are independent and of variance 1 if the residuals are noise of this colour.
    pub fn whiten(&self, residuals: &mut [f64]) {
        if self.share <= 0.0 {
            return;
        }
        let white = (1.0 - self.share).max(1e-6);
        let mut expected = 0.0;
        let mut variance = self.share;
        for r in residuals {
            let innovation = *r - expected;
            let total = variance + white;
            let gain = variance / total;
            expected = self.keep * (expected + gain * innovation);
            variance = self.keep * self.keep * (1.0 - gain) * variance
                + (1.0 - self.keep * self.keep) * self.share;
            *r = innovation / total.sqrt();
        }
    }

    /// Sum of the logarithms of the innovations' variances over `count` samples.
    pub fn log_determinant(&self, count: usize) -> f64 {
        let white = (1.0 - self.share).max(1e-6);
        let mut variance = self.share;
        let mut sum = 0.0;
        for _ in 0..count {
            let total = variance + white;
            sum += total.ln();
            variance = self.keep * self.keep * (1.0 - variance / total) * variance
                + (1.0 - self.keep * self.keep) * self.share;
        }
        sum
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
        };
        let n = 6;
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            let apart = i.abs_diff(j) as i32;
            0.4 * 0.9f64.powi(apart) + if i == j { 0.6 } else { 0.0 }
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
