//! A segment by itself: its cost, and its own unknowns improved with all else fixed.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::Problem;
use super::huber::Huber;
use super::linearize::Reduced;
use crate::fit::residual::residual_rows::Nuisances;
use crate::fit::segment::Segment;
use crate::sim::{StretchSimulator, Stretcher};

/// Fall of a segment's cost, as a share of it and of 1, that ends the rounds.
const MIN_COST_FALL: f64 = 1e-3;
/// Predicted fall of the cost that does not justify a simulation.
const NEGLIGIBLE_COST_FALL: f64 = 1e-4;
/// Cost per row up to which a linearization is used for more than one step.
pub const MAX_REUSE_COST_PER_ROW: f64 = 1.5;
/// Share of the predicted fall from which a linearization is good enough to be used again.
const MIN_FALL_RATIO: f64 = 0.25;

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
        self.evaluated(segment, with, locals.to_vec(), huber).cost
    }

    /// A segment with these unknowns, kept within their reach.
    fn evaluated(
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

    /// The better of two starts for a segment's own unknowns, corrected by a linearization
    /// nearby if there is one: one more simulation in place of one for each unknown. If that
    /// does not lower the cost as predicted, the unknowns are improved in `rounds`.
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
            self.evaluated(segment, with, locals, huber)
        };
        let [first, second] = starts.map(&mut at);
        let mut best = if second.cost < first.cost {
            second
        } else {
            first
        };
        let known = near.filter(|_| best.cost.is_finite());
        if let Some((change, foreseen)) = known.and_then(|near| near.correction(&best.residuals)) {
            if foreseen < NEGLIGIBLE_COST_FALL {
                return best;
            }
            let all = best.locals.iter().zip(change.iter());
            let there = at(all.map(|(x, d)| x + d).collect());
            let fall = best.cost - there.cost;
            if fall > 0.0 {
                best = there;
            }
            if fall > MIN_FALL_RATIO * foreseen || foreseen < MIN_COST_FALL * best.cost.max(1.0) {
                return best;
            }
        }
        let with = (states, &mut stretcher, nuisances);
        self.improve_locals(segment, with, best, huber, rounds)
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
        let begun = self.evaluated(segment, (states, &mut stretcher, nuisances), start, huber);
        let with = (states, &mut stretcher, nuisances);
        self.improve_locals(segment, with, begun, huber, rounds)
    }

    /// See [`Self::refine`]; begins where the segment has been evaluated already.
    fn improve_locals(
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
        let mut fit = LocalFit {
            problem: self,
            segment,
            states,
            stretcher,
            nuisances,
            huber,
            best: begun,
            scratch: Vec::new(),
        };
        let mut damping = 1e-6;
        let mut left = rounds;
        while left > 0 {
            left -= 1;
            let Some(jacobian) = fit.jacobian() else {
                break;
            };
            let before = fit.best.cost;
            let solver = fit.damped_step(&jacobian, &mut damping);
            let cost = fit.best.cost;
            let Some(solver) = solver.filter(|_| before - cost >= MIN_COST_FALL * cost.max(1.0))
            else {
                break;
            };
            if cost > MAX_REUSE_COST_PER_ROW * jacobian.weights.len() as f64 {
                continue;
            }
            left = fit.reuse(&jacobian, &solver, left);
        }
        fit.best
    }
}

/// Weighted residuals of one segment, linearized in its own unknowns.
struct LocalJacobian {
    /// Weighted columns, one for each unknown.
    matrix: DMatrix<f64>,
    /// Roots of the rows' weights.
    weights: Vec<f64>,
}

impl LocalJacobian {
    /// Half the gradient of the robust cost where the residuals are `r`: `J^T W r`.
    fn gradient(&self, r: &[f64]) -> DVector<f64> {
        let m = self.weights.len();
        let weighted = DVector::from_fn(m, |i, _| self.weights[i] * r[i]);
        self.matrix.tr_mul(&weighted)
    }
}

/// Levenberg-Marquardt in the unknowns of one segment, everything else held.
struct LocalFit<'a, 's> {
    problem: &'a Problem,
    segment: &'a Segment,
    states: &'a [f64],
    stretcher: &'a mut Stretcher<'s>,
    nuisances: &'a Nuisances,
    huber: Huber,
    /// The best so far.
    best: Refined,
    /// Residuals of the latest trial.
    scratch: Vec<f64>,
}

impl LocalFit<'_, '_> {
    /// Writes the residuals at `locals` to `scratch`; false if they cannot be simulated.
    fn evaluate(&mut self, locals: &[f64]) -> bool {
        self.problem.evaluate(
            self.segment,
            self.states,
            self.stretcher,
            self.nuisances,
            locals,
            &mut self.scratch,
        )
    }

    /// Jacobian by differences at the best; `None` if a step cannot be simulated.
    fn jacobian(&mut self) -> Option<LocalJacobian> {
        let (m, l) = (self.best.residuals.len(), self.best.locals.len());
        let mut matrix = DMatrix::zeros(m, l);
        let residuals = self.best.residuals.iter();
        let weights: Vec<f64> = residuals.map(|r| self.huber.root_weight(*r)).collect();
        for j in 0..l {
            let mut there = self.best.locals.clone();
            let step = self.segment.step(&self.best.locals, j);
            there[j] += step;
            if !self.evaluate(&there) {
                return None;
            }
            for i in 0..m {
                matrix[(i, j)] = weights[i] * (self.scratch[i] - self.best.residuals[i]) / step;
            }
        }
        Some(LocalJacobian { matrix, weights })
    }

    /// Moves to the first of several damped steps that lowers the cost, and gives its solver;
    /// `None` if none does.
    fn damped_step(
        &mut self,
        jacobian: &LocalJacobian,
        damping: &mut f64,
    ) -> Option<Cholesky<f64, Dyn>> {
        let normal = jacobian.matrix.tr_mul(&jacobian.matrix);
        let gradient = jacobian.gradient(&self.best.residuals);
        for _ in 0..6 {
            let mut damped = normal.clone();
            for j in 0..normal.ncols() {
                damped[(j, j)] += *damping * normal[(j, j)].max(1e-9);
            }
            let Some(solver) = damped.cholesky() else {
                *damping *= 10.0;
                continue;
            };
            let there = self.stepped(&solver.solve(&-&gradient));
            if self.evaluate(&there) {
                let now = self.huber.total(&self.scratch);
                if now < self.best.cost {
                    self.best.locals = there;
                    self.best.cost = now;
                    std::mem::swap(&mut self.best.residuals, &mut self.scratch);
                    *damping = (0.1 * *damping).max(1e-9);
                    return Some(solver);
                }
            }
            *damping = (10.0 * *damping).max(1e-4);
        }
        None
    }

    /// Goes on with a linearization for as long as it predicts the fall of the cost: one
    /// simulation in place of one for each unknown. Returns the rounds that are left of
    /// `rounds`; 0 where nothing more can be gained.
    fn reuse(
        &mut self,
        jacobian: &LocalJacobian,
        solver: &Cholesky<f64, Dyn>,
        rounds: usize,
    ) -> usize {
        let mut left = rounds;
        while left > 0 {
            let gradient = jacobian.gradient(&self.best.residuals);
            let step = solver.solve(&-&gradient);
            let foreseen = -gradient.dot(&step);
            let there = self.stepped(&step);
            if foreseen < NEGLIGIBLE_COST_FALL || !self.evaluate(&there) {
                return 0;
            }
            let fall = self.best.cost - self.huber.total(&self.scratch);
            if fall > 0.0 {
                self.best.locals = there;
                self.best.cost -= fall;
                std::mem::swap(&mut self.best.residuals, &mut self.scratch);
            }
            if foreseen < MIN_COST_FALL * self.best.cost.max(1.0) {
                return 0;
            } else if fall > MIN_FALL_RATIO * foreseen {
                left -= 1;
            } else {
                break;
            }
        }
        left
    }

    /// The best unknowns moved by `step`, kept within their reach.
    fn stepped(&self, step: &DVector<f64>) -> Vec<f64> {
        let moved = self.best.locals.iter().zip(step.iter());
        let mut there: Vec<f64> = moved.map(|(x, d)| x + d).collect();
        self.segment.keep_within(&mut there);
        there
    }
}
