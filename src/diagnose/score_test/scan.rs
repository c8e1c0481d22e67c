//! The score test of all hypotheses at once: by how much chi2 would fall along each direction,
//! with everything that re-tuning and the setup can explain projected out.

use nalgebra::{DMatrix, DVector};

use super::forms::CatalogueDirection;
use super::joint::Joint;
use super::linearized::{Linearized, SegmentGram};
use crate::diagnose::thresholds::UNIDENTIFIABLE_SHARE;
use crate::fit::solve::normal_equations::add_row;
use crate::model::Model;
use crate::model::effects::ActiveEffect;
use crate::sim::SimError;

/// Weight that holds an unknown in place, relative to what the data give it.
const LOCKING_WEIGHT: f64 = 1e12;
/// Ridge on the baseline's own directions, relative to each diagonal element.
const RELATIVE_RIDGE: f64 = 1e-10;

/// Score of one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoreGain {
    /// Predicted fall of chi2.
    pub gain: f64,
    /// Step to take, in units of the form's strength.
    pub theta: f64,
}

/// Normal equations of the baseline's unknowns and the tested directions.
#[derive(Debug, Clone)]
pub struct ScoreScan {
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
    unknowns: usize,
}

impl ScoreScan {
    /// Tests `forms` at the linearisation point, where the model is `model`.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn new(
        linear: &Linearized<'_>,
        model: &Model,
        forms: &[CatalogueDirection],
    ) -> Result<Self, SimError> {
        let effects: Vec<ActiveEffect> = forms.iter().map(|f| f.effect(1.0)).collect();
        Self::of_effects(linear, model, &effects)
    }

    /// Tests effects as they are.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn of_effects(
        linear: &Linearized<'_>,
        model: &Model,
        effects: &[ActiveEffect],
    ) -> Result<Self, SimError> {
        let products = linear.segment_grams(model, effects)?;
        Ok(Self::assemble(linear, &products, effects.len()))
    }

    /// Joint score of all directions under a Gaussian prior of zero mean and standard
    /// deviation `sigma`, in units of each direction.
    pub fn joint_with_prior(&self, sigma: f64) -> Option<Joint> {
        let all: Vec<usize> = (0..self.gradient.len() - self.unknowns).collect();
        self.solve(&all, 1.0 / (sigma * sigma))
    }

    /// Joint score of some directions, all other unknowns adjusted.
    pub fn joint(&self, which: &[usize]) -> Option<Joint> {
        self.solve(which, 0.0)
    }

    fn solve(&self, which: &[usize], prior: f64) -> Option<Joint> {
        let n = self.unknowns;
        let base = self.nuisance_projector()?;
        let column = |k: usize| self.normal.view((0, n + k), (n, 1)).column(0).into_owned();
        let columns: Vec<DVector<f64>> = which.iter().map(|&k| column(k)).collect();
        let m = which.len();
        let mut normal = DMatrix::zeros(m, m);
        for i in 0..m {
            for j in 0..m {
                let whole = self.normal[(n + which[i], n + which[j])];
                normal[(i, j)] = whole - base.inner(&columns[i], &columns[j]);
            }
            normal[(i, i)] += prior;
        }
        let slope = |i: usize| base.slope(&columns[i], self.gradient[n + which[i]]);
        super::joint::solve(&normal, &DVector::from_fn(m, |i, _| slope(i)))
    }

    /// The projector onto the baseline's own directions; `None` if they are singular.
    pub(crate) fn nuisance_projector(&self) -> Option<NuisanceProjector> {
        NuisanceProjector::new(&self.normal, &self.gradient, self.unknowns)
    }

    /// The same with the first `locked` unknowns, the model's parameters, held fixed.
    pub(crate) fn projector_with_locked(&self, locked: usize) -> Option<NuisanceProjector> {
        let mut normal = self.normal.clone();
        for i in 0..locked.min(self.unknowns) {
            normal[(i, i)] = LOCKING_WEIGHT * normal[(i, i)].max(1e-200);
        }
        NuisanceProjector::new(&normal, &self.gradient, self.unknowns)
    }

    /// Adds `weight` to what draws unknown `i`, which is at `value`, to zero.
    pub(crate) fn add_prior(&mut self, i: usize, value: f64, weight: f64) {
        self.normal[(i, i)] += weight;
        self.gradient[i] += weight * value;
    }

    /// Normal equations summed over segments with so many `probes` each, and the priors.
    pub(crate) fn assemble(
        linear: &Linearized<'_>,
        products: &[SegmentGram],
        probes: usize,
    ) -> Self {
        let (problem, point) = (linear.problem, linear.point);
        let n = problem.unknowns();
        let mut normal = DMatrix::zeros(n + probes, n + probes);
        let mut gradient = DVector::zeros(n + probes);
        // Summed in order, so that rounding does not depend on the number of cores.
        for p in products {
            for (i, &ci) in p.columns.iter().enumerate() {
                gradient[ci] += p.base_slope[i];
                for (j, &cj) in p.columns.iter().enumerate() {
                    normal[(ci, cj)] += p.base[(i, j)];
                }
                for k in 0..probes {
                    normal[(ci, n + k)] += p.cross[(i, k)];
                    normal[(n + k, ci)] += p.cross[(i, k)];
                }
            }
            for k in 0..probes {
                gradient[n + k] += p.slope[k];
                for j in 0..probes {
                    normal[(n + k, n + j)] += p.gram[(k, j)];
                }
            }
        }
        for row in problem.prior_rows(&point.x) {
            add_row(&mut normal, &mut gradient, &row, 1.0);
        }
        Self {
            normal,
            gradient,
            unknowns: n,
        }
    }

    /// Score of form `k`, all other unknowns adjusted.
    pub fn predicted_gain(&self, k: usize) -> Option<ScoreGain> {
        let at = self.unknowns + k;
        let base = self.nuisance_projector()?;
        let cross = self.normal.view((0, at), (self.unknowns, 1)).into_owned();
        base.predicted_gain(
            &cross.column(0).into_owned(),
            self.normal[(at, at)],
            self.gradient[at],
        )
    }
}

/// The baseline's own directions, ready to be projected out of others.
pub struct NuisanceProjector {
    factor: nalgebra::Cholesky<f64, nalgebra::Dyn>,
    scale: DVector<f64>,
    right: DVector<f64>,
}

impl NuisanceProjector {
    /// From the first `n` unknowns of normal equations; `None` if they are singular.
    pub fn new(normal: &DMatrix<f64>, gradient: &DVector<f64>, n: usize) -> Option<Self> {
        let scale = DVector::from_fn(n, |i, _| 1.0 / normal[(i, i)].max(1e-200).sqrt());
        let base = DMatrix::from_fn(n, n, |i, j| {
            normal[(i, j)] * scale[i] * scale[j] + if i == j { RELATIVE_RIDGE } else { 0.0 }
        });
        let factor = base.cholesky()?;
        let right = DVector::from_fn(n, |i, _| gradient[i] * scale[i]);
        Some(Self {
            right: factor.solve(&right),
            factor,
            scale,
        })
    }

    /// Fall of chi2 by the baseline's own directions alone.
    pub fn gain(&self) -> f64 {
        let half = self.factor.l().tr_mul(&self.right);
        half.norm_squared()
    }

    /// Part of the product of two directions that lies in the span of the baseline's own.
    pub fn inner(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        let scaled = b.component_mul(&self.scale);
        a.component_mul(&self.scale)
            .dot(&self.factor.solve(&scaled))
    }

    /// Slope along a direction with the baseline adjusted.
    pub fn slope(&self, cross: &DVector<f64>, slope: f64) -> f64 {
        slope - cross.component_mul(&self.scale).dot(&self.right)
    }

    /// Score of a direction from its products with the baseline's own, with itself and with
    /// the residuals: `g^2 / H` with both projected. `None` if the baseline can absorb it.
    pub fn predicted_gain(&self, cross: &DVector<f64>, own: f64, slope: f64) -> Option<ScoreGain> {
        let left = own - self.inner(cross, cross);
        if left.is_nan() || left <= UNIDENTIFIABLE_SHARE * own || own <= 0.0 {
            return None;
        }
        let slope = self.slope(cross, slope);
        Some(ScoreGain {
            gain: slope * slope / left,
            theta: -slope / left,
        })
    }
}
