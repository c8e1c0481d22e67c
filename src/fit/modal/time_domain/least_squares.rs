//! The rational model by least squares in the time domain: poles common to all readings, residues of
//! each reading, a static residual for the modes above the band, and for every stretch the free decay
//! with which it begins.
//!
//! `x(t) = sum_r A_r y_r(t) + R u(t) + sum_r (c_r cos + s_r sin) exp(-zeta_r w_r t) + offset`. In the
//! frequency domain this is the fraction expansion of a transfer function plus its leakage; nothing
//! is windowed, so no damping is overestimated. For given poles it is linear (variable projection;
//! G. Golub, V. Pereyra, Inverse Problems 19 (2003) R1); poles follow by Levenberg-Marquardt.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data::{Data, Stretch};
use super::kernel::{Columns, Pole};
use super::normal::{BLOCK_ROWS, RIDGE, Scaled, all_normal, fill_linear};
pub use super::normal::{Linear, Setup};

/// Largest step of a logarithm of a frequency, and of a damping.
const MAX_STEPS: [f64; 2] = [0.15, 1.0];
/// Bounds of a damping ratio.
const ZETA_BOUNDS: (f64, f64) = (1e-6, 0.95);

/// Poles with what belongs to them.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The poles.
    pub poles: Vec<Pole>,
    /// Linear unknowns.
    pub linear: Linear,
}

/// Unknowns of a refined solution with their covariance.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// Covariance of `ln w`, `ln zeta` of each mode, the skew if free, then residues and static residual of
    /// each reading. Units of the unknowns.
    pub matrix: DMatrix<f64>,
    /// Where the residues of each reading begin.
    pub shared_at: [Option<usize>; 2],
}

/// The linear unknowns for given poles; `None` if the equations are singular.
#[must_use]
pub fn solve_linear(setup: &Setup<'_>, data: &Data) -> Option<Linear> {
    let all = all_normal(setup, data, None)?;
    let shared = setup.shared();
    let mut linear = Linear {
        shared: [None, None],
        locals: vec![[None, None]; data.stretches.len()],
        squares: [0.0; 2],
        rows: [0; 2],
    };
    for c in 0..2 {
        let mut sum = DMatrix::zeros(shared + 1, shared + 1);
        for (own, rows) in all.iter().filter_map(|a| a[c].as_ref()) {
            sum += &own.reduced;
            linear.rows[c] += rows;
        }
        if linear.rows[c] == 0 {
            continue;
        }
        let matrix = sum.view((0, 0), (shared, shared)).into_owned();
        let right = sum.view((0, shared), (shared, 1)).into_owned();
        let found = Scaled::new(&matrix, RIDGE)?.solve(&right);
        let explained = (right.transpose() * &found)[(0, 0)];
        linear.squares[c] = (sum[(shared, shared)] - explained).max(f64::MIN_POSITIVE);
        let found = found.column(0).into_owned();
        for (locals, own) in linear.locals.iter_mut().zip(&all) {
            if let Some((own, _)) = &own[c] {
                let target = own.follow.column(shared);
                locals[c] = Some(target - own.follow.columns(0, shared) * &found);
            }
        }
        linear.shared[c] = Some(found);
    }
    let known = linear.shared.iter().flatten().flat_map(|s| s.iter());
    (linear.rows != [0, 0] && known.into_iter().all(|v| v.is_finite())).then_some(linear)
}

/// Matrix and right-hand side, and where each reading's shared unknowns begin.
type MovedNormal = (DMatrix<f64>, DVector<f64>, [Option<usize>; 2]);

/// Normal equations of poles, skew and shared unknowns, and where each reading's begin.
fn moved_normal(
    setup: &Setup<'_>,
    data: &Data,
    linear: &Linear,
    sigma: [f64; 2],
    free_skew: bool,
) -> Option<MovedNormal> {
    let all = all_normal(setup, data, Some(linear))?;
    let modes = setup.poles.len();
    let (given, shared) = (2 * modes + 1, setup.shared());
    let moved = 2 * modes + usize::from(free_skew);
    let mut size = moved;
    let mut shared_at = [None, None];
    for (at, rows) in shared_at.iter_mut().zip(linear.rows) {
        if rows > 0 {
            *at = Some(size);
            size += shared;
        }
    }
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = DVector::zeros(size);
    for (c, at) in shared_at.iter().enumerate() {
        let Some(at) = *at else { continue };
        let weight = 1.0 / (sigma[c] * sigma[c]);
        // From the columns of the reduced equations to those of the whole.
        let places: Vec<(usize, usize)> = (0..moved)
            .map(|i| (i, i))
            .chain((0..shared).map(|i| (given + i, at + i)))
            .collect();
        for own in all.iter().filter_map(|a| a[c].as_ref()).map(|(own, _)| own) {
            let target = own.reduced.ncols() - 1;
            for &(i, to_i) in &places {
                right[to_i] += weight * own.reduced[(i, target)];
                for &(j, to_j) in &places {
                    matrix[(to_i, to_j)] += weight * own.reduced[(i, j)];
                }
            }
        }
    }
    Some((matrix, right, shared_at))
}

/// Cost of a linear fit at given noise.
fn cost(linear: &Linear, sigma: [f64; 2]) -> f64 {
    (0..2)
        .filter(|&c| linear.rows[c] > 0)
        .map(|c| linear.squares[c] / (sigma[c] * sigma[c]))
        .sum()
}

/// Root mean square residual of each reading \[m\].
#[must_use]
pub fn sigma_of(linear: &Linear) -> [f64; 2] {
    [0, 1].map(|c: usize| {
        (linear.squares[c] / linear.rows[c].max(1) as f64)
            .sqrt()
            .max(f64::MIN_POSITIVE)
    })
}

/// Log-likelihood that `better` has more than `worse`, each with its own noise.
#[must_use]
pub fn gain(worse: &Linear, better: &Linear) -> f64 {
    (0..2)
        .filter(|&c| worse.rows[c] > 0 && better.rows[c] > 0)
        .map(|c| 0.5 * worse.rows[c] as f64 * (worse.squares[c] / better.squares[c]).ln())
        .sum()
}

/// When a refinement ends.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Iterations at most.
    pub iterations: usize,
    /// Gain of an iteration below which no further one is made, as a sum of squares in units of the
    /// noise. 1 is a parameter moved by one standard error.
    pub least_gain: f64,
}

/// Moves poles, and the skew if it is free, to the least squares. Data keep the skew found.
///
/// Returns `None` if the equations are singular or `cancelled` says so.
pub fn refine(
    data: &mut Data,
    start: &[Pole],
    film_shares: &[f64],
    free_skew: bool,
    effort: Effort,
    cancelled: &dyn Fn() -> bool,
) -> Option<Solution> {
    let mut poles = start.to_vec();
    let mut linear = solve_linear(
        &Setup {
            poles: &poles,
            film_shares,
        },
        data,
    )?;
    let mut damping = 1e-3;
    for _ in 0..effort.iterations {
        if cancelled() {
            return None;
        }
        let setup = Setup {
            poles: &poles,
            film_shares,
        };
        let sigma = sigma_of(&linear);
        let (matrix, right, _) = moved_normal(&setup, data, &linear, sigma, free_skew)?;
        let before = cost(&linear, sigma);
        let mut accepted = None;
        for _ in 0..8 {
            let mut damped = matrix.clone();
            for i in 0..2 * poles.len() + usize::from(free_skew) {
                damped[(i, i)] *= 1.0 + damping;
            }
            let right = DMatrix::from_column_slice(right.len(), 1, right.as_slice());
            let step = Scaled::new(&damped, RIDGE)?.solve(&right);
            let trial = stepped(&poles, &step);
            let old_skew = data.skew;
            if free_skew {
                data.skew += step[(2 * poles.len(), 0)].clamp(-data.interval, data.interval);
                data.refresh_input();
            }
            let found = solve_linear(
                &Setup {
                    poles: &trial,
                    film_shares,
                },
                data,
            );
            if let Some(found) = found.filter(|f| cost(f, sigma) < before) {
                damping = (0.2 * damping).max(1e-9);
                accepted = Some((trial, found));
                break;
            }
            if free_skew {
                data.skew = old_skew;
                data.refresh_input();
            }
            damping = (damping * 8.0).max(1e-4);
        }
        let Some((trial, found)) = accepted else {
            break;
        };
        let gained = before - cost(&found, sigma);
        (poles, linear) = (trial, found);
        if gained < effort.least_gain {
            break;
        }
    }
    Some(Solution { poles, linear })
}

fn stepped(poles: &[Pole], step: &DMatrix<f64>) -> Vec<Pole> {
    let own = poles.iter().enumerate().map(|(r, pole)| Pole {
        omega: pole.omega * step[(2 * r, 0)].clamp(-MAX_STEPS[0], MAX_STEPS[0]).exp(),
        zeta: (pole.zeta
            * step[(2 * r + 1, 0)]
                .clamp(-MAX_STEPS[1], MAX_STEPS[1])
                .exp())
        .clamp(ZETA_BOUNDS.0, ZETA_BOUNDS.1),
    });
    own.collect()
}

/// Covariance at a solution, by its own residual.
#[must_use]
pub fn covariance(
    data: &Data,
    solution: &Solution,
    film_shares: &[f64],
    free_skew: bool,
) -> Option<Covariance> {
    let setup = Setup {
        poles: &solution.poles,
        film_shares,
    };
    let linear = &solution.linear;
    let (matrix, _, shared_at) = moved_normal(&setup, data, linear, sigma_of(linear), free_skew)?;
    let n = matrix.nrows();
    let matrix = Scaled::new(&matrix, RIDGE)?.solve(&DMatrix::identity(n, n));
    Some(Covariance { matrix, shared_at })
}

/// What a solution leaves of each reading, by stretch; NaN where missing.
#[must_use]
pub fn residuals(
    data: &Data,
    solution: &Solution,
    film_shares: &[f64],
) -> Vec<[Option<Vec<f64>>; 2]> {
    let setup = Setup {
        poles: &solution.poles,
        film_shares,
    };
    data.stretches
        .par_iter()
        .zip(&solution.linear.locals)
        .map(|(stretch, locals)| residual(&setup, stretch, locals, &solution.linear.shared))
        .collect()
}

fn residual(
    setup: &Setup<'_>,
    stretch: &Stretch,
    locals: &[Option<DVector<f64>>; 2],
    shared: &[Option<DVector<f64>>; 2],
) -> [Option<Vec<f64>>; 2] {
    let count = setup.locals();
    let mut left = stretch.readings.clone();
    let mut oscillators = setup.oscillators(stretch);
    let mut columns = vec![Columns::default(); setup.poles.len()];
    let mut from = 0;
    while from < stretch.samples() {
        let to = (from + BLOCK_ROWS).min(stretch.samples());
        for (oscillator, own) in oscillators.iter_mut().zip(&mut columns) {
            oscillator.fill(stretch, from, to, false, own);
        }
        let mut x = DMatrix::zeros(to - from, count + setup.shared());
        fill_linear(&mut x, &columns, stretch, from, count);
        for (c, left) in left.iter_mut().enumerate() {
            let (Some(left), Some(own), Some(common)) = (left.as_mut(), &locals[c], &shared[c])
            else {
                continue;
            };
            let sum = x.columns(0, count) * own + x.columns(count, setup.shared()) * common;
            for (value, s) in left[from..to].iter_mut().zip(sum.iter()) {
                *value -= s;
            }
        }
        from = to;
    }
    left
}
