//! A segment by itself: its cost, and its own unknowns improved with all else fixed.

use nalgebra::{DMatrix, DVector};

use super::Problem;
use super::huber::Huber;
use super::linearize::Reduced;
use crate::fit::residual::residual_rows::Nuisances;
use crate::fit::segment::Segment;
use crate::sim::{StretchSimulator, Stretcher};

/// Fall of a segment's cost, as a share of it and of 1, that is not worth another round.
const ENOUGH: f64 = 1e-3;
/// Fall that is not worth a simulation.
const NEGLIGIBLE: f64 = 1e-4;
/// Cost per row up to which a linearisation is good for more than one step.
pub const CLOSE: f64 = 1.5;
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
        let with = (states, &mut stretcher, nuisances);
        self.told(segment, with, locals.to_vec(), huber).cost
    }

    /// A segment with these unknowns, kept within their reach.
    fn told(
        &self,
        segment: &Segment,
        (states, stretcher, nuisances): (&[f64], &mut Stretcher<'_>, &Nuisances),
        mut locals: Vec<f64>,
        huber: Huber,
    ) -> Refined {
        segment.keep_within(&mut locals);
        let mut residuals = Vec::new();
        let r = &mut residuals;
        let cost = if self.evaluate(segment, states, stretcher, nuisances, &locals, r) {
            huber.total(&residuals)
        } else {
            residuals.clear();
            f64::INFINITY
        };
        Refined {
            locals,
            cost,
            residuals,
        }
    }

    /// The best of two starts for a segment's own unknowns, corrected by a linearisation
    /// nearby, if there is one: one more simulation in place of one for each unknown. Where
    /// that leads nowhere it is improved in `rounds` as if nothing were known.
    #[allow(clippy::too_many_arguments)] // all belong to one trial
    pub fn correct(
        &self,
        segment: &Segment,
        states: &[f64],
        simulator: &StretchSimulator,
        nuisances: &Nuisances,
        starts: [Vec<f64>; 2],
        near: Option<&Reduced>,
        (huber, rounds): (Huber, usize),
    ) -> Refined {
        let mut stretcher = Stretcher::new(simulator);
        let mut at = |locals| {
            let with = (states, &mut stretcher, nuisances);
            self.told(segment, with, locals, huber)
        };
        let [first, second] = starts.map(&mut at);
        let mut best = if second.cost < first.cost {
            second
        } else {
            first
        };
        let known = near.filter(|_| best.cost.is_finite());
        if let Some((change, foreseen)) = known.and_then(|near| near.correction(&best.residuals)) {
            if foreseen < NEGLIGIBLE {
                return best;
            }
            let all = best.locals.iter().zip(change.iter());
            let there = at(all.map(|(x, d)| x + d).collect());
            let fall = best.cost - there.cost;
            if fall > 0.0 {
                best = there;
            }
            if fall > KEPT * foreseen || foreseen < ENOUGH * best.cost.max(1.0) {
                return best;
            }
        }
        let with = (states, &mut stretcher, nuisances);
        self.improved(segment, with, best, huber, rounds)
    }

    /// Improves a segment's own unknowns, all else fixed, in at most `rounds` rounds of
    /// damped least squares.
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
    ) -> Refined {
        let mut stretcher = Stretcher::new(simulator);
        let begun = self.told(segment, (states, &mut stretcher, nuisances), start, huber);
        let with = (states, &mut stretcher, nuisances);
        self.improved(segment, with, begun, huber, rounds)
    }

    /// See [`Self::refine`]; from where the segment has been told already.
    fn improved(
        &self,
        segment: &Segment,
        (states, stretcher, nuisances): (&[f64], &mut Stretcher<'_>, &Nuisances),
        begun: Refined,
        huber: Huber,
        rounds: usize,
    ) -> Refined {
        if !begun.cost.is_finite() {
            return begun;
        }
        let Refined {
            mut locals,
            mut cost,
            residuals: mut r0,
        } = begun;
        let mut r = Vec::new();
        let mut damping = 1e-6;
        let l = locals.len();
        let mut left = rounds;
        while left > 0 {
            left -= 1;
            let m = r0.len();
            let mut a = DMatrix::zeros(m, l);
            let weights: Vec<f64> = r0.iter().map(|r| huber.root_weight(*r)).collect();
            for j in 0..l {
                let mut there = locals.clone();
                let step = segment.step(&locals, j);
                there[j] += step;
                if !self.evaluate(segment, states, stretcher, nuisances, &there, &mut r) {
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
            let slope = |r: &[f64]| a.tr_mul(&DVector::from_fn(m, |i, _| weights[i] * r[i]));
            let (normal, gradient) = (a.tr_mul(&a), slope(&r0));
            let mut improved = None;
            let before = cost;
            for _ in 0..6 {
                let mut damped = normal.clone();
                for j in 0..l {
                    damped[(j, j)] += damping * normal[(j, j)].max(1e-9);
                }
                let Some(solver) = damped.cholesky() else {
                    damping *= 10.0;
                    continue;
                };
                let step = solver.solve(&-&gradient);
                let mut there: Vec<f64> =
                    locals.iter().zip(step.iter()).map(|(x, d)| x + d).collect();
                segment.keep_within(&mut there);
                if self.evaluate(segment, states, stretcher, nuisances, &there, &mut r) {
                    let now = huber.total(&r);
                    if now < cost {
                        locals = there;
                        cost = now;
                        std::mem::swap(&mut r0, &mut r);
                        damping = (0.1 * damping).max(1e-9);
                        improved = Some(solver);
                        break;
                    }
                }
                damping = (10.0 * damping).max(1e-4);
            }
            let Some(solver) = improved.filter(|_| before - cost >= ENOUGH * cost.max(1.0)) else {
                break;
            };
            if cost > CLOSE * m as f64 {
                continue;
            }
            // As long as the linearisation keeps what it promises it need not be made anew: one
            // simulation in place of one for each unknown.
            while left > 0 {
                let gradient = slope(&r0);
                let step = solver.solve(&-&gradient);
                let foreseen = -gradient.dot(&step);
                let mut there: Vec<f64> =
                    locals.iter().zip(step.iter()).map(|(x, d)| x + d).collect();
                segment.keep_within(&mut there);
                if foreseen < NEGLIGIBLE
                    || !self.evaluate(segment, states, stretcher, nuisances, &there, &mut r)
                {
                    left = 0;
                    break;
                }
                let fall = cost - huber.total(&r);
                if fall > 0.0 {
                    locals = there;
                    cost -= fall;
                    std::mem::swap(&mut r0, &mut r);
                }
                if foreseen < ENOUGH * cost.max(1.0) {
                    left = 0;
                } else if fall > KEPT * foreseen {
                    left -= 1;
                } else {
                    break;
                }
            }
        }
        Refined {
            locals,
            cost,
            residuals: r0,
        }
    }
}
