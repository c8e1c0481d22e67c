//! Errors where those of a linearised fit promise too much.
//!
//! They hold where the model does. Where it is a little wrong, each stretch asks for values
//! of its own, and the slopes of the stretches' costs scatter by more than their noise: the
//! values scatter by H^-1 S H^-1, with S the sum of the slopes' squares (Huber 1967; White
//! 1982; by stretches as clusters, Liang and Zeger 1986).
//!
//! A faint mode is a case by itself. Each stretch leaves the beginning of every mode free, so
//! that a faint one takes a part of its swing in each of them from the noise. The linearised
//! fit counts that part as told by the data (J'J grows with it), though it tells nothing: the
//! second derivatives of the residuals, which it leaves out, take it away again (incidental
//! parameters, Neyman and Scott 1948). The cost's own curvature has them: with it as H, and
//! J'J, which is what the slope of the cost scatters by, as S.

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

/// Rounds in which the stretches' own unknowns follow a step: they begin at the best.
const STEP_SETTLE_ROUNDS: usize = 2;

/// The unknowns of `space` that are of a mode which an effect adds to the device.
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

/// Slopes of the stretches' costs, with the unknowns in which they are.
pub(crate) fn segment_gradients(
    reduced: &[Option<Reduced>],
) -> impl Iterator<Item = (&[usize], DVector<f64>)> {
    let stretches = reduced.iter().flatten();
    stretches.map(|r| (&r.columns[..], r.s.tr_mul(&r.c)))
}

/// How many times wider than `promised`, the inverse of J'J times `chi2` where that is above 1,
/// each unknown's error is by how the stretches' `slopes` scatter; at least 1.
pub(crate) fn sandwich_inflation<'a>(
    promised: &DMatrix<f64>,
    slopes: impl Iterator<Item = (&'a [usize], DVector<f64>)>,
    chi2: f64,
) -> Vec<f64> {
    let n = promised.nrows();
    let mut square = vec![0.0; n];
    for (columns, slope) in slopes {
        for (i, square) in square.iter_mut().enumerate() {
            let own = columns.iter().zip(slope.iter());
            let asks: f64 = own.map(|(&c, g)| promised[(i, c)] * g).sum();
            *square += asks * asks;
        }
    }
    let wider = |i: usize| {
        let linear = promised[(i, i)] * chi2.max(1.0);
        (square[i] / linear.max(f64::MIN_POSITIVE)).sqrt().max(1.0)
    };
    (0..n).map(wider).collect()
}

/// `covariance` of all unknowns at `point` (coordinates, as of a linearised fit) with what the
/// cost's own curvature adds to it; as it is where no mode is added.
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
    // In these coordinates the linearised fit promises 1 in every direction.
    let promised = DMatrix::identity(k, k) + root.tr_mul(&(missing * &root));
    let eigen = SymmetricEigen::new(0.5 * (&promised + promised.transpose()));
    let wider = eigen
        .eigenvalues
        .map(|v| v.clamp(MIN_CURVATURE_SHARE, 1.0).powi(-2));
    let axes = &root * &eigen.eigenvectors;
    let found = &axes * DMatrix::from_diagonal(&wider) * axes.transpose();
    // The others follow these as they did before.
    let all = covariance.nrows();
    let beside = DMatrix::from_fn(all, k, |i, j| covariance[(i, own[j])]) * inverse(&linear);
    Ok(covariance + &beside * (found - linear) * beside.transpose())
}

/// What the curvature of the cost, the stretches' own unknowns following, is beyond J'J in
/// the unknowns `own`, all others held.
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
    let linearised =
        |there: &Point| part.linearise(&there.x, &there.segments, &there.used, huber, &others);
    let middle = settle(
        &part,
        &x,
        &point.segments,
        &point.used,
        huber,
        STEP_SETTLE_ROUNDS,
    )?;
    let reduced = linearised(&middle)?;
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
            let reduced = linearised(&there)?;
            Ok(normal_equations(&part, &there.x, &reduced, huber).1)
        };
        let column = (at(step)? - at(-step)?) / (2.0 * step);
        for i in 0..k {
            out[(i, j)] = column[i] - linear[(i, j)];
        }
    }
    // What the others have with these is known from the others' own steps.
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
    fn stretches_that_ask_for_values_of_their_own_widen_the_errors() {
        // Four stretches that each know the second unknown to 0.1, and ask for 0.3 more or
        // less: their mean scatters by 0.15, not by the 0.05 that each promises.
        let promised = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0 / 400.0]));
        let wider = |asked: f64, chi2: f64| {
            let slope = move |sign: f64| DVector::from_element(1, sign * 100.0 * asked);
            let slopes = [1.0, -1.0, 1.0, -1.0].map(slope);
            let all = slopes.into_iter().map(|s| (&[1usize][..], s));
            sandwich_inflation(&promised, all, chi2)
        };
        let close = |a: &[f64], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(&wider(0.3, 1.0), [1.0, 3.0]));
        // As much as their noise allows is as promised, and so is less.
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

    /// By the linearised fit alone the faint one scatters by 1.7 of its errors; of sixteen
    /// draws the root mean square is known to 0.18.
    #[test]
    fn a_mode_scatters_as_its_errors_say_however_faint() {
        for phi in [9e3, 6e4] {
            let sigmas = scatter(phi);
            assert!((0.6..1.4).contains(&sigmas), "{phi}: {sigmas:.2}");
        }
    }
}
