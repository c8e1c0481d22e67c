//! A segment by itself: its cost, and its own unknowns improved with all else fixed.

use nalgebra::{DMatrix, DVector};

use super::{Problem, Reduced};
use crate::fit::chain::Nuisances;
use crate::fit::robust::Huber;
use crate::fit::segment::Segment;
use crate::sim::{StretchSimulator, Stretcher};

/// Fall of a segment's cost, as a share of it and of 1, that is not worth another round.
const ENOUGH: f64 = 1e-3;
/// Fall that is not worth a simulation.
const NEGLIGIBLE: f64 = 1e-4;

/// Share of the fall foreseen from which a correction has kept its promise.
const KEPT: f64 = 0.25;

/// A segment's own unknowns, improved.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The unknowns.
    pub locals: Vec<f64>,
    /// Robust cost; infinite if the segment cannot be simulated.
    pub cost: f64,
    /// Residuals, in units of the noise; empty if the segment cannot be simulated.
    pub residuals: Vec<f64>,
}

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

    /// The best of `starts` for a segment's own unknowns, corrected by a linearisation
    /// nearby, if there is one: one more simulation in place of one for each unknown. Where that leads nowhere it
    /// is improved in `rounds` as if nothing were known. `None` if no start can be simulated.
    #[allow(clippy::too_many_arguments)] // all belong to one trial
    pub fn correct(
        &self,
        segment: &Segment,
        states: &[f64],
        simulator: &StretchSimulator,
        nuisances: &Nuisances,
        starts: &[Vec<f64>],
        near: Option<&Reduced>,
        (huber, rounds): (Huber, usize),
    ) -> Option<Refined> {
        let mut stretcher = Stretcher::new(simulator);
        let mut at = |mut locals: Vec<f64>| {
            segment.keep_within(&mut locals);
            let mut residuals = Vec::new();
            self.evaluate(
                segment,
                states,
                &mut stretcher,
                nuisances,
                &locals,
                &mut residuals,
            )
            .then(|| Refined {
                cost: huber.total(&residuals),
                locals,
                residuals,
            })
        };
        let begun = starts.iter().filter_map(|start| at(start.clone()));
        let mut best = begun.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let correction = near.and_then(|near| near.correction(&best.residuals));
        if let Some((change, foreseen)) = correction {
            if foreseen < NEGLIGIBLE {
                return Some(best);
            }
            let all = best.locals.iter().zip(change.iter());
            let there = at(all.map(|(x, d)| x + d).collect());
            if let Some(there) = there.filter(|there| there.cost < best.cost) {
                let fall = best.cost - there.cost;
                best = there;
                if fall > KEPT * foreseen {
                    return Some(best);
                }
            }
            if foreseen < ENOUGH * best.cost.max(1.0) {
                return Some(best);
            }
        }
        let start = best.locals;
        Some(self.refined(segment, states, simulator, nuisances, start, huber, rounds))
    }

    /// As [`Self::refined`]: the unknowns and their cost.
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
        let told = self.refined(segment, states, simulator, nuisances, start, huber, rounds);
        (told.locals, told.cost)
    }

    /// Improves a segment's own unknowns, all else fixed, in at most `rounds` rounds of
    /// damped least squares.
    #[allow(clippy::too_many_arguments)] // all belong to one trial
    pub fn refined(
        &self,
        segment: &Segment,
        states: &[f64],
        simulator: &StretchSimulator,
        nuisances: &Nuisances,
        start: Vec<f64>,
        huber: Huber,
        rounds: usize,
    ) -> Refined {
        let mut stretcher = Stretcher::new(simulator);
        let mut locals = start;
        segment.keep_within(&mut locals);
        let (mut r0, mut r) = (Vec::new(), Vec::new());
        if !self.evaluate(segment, states, &mut stretcher, nuisances, &locals, &mut r0) {
            return Refined {
                locals,
                cost: f64::INFINITY,
                residuals: Vec::new(),
            };
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
                    return Refined {
                        locals,
                        cost,
                        residuals: r0,
                    };
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
            if !improved || before - cost < ENOUGH * cost.max(1.0) {
                break;
            }
        }
        Refined {
            locals,
            cost,
            residuals: r0,
        }
    }
}
