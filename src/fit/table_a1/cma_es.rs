//! CMA-ES: minimizes a function of a few parameters that is rough, has steps, or has no derivatives
//! (N. Hansen, The CMA Evolution Strategy: A Tutorial, 2016, with its default constants). Bounded
//! to the unit cube by mirroring.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::model::sensor::gaussian;

/// How long and how wide to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Generations at most.
    pub generations: usize,
    /// First step, as a share of the cube's side.
    pub step: f64,
    /// The search ends when the step has become this share of the cube's side.
    pub least_step: f64,
    /// Seed: the same gives the same result.
    pub seed: u64,
}

/// The best point found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Its coordinates, each from 0 to 1.
    pub point: Vec<f64>,
    /// The function there.
    pub value: f64,
    /// Number of evaluations.
    pub evaluations: usize,
}

/// Minimizes `function` over the unit cube of `start`'s dimension, from `start`. Values that are
/// not finite count as worst. The points of a generation are evaluated on all cores. `go_on` gets
/// the generation and the best so far after each generation, and ends the search by returning
/// `false`.
pub fn minimize(
    start: &[f64],
    search: &Search,
    function: impl Fn(&[f64]) -> f64 + Sync,
    mut go_on: impl FnMut(usize, &Found) -> bool,
) -> Found {
    let n = start.len();
    let finite = |value: f64| if value.is_finite() { value } else { f64::MAX };
    let mut best = Found {
        point: start.iter().map(|&x| mirrored(x)).collect(),
        value: finite(function(start)),
        evaluations: 1,
    };
    if n == 0 {
        return best;
    }
    let dimension = n as f64;
    let offspring = 4 + (3.0 * dimension.ln()).floor() as usize;
    let parents = offspring / 2;
    let raw: Vec<f64> = (0..parents)
        .map(|i| (0.5 * (offspring as f64 + 1.0)).ln() - ((i + 1) as f64).ln())
        .collect();
    let total: f64 = raw.iter().sum();
    let weights: Vec<f64> = raw.iter().map(|w| w / total).collect();
    let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
    // Learning rates of the tutorial's Table 1.
    let c_sigma = (effective + 2.0) / (dimension + effective + 5.0);
    let damping =
        1.0 + 2.0 * (((effective - 1.0) / (dimension + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma;
    let c_c = (4.0 + effective / dimension) / (dimension + 4.0 + 2.0 * effective / dimension);
    let c_1 = 2.0 / ((dimension + 1.3).powi(2) + effective);
    let c_mu = (1.0 - c_1)
        .min(2.0 * (effective - 2.0 + 1.0 / effective) / ((dimension + 2.0).powi(2) + effective));
    let expected =
        dimension.sqrt() * (1.0 - 1.0 / (4.0 * dimension) + 1.0 / (21.0 * dimension * dimension));

    let mut rng = ChaCha8Rng::seed_from_u64(search.seed);
    let mut mean = DVector::from_column_slice(&best.point);
    let mut sigma = search.step;
    let mut covariance = DMatrix::<f64>::identity(n, n);
    let (mut path_sigma, mut path_c) = (DVector::zeros(n), DVector::zeros(n));
    for generation in 0..search.generations {
        let eigen = SymmetricEigen::new(covariance.clone());
        let lengths = eigen.eigenvalues.map(|e| e.max(1e-20).sqrt());
        let shape = &eigen.eigenvectors * DMatrix::from_diagonal(&lengths);
        let draws: Vec<DVector<f64>> = (0..offspring)
            .map(|_| DVector::from_fn(n, |_, _| gaussian(&mut rng)))
            .collect();
        let steps: Vec<DVector<f64>> = draws.iter().map(|z| &shape * z).collect();
        let points: Vec<Vec<f64>> = steps
            .iter()
            .map(|y| (0..n).map(|i| mirrored(mean[i] + sigma * y[i])).collect())
            .collect();
        let values: Vec<f64> = points.par_iter().map(|x| finite(function(x))).collect();
        best.evaluations += offspring;
        let mut order: Vec<usize> = (0..offspring).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        if values[order[0]] < best.value {
            best.value = values[order[0]];
            best.point.clone_from(&points[order[0]]);
        }

        let mut step = DVector::zeros(n);
        for (weight, &i) in weights.iter().zip(&order) {
            step += &steps[i] * *weight;
        }
        mean += &step * sigma;
        mean.apply(|x| *x = mirrored(*x));
        let whitened = &eigen.eigenvectors
            * DMatrix::from_diagonal(&lengths.map(|l| 1.0 / l))
            * eigen.eigenvectors.transpose()
            * &step;
        path_sigma = &path_sigma * (1.0 - c_sigma)
            + whitened * (c_sigma * (2.0 - c_sigma) * effective).sqrt();
        let grown =
            path_sigma.norm() / (1.0 - (1.0 - c_sigma).powi(2 * (generation as i32 + 1))).sqrt();
        let moving = if grown < (1.4 + 2.0 / (dimension + 1.0)) * expected {
            1.0
        } else {
            0.0
        };
        path_c = &path_c * (1.0 - c_c) + &step * (moving * (c_c * (2.0 - c_c) * effective).sqrt());
        let kept = 1.0 - c_1 - c_mu + (1.0 - moving) * c_1 * c_c * (2.0 - c_c);
        covariance *= kept;
        covariance += &path_c * path_c.transpose() * c_1;
        for (weight, &i) in weights.iter().zip(&order) {
            covariance += &steps[i] * steps[i].transpose() * (c_mu * weight);
        }
        sigma *= ((c_sigma / damping) * (path_sigma.norm() / expected - 1.0)).exp();
        sigma = sigma.min(1.0);
        let widest = sigma * lengths.max();
        if !go_on(generation, &best) || widest < search.least_step || !sigma.is_finite() {
            break;
        }
    }
    best
}

/// Mirrors a coordinate at the walls of the cube.
fn mirrored(x: f64) -> f64 {
    if !x.is_finite() {
        return 0.5;
    }
    let x = x.rem_euclid(2.0);
    if x > 1.0 { 2.0 - x } else { x }
}

#[cfg(test)]
mod tests {
    use super::super::cma_es::*;

    const SEARCH: Search = Search {
        generations: 400,
        step: 0.3,
        least_step: 1e-7,
        seed: 1,
    };

    #[test]
    fn finds_the_bottom_of_a_bent_valley_with_steps() {
        // Rosenbrock's function on [-2, 2] squared with a staircase laid over it.
        let function = |x: &[f64]| {
            let (a, b) = (4.0 * x[0] - 2.0, 4.0 * x[1] - 2.0);
            let smooth = (1.0 - a).powi(2) + 100.0 * (b - a * a).powi(2);
            smooth + 0.01 * (smooth * 10.0).floor().min(100.0)
        };
        let found = minimize(&[0.2, 0.8], &SEARCH, function, |_, _| true);
        assert!(found.value < 1e-6, "{found:?}");
        assert!((4.0 * found.point[0] - 3.0).abs() < 0.01);
        assert_eq!(found, minimize(&[0.2, 0.8], &SEARCH, function, |_, _| true));
    }

    #[test]
    fn finds_a_minimum_at_a_wall_with_undefined_values_beyond_half() {
        let function = |x: &[f64]| {
            if x[1] > 0.5 {
                f64::NAN
            } else {
                x[0] + (x[1] - 0.3).abs()
            }
        };
        let found = minimize(&[0.9, 0.45], &SEARCH, function, |_, _| true);
        assert!(
            found.point[0] < 1e-3 && (found.point[1] - 0.3).abs() < 1e-3,
            "{found:?}"
        );
    }

    #[test]
    fn it_can_be_stopped_and_keeps_the_best() {
        let mut asked = 0;
        let found = minimize(
            &[0.9; 4],
            &SEARCH,
            |x| x.iter().map(|v| v * v).sum(),
            |_, _| {
                asked += 1;
                asked < 3
            },
        );
        assert_eq!(asked, 3);
        assert!(found.value <= 4.0 * 0.81);
    }
}
