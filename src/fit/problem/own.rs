//! A segment by itself: its cost, and its own unknowns improved with all else fixed.

use nalgebra::{DMatrix, DVector};

use super::Problem;
use crate::fit::chain::Nuisances;
use crate::fit::robust::Huber;
use crate::fit::segment::Segment;
use crate::sim::{StretchSimulator, Stretcher};

impl Problem {
    /// Robust cost of a segment; infinite if it cannot be simulated.
    pub fn cost(
        &self,
        segment: &Segment,
        states: &[f64],
        simulator: &StretchSimulator,
        nuisances: &Nuisances,
        locals: &[f64],
        huber: Huber,
    ) -> f64 {
        let mut stretcher = Stretcher::new(simulator);
        let mut r = Vec::new();
        let mut kept = locals.to_vec();
        segment.keep_within(&mut kept);
        if self.evaluate(segment, states, &mut stretcher, nuisances, &kept, &mut r) {
            huber.total(&r)
        } else {
            f64::INFINITY
        }
    }

    /// Improves a segment's own unknowns, all else fixed, in at most `rounds` rounds of
    /// damped least squares; returns them with the cost, which is infinite if the segment
    /// cannot be simulated.
    #[allow(clippy::too_many_arguments)] // all belong to one trial
    pub fn refine(
        &self,
        segment: &Segment,
        states: &[f64],
        simulator: &StretchSimulator,
        nuisances: &Nuisances,
        start: Vec<f64>,
        huber: Huber,
        rounds: usize,
    ) -> (Vec<f64>, f64) {
        let mut stretcher = Stretcher::new(simulator);
        let mut locals = start;
        segment.keep_within(&mut locals);
        let (mut r0, mut r) = (Vec::new(), Vec::new());
        if !self.evaluate(segment, states, &mut stretcher, nuisances, &locals, &mut r0) {
            return (locals, f64::INFINITY);
        }
        let mut cost = huber.total(&r0);
        let mut damping = 1e-6;
        let l = locals.len();
        for _ in 0..rounds {
            let m = r0.len();
            let mut a = DMatrix::zeros(m, l);
            let weights: Vec<f64> = r0.iter().map(|r| huber.root_weight(*r)).collect();
            for j in 0..l {
                let mut there = locals.clone();
                let step = segment.step(&locals, j);
                there[j] += step;
                if !self.evaluate(segment, states, &mut stretcher, nuisances, &there, &mut r) {
                    return (locals, cost);
                }
                for i in 0..m {
                    a[(i, j)] = weights[i] * (r[i] - r0[i]) / step;
                }
            }
            let right = DVector::from_fn(m, |i, _| weights[i] * r0[i]);
            let (normal, gradient) = (a.tr_mul(&a), a.tr_mul(&right));
            let mut improved = false;
            let before = cost;
            for _ in 0..6 {
                let mut damped = normal.clone();
                for j in 0..l {
                    damped[(j, j)] += damping * normal[(j, j)].max(1e-9);
                }
                let Some(step) = damped.cholesky().map(|c| c.solve(&-&gradient)) else {
                    damping *= 10.0;
                    continue;
                };
                let mut there: Vec<f64> =
                    locals.iter().zip(step.iter()).map(|(x, d)| x + d).collect();
                segment.keep_within(&mut there);
                if self.evaluate(segment, states, &mut stretcher, nuisances, &there, &mut r) {
                    let now = huber.total(&r);
                    if now < cost {
                        locals = there;
                        cost = now;
                        std::mem::swap(&mut r0, &mut r);
                        damping = (0.1 * damping).max(1e-9);
                        improved = true;
                        break;
                    }
                }
                damping = (10.0 * damping).max(1e-4);
            }
            if !improved || before - cost < 1e-3 * cost.max(1.0) {
                break;
            }
        }
        (locals, cost)
    }
}
