//! Curves through readings with outliers: weighted least squares with a Huber loss.

/// Where a quantity was read, the quantity, and its standard error.
pub(crate) type Reading = (f64, f64, f64);

/// Residuals beyond this many standard deviations count in proportion, not by their square.
const CLIP_SIGMAS: f64 = 4.0;

/// A weighted curve fit: values, their covariance's diagonal, robust cost, and the
/// logarithm of the information's determinant.
#[derive(Clone)]
pub struct Curve {
    /// Values.
    pub values: Vec<f64>,
    /// Standard errors.
    pub errors: Vec<f64>,
    /// Robust cost.
    pub cost: f64,
    information: f64,
}

impl Curve {
    /// Minus twice the logarithm of the predictive likelihood of further points, `both` being the fit
    /// to them together with those of `self`: what the latter leave open of the curve is averaged
    /// over (Laplace approximation).
    pub fn predictive_log_loss(&self, both: &Self, scale: f64) -> f64 {
        (both.cost - self.cost) / scale + (both.information - self.information).max(0.0)
    }
}

/// Gauss-Newton with clipped residuals; `f` gives the curve at a point for parameters.
pub fn curve(points: &[Reading], start: &[f64], f: &dyn Fn(f64, &[f64]) -> f64) -> Curve {
    let cost_of = |p: &[f64]| cost(points, &|x| f(x, p));
    let mut values = start.to_vec();
    let mut best = cost_of(&values);
    let n = values.len();
    let mut damping = 1e-3f64;
    let mut errors = vec![f64::INFINITY; n];
    let mut information = f64::NEG_INFINITY;
    for _ in 0..60 {
        let mut normal = nalgebra::DMatrix::<f64>::zeros(n, n);
        let mut right = nalgebra::DVector::zeros(n);
        for &(x, y, sigma) in points {
            let now = f(x, &values);
            let r = (y - now) / sigma;
            let w = if r.abs() > CLIP_SIGMAS {
                CLIP_SIGMAS / r.abs()
            } else {
                1.0
            };
            let slopes: Vec<f64> = (0..n)
                .map(|k| {
                    let mut there = values.clone();
                    let h = 1e-5 * there[k].abs().max(1e-12);
                    there[k] += h;
                    (f(x, &there) - now) / h / sigma
                })
                .collect();
            for i in 0..n {
                right[i] += w * slopes[i] * r;
                for j in 0..n {
                    normal[(i, j)] += w * slopes[i] * slopes[j];
                }
            }
        }
        if let Some(inverse) = normal.clone().try_inverse() {
            errors = (0..n).map(|i| inverse[(i, i)].max(0.0).sqrt()).collect();
        }
        // Prior of the values: their order of magnitude.
        let mut known = normal.clone();
        for i in 0..n {
            known[(i, i)] += values[i].abs().max(1e-12).powi(-2);
        }
        information = known.determinant().abs().max(f64::MIN_POSITIVE).ln();
        let mut damped = normal.clone();
        for i in 0..n {
            damped[(i, i)] *= 1.0 + damping;
            damped[(i, i)] += 1e-300;
        }
        let Some(step) = damped.lu().solve(&right) else {
            break;
        };
        let there: Vec<f64> = values.iter().zip(step.iter()).map(|(v, d)| v + d).collect();
        let now = cost_of(&there);
        if now < best {
            let settled = best - now < 1e-9 * best;
            values = there;
            best = now;
            damping = (0.1 * damping).max(1e-9);
            if settled {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e9 {
                break;
            }
        }
    }
    Curve {
        values,
        errors,
        cost: best,
        information,
    }
}

/// Sum of the clipped squares.
pub fn cost(points: &[Reading], f: &dyn Fn(f64) -> f64) -> f64 {
    let one = |&(x, y, sigma): &Reading| {
        let r = ((y - f(x)) / sigma).abs();
        if r.is_nan() {
            f64::INFINITY
        } else if r > CLIP_SIGMAS {
            CLIP_SIGMAS * (2.0 * r - CLIP_SIGMAS)
        } else {
            r * r
        }
    };
    points.iter().map(one).sum()
}

/// Overdispersion of the readings, at least 1: the mean square of their residuals about the best law.
/// Neighbouring events share the remaining error of the model, so that readings scatter more than
/// their errors say. Outliers count as `CLIP_SIGMAS`.
pub fn scatter(points: &[Reading], unknowns: usize, f: &dyn Fn(f64) -> f64) -> f64 {
    let one =
        |&(x, y, sigma): &Reading| ((y - f(x)) / sigma).powi(2).min(CLIP_SIGMAS * CLIP_SIGMAS);
    let sum: f64 = points.iter().map(one).sum();
    (sum / points.len().saturating_sub(unknowns).max(1) as f64).max(1.0)
}
