//! Normal equations of all segments, and the damped step within the bounds:
//! `(J^T W J + lambda diag) d = -J^T W r` (Levenberg 1944, Marquardt 1963).

use nalgebra::{DMatrix, DVector};

use crate::fit::problem::huber::Huber;
use crate::fit::problem::prior_rows::PriorRow;
use crate::fit::problem::{Problem, Reduced};

/// Largest step of a parameter's coordinate (a factor of e on a logarithm).
const MAX_COORDINATE_STEP: f64 = 1.0;

/// Normal equations of all segments and priors: the matrix `J^T W J` and the gradient `J^T W r`,
/// in coordinates of the unknowns (parameters, then nuisances).
pub fn normal_equations(
    problem: &Problem,
    x: &[f64],
    reduced: &[Option<Reduced>],
    huber: Huber,
) -> (DMatrix<f64>, DVector<f64>) {
    let n = problem.unknowns();
    let mut normal = DMatrix::zeros(n, n);
    let mut gradient = DVector::zeros(n);
    // One after the other, so that rounding is the same on any number of cores.
    for r in reduced.iter().flatten() {
        let (h, g) = (r.s.tr_mul(&r.s), r.s.tr_mul(&r.c));
        for (i, &ci) in r.columns.iter().enumerate() {
            gradient[ci] += g[i];
            for (j, &cj) in r.columns.iter().enumerate() {
                normal[(ci, cj)] += h[(i, j)];
            }
        }
    }
    for row in problem.prior_rows(x) {
        add_row(&mut normal, &mut gradient, &row, row.weight(huber));
    }
    (normal, gradient)
}

/// Adds a row of its own to normal equations, `weight` times.
pub(crate) fn add_row(
    normal: &mut DMatrix<f64>,
    gradient: &mut DVector<f64>,
    row: &PriorRow,
    weight: f64,
) {
    for &(i, a) in &row.slopes {
        gradient[i] += weight * a * row.value;
        for &(j, b) in &row.slopes {
            normal[(i, j)] += weight * a * b;
        }
    }
}

/// Damped step within the bounds. A parameter that would leave them stops at its bound, one that
/// would move far goes part of the way; the step of the others is solved for again.
pub(super) fn bounded_step(
    problem: &Problem,
    x: &[f64],
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
    locked: &[usize],
) -> Option<Vec<f64>> {
    let n = x.len();
    let parameters = problem.space.len();
    let mut fixed = vec![false; n];
    locked.iter().for_each(|&i| fixed[i] = true);
    let mut step = vec![0.0; n];
    // Each round can only fix more unknowns.
    for _ in 0..=parameters {
        let free: Vec<usize> = (0..n).filter(|&i| !fixed[i]).collect();
        let k = free.len();
        let mut a = DMatrix::from_fn(k, k, |i, j| normal[(free[i], free[j])]);
        let mut b = DVector::from_fn(k, |i, _| -gradient[free[i]]);
        for (i, _) in free.iter().enumerate() {
            // The fixed unknowns' steps move to the right-hand side.
            for j in (0..n).filter(|&j| fixed[j]) {
                b[i] -= normal[(free[i], j)] * step[j];
            }
        }
        for i in 0..k {
            a[(i, i)] += damping * a[(i, i)] + 1e-9;
        }
        let solved = a.cholesky()?.solve(&b);
        let mut violated = false;
        for (i, &at) in free.iter().enumerate() {
            let mut d = solved[i];
            if at < parameters {
                let entry = &problem.space.entries[at];
                let near = d.clamp(-MAX_COORDINATE_STEP, MAX_COORDINATE_STEP);
                let bounded = (x[at] + near).clamp(entry.low, entry.high) - x[at];
                if bounded != d {
                    fixed[at] = true;
                    violated = true;
                    d = bounded;
                }
            }
            step[at] = d;
        }
        if !violated {
            break;
        }
    }
    step.iter().all(|d| d.is_finite()).then_some(step)
}
