//! Huber's loss: quadratic up to a threshold, linear beyond, so that a few outliers do not
//! dominate the fit.

/// Huber's loss with a threshold in units of the standard deviation (Huber 1964).
///
/// # Examples
/// ```
/// use impactscope::fit::problem::huber::Huber;
///
/// let loss = Huber(3.0);
/// assert_eq!(loss.cost(2.0), 4.0);
/// // Beyond the threshold it grows linearly: 3 (2 * 10 - 3).
/// assert_eq!(loss.cost(10.0), 51.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Huber(pub f64);

impl Huber {
    /// Contribution of a residual to the cost: `r^2` below the threshold.
    pub fn cost(self, r: f64) -> f64 {
        let a = r.abs();
        if a <= self.0 {
            a * a
        } else if a.is_finite() {
            self.0 * (2.0 * a - self.0)
        } else {
            f64::INFINITY
        }
    }

    /// Square root of the weight of a residual in least squares.
    pub fn root_weight(self, r: f64) -> f64 {
        let a = r.abs();
        if a <= self.0 {
            1.0
        } else {
            (self.0 / a).sqrt()
        }
    }

    /// Sum of the contributions.
    pub fn total(self, residuals: &[f64]) -> f64 {
        residuals.iter().map(|r| self.cost(*r)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::huber::*;

    #[test]
    fn it_is_smooth_at_the_threshold() {
        let huber = Huber(3.0);
        assert!((huber.cost(3.0 - 1e-9) - huber.cost(3.0 + 1e-9)).abs() < 1e-7);
        assert_eq!(huber.root_weight(1.0), 1.0);
        // Weighted squares have the slope of the loss.
        let slope = (huber.cost(10.0 + 1e-6) - huber.cost(10.0 - 1e-6)) / 2e-6;
        assert!((2.0 * 10.0 * huber.root_weight(10.0).powi(2) / slope - 1.0).abs() < 1e-8);
    }
}
