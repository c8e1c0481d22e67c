//! Standard errors where those of a linearized fit are too small.
//!
//! The linearized errors hold if the model does. If it is slightly wrong, each segment pulls to
//! values of its own, and the gradients of the segments' costs scatter by more than the noise
//! explains. The covariance is then the sandwich `H^-1 S H^-1`, with `H = J^T J` and S the sum of
//! the outer products of the gradients (Huber 1967; White 1982; segments as clusters: Liang and
//! Zeger 1986).
//!
//! A faint added mode is a case of its own. Each segment leaves the initial state of every mode
//! free, so a faint mode takes part of its motion from the noise. `J^T J` counts that part as
//! information, though it has none: the second derivatives of the residuals, which `J^T J` omits,
//! cancel it (incidental parameters: Neyman and Scott 1948). So for added modes H is the observed
//! curvature of the cost, from differences of gradients, and S is `J^T J`, by which the gradient
//! scatters.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::normal_inverse::inverse;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::{Problem, Reduced};
use crate::fit::solve::normal_equations::normal_equations;
use crate::fit::solve::point::{Point, settle, settle_near};
use crate::fit::thresholds::{MIN_BOUND_ROOM_SIGMAS, MIN_CURVATURE_SHARE, UNDETERMINED_VARIANCE};
use crate::model::Model;
use crate::sim::SimError;

/// Rounds in which the segments' own unknowns follow a step; they begin at their best.
const STEP_SETTLE_ROUNDS: usize = 2;

/// Indices of the unknowns of `space` that belong to a mode added by an effect.
fn added_mode_unknowns(space: &Space, x: &[f64]) -> Vec<usize> {
    let model = space.model(x);
    let modes = |model: &Model| model.structure_with_effects().modes.len();
    let all = modes(&model);
    let adds = |id: &str| {
        let mut without = model.clone();
        without.effects.retain(|e| e.spec.id != id);
        modes(&without) < all
    };
    let own = space.entries.iter().enumerate();
    own.filter(|(_, e)| e.id.split_once('.').is_some_and(|(effect, _)| adds(effect)))
        .map(|(i, _)| i)
        .collect()
}

/// Gradients of the segments' costs, each with the indices of its unknowns.
pub(crate) fn segment_gradients(
    reduced: &[Option<Reduced>],
) -> impl Iterator<Item = (&[usize], DVector<f64>)> {
    let segments = reduced.iter().flatten();
    segments.map(|r| (&r.columns[..], r.s.tr_mul(&r.c)))
}

/// Factor, at least 1, by which the sandwich widens each unknown's error. `linearized` is the
/// inverse of `J^T J`; errors count as widened by `chi2` already where that is above 1.
pub(crate) fn sandwich_inflation<'a>(
    linearized: &DMatrix<f64>,
    slopes: impl Iterator<Item = (&'a [usize], DVector<f64>)>,
    chi2: f64,
) -> Vec<f64> {
    let n = linearized.nrows();
    let mut square = vec![0.0; n];
    for (columns, slope) in slopes {
        for (i, square) in square.iter_mut().enumerate() {
            let own = columns.iter().zip(slope.iter());
            let asks: f64 = own.map(|(&c, g)| linearized[(i, c)] * g).sum();
            *square += asks * asks;
        }
    }
    let wider = |i: usize| {
        let linear = linearized[(i, i)] * chi2.max(1.0);
        (square[i] / linear.max(f64::MIN_POSITIVE)).sqrt().max(1.0)
    };
    (0..n).map(wider).collect()
}

/// `covariance` of all unknowns (coordinates) at `point`, with the observed curvature in place of
/// `J^T J` for the parameters of added modes; unchanged without any.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub(crate) fn with_observed_curvature(
    problem: &Problem,
    point: &Point,
    huber: Huber,
    covariance: DMatrix<f64>,
) -> Result<DMatrix<f64>, SimError> {
    let mut own = added_mode_unknowns(&problem.space, &point.x);
    own.retain(|&i| covariance[(i, i)] < UNDETERMINED_VARIANCE);
    if own.is_empty() {
        return Ok(covariance);
    }
    let missing = second_derivatives(problem, point, &own, huber)?;
    if !missing.iter().all(|v| v.is_finite()) {
        return Ok(covariance);
    }
    let k = own.len();
    let linear = DMatrix::from_fn(k, k, |i, j| covariance[(own[i], own[j])]);
    let Some(root) = linear.clone().cholesky().map(|c| c.l()) else {
        return Ok(covariance);
    };
    // In these coordinates the curvature of the linearized fit is 1 in every direction.
    let curvature = DMatrix::identity(k, k) + root.tr_mul(&(missing * &root));
    let eigen = SymmetricEigen::new(0.5 * (&curvature + curvature.transpose()));
    let wider = eigen
        .eigenvalues
        .map(|v| v.clamp(MIN_CURVATURE_SHARE, 1.0).powi(-2));
    let axes = &root * &eigen.eigenvectors;
    let found = &axes * DMatrix::from_diagonal(&wider) * axes.transpose();
    // The other unknowns follow by their regression on these.
    let all = covariance.nrows();
    let regression = DMatrix::from_fn(all, k, |i, j| covariance[(i, own[j])]) * inverse(&linear);
    Ok(covariance + &regression * (found - linear) * regression.transpose())
}

/// Observed curvature of the cost minus `J^T J` in the unknowns `own`, all other parameters held
/// and the segments' own unknowns at their best.
fn second_derivatives(
    problem: &Problem,
    point: &Point,
    own: &[usize],
    huber: Huber,
) -> Result<DMatrix<f64>, SimError> {
    let parameters = problem.space.len();
    let mut part = problem.clone();
    part.space = problem.space.only(own, &point.x);
    let from = |x: &[f64]| {
        let mut short: Vec<f64> = own.iter().map(|&i| x[i]).collect();
        short.extend_from_slice(&x[parameters..]);
        short
    };
    let x = from(&point.x);
    let k = own.len();
    let others: Vec<usize> = (k..x.len()).collect();
    let linearized =
        |there: &Point| part.linearize(&there.x, &there.segments, &there.used, huber, &others);
    let middle = settle(
        &part,
        &x,
        &point.segments,
        &point.used,
        huber,
        STEP_SETTLE_ROUNDS,
    )?;
    let reduced = linearized(&middle)?;
    let (linear, _) = normal_equations(&part, &x, &reduced, huber);
    let mut out = DMatrix::zeros(k, k);
    let mut at_bounds = Vec::new();
    for j in 0..k {
        let wanted = 1.0 / linear[(j, j)].max(f64::MIN_POSITIVE).sqrt();
        let entry = &part.space.entries[j];
        let room = (entry.high - x[j]).min(x[j] - entry.low);
        // Beyond its bounds there may be no model, and at them the cost has no minimum.
        if room < MIN_BOUND_ROOM_SIGMAS * wanted {
            at_bounds.push(j);
            continue;
        }
        let step = wanted.min(room);
        let at = |step: f64| -> Result<DVector<f64>, SimError> {
            let mut there = x.clone();
            there[j] += step;
            let there = settle_near(
                &part,
                &there,
                (&middle, &reduced),
                huber,
                STEP_SETTLE_ROUNDS,
            )?;
            let reduced = linearized(&there)?;
            Ok(normal_equations(&part, &there.x, &reduced, huber).1)
        };
        let column = (at(step)? - at(-step)?) / (2.0 * step);
        for i in 0..k {
            out[(i, j)] = column[i] - linear[(i, j)];
        }
    }
    // Their mixed derivatives are known from the steps of the others.
    for j in at_bounds {
        for i in 0..k {
            out[(i, j)] = out[(j, i)];
        }
    }
    Ok(0.5 * (&out + out.transpose()))
}

#[cfg(test)]
mod tests {
    use super::super::sandwich_covariance::*;
    use crate::fit::tests::{made, options, paper, part, run};
    use crate::model::effects::{ActiveEffect, find};

    #[test]
    fn segments_that_disagree_widen_the_errors() {
        // Four segments that each know the second unknown to 0.1, and pull 0.3 up or
        // down: their mean scatters by 0.15, not by the 0.05 that each implies.
        let linearized = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0 / 400.0]));
        let wider = |asked: f64, chi2: f64| {
            let slope = move |sign: f64| DVector::from_element(1, sign * 100.0 * asked);
            let slopes = [1.0, -1.0, 1.0, -1.0].map(slope);
            let all = slopes.into_iter().map(|s| (&[1usize][..], s));
            sandwich_inflation(&linearized, all, chi2)
        };
        let close = |a: &[f64], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(&wider(0.3, 1.0), [1.0, 3.0]));
        // As much as their noise allows leaves the errors unchanged, and so does less.
        assert!(close(&wider(0.1, 1.0), [1.0, 1.0]));
        assert!(close(&wider(0.0, 0.5), [1.0, 1.0]));
        // What the misfit has widened already is not widened again.
        assert!(close(&wider(0.3, 9.0), [1.0, 1.0]));
    }

    /// The paper's device with a further mode that is driven so much.
    fn ringing(phi: f64) -> Model {
        let mut model = paper();
        let mut mode = ActiveEffect::new(find("extra_mode").unwrap());
        mode.set("f", 9e3);
        mode.set("zeta", 0.02);
        for id in ["phi_c", "phi_p", "phi_d"] {
            mode.set(id, phi);
        }
        model.effects.push(mode);
        model
    }

    /// Root mean square of the frequency's error in its standard errors over draws of noise.
    fn scatter(phi: f64) -> f64 {
        const DRAWS: u64 = 16;
        let truth = ringing(phi);
        let free = options(&["extra_mode.f"]);
        let square = |seed: u64| {
            let parts = [part(made(&truth, "square:100Hz:2V", 0.04, 10 + seed))];
            let found = run(&truth, &parts, &free).unwrap();
            let p = &found.parameters[0];
            ((p.value - 9e3) / p.std_error).powi(2)
        };
        ((0..DRAWS).map(square).sum::<f64>() / DRAWS as f64).sqrt()
    }

    /// By the linearized fit alone the faint one scatters by 1.7 of its errors; of sixteen
    /// draws the root mean square is known to 0.18.
    #[test]
    fn a_faint_mode_scatters_as_its_standard_errors_say() {
        for phi in [9e3, 6e4] {
            let sigmas = scatter(phi);
            assert!((0.6..1.4).contains(&sigmas), "{phi}: {sigmas:.2}");
        }
    }
}
