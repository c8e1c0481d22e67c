//! Gauss-Newton for curves of few parameters.

use nalgebra::{DMatrix, DVector};

use super::samples::Samples;
use super::thresholds::{CONVERGED_STEP_SIGMAS, MAX_GAUSS_NEWTON_STEPS};

/// Parameters fitted to samples.
#[derive(Debug, Clone)]
pub struct CurveFit {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// Their standard deviations for the samples' error.
    pub sigmas: Vec<f64>,
}

/// Fits the parameters of `curve(parameters, time)` from a start near the solution. `scales` are
/// the changes of each parameter from which derivatives are taken; at most about `most` samples are
/// used, evenly picked over the whole span. `None` if a parameter is not
/// determined or the search runs away.
pub fn fit_curve(
    samples: &Samples<'_>,
    start: &[f64],
    scales: &[f64],
    most: usize,
    curve: impl Fn(&[f64], f64) -> f64,
) -> Option<CurveFit> {
    let n = start.len();
    let mut parameters = start.to_vec();
    for _ in 0..MAX_GAUSS_NEWTON_STEPS {
        let mut normal = DMatrix::<f64>::zeros(n, n);
        let mut right = DVector::<f64>::zeros(n);
        let mut count = 0usize;
        let shifted: Vec<(Vec<f64>, Vec<f64>)> = (0..n)
            .map(|k| {
                let (mut up, mut down) = (parameters.clone(), parameters.clone());
                up[k] += scales[k];
                down[k] -= scales[k];
                (up, down)
            })
            .collect();
        let mut row = vec![0.0; n];
        for i in samples.thinned(most) {
            let t = samples.time[i];
            let off = samples.volts[i] - curve(&parameters, t);
            for (k, (up, down)) in shifted.iter().enumerate() {
                row[k] = 0.5 * (curve(up, t) - curve(down, t));
            }
            for a in 0..n {
                for b in 0..=a {
                    normal[(a, b)] += row[a] * row[b];
                }
                right[a] += row[a] * off;
            }
            count += 1;
        }
        normal.fill_upper_triangle_with_lower_triangle();
        let inverse = normal.cholesky()?.inverse();
        let step = &inverse * right;
        // Thinned samples stand for all.
        let share = count as f64 / samples.len() as f64;
        let sigma = |k: usize| samples.sigma * (inverse[(k, k)] * share).sqrt();
        let small = (0..n).all(|k| step[k].abs() <= CONVERGED_STEP_SIGMAS * sigma(k));
        for k in 0..n {
            parameters[k] += step[k] * scales[k];
        }
        if parameters.iter().any(|p| !p.is_finite()) {
            return None;
        }
        if small {
            let sigmas = (0..n).map(|k| sigma(k) * scales[k]).collect();
            return Some(CurveFit { parameters, sigmas });
        }
    }
    // Rounding can keep the last steps above a very small error; what was found is used, the test
    // of the samples decides.
    let sigmas = scales.iter().map(|s| s * 1e-3).collect();
    Some(CurveFit { parameters, sigmas })
}
