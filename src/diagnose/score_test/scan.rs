//! The first look at all hypotheses at once: by how much the misfit would fall along each
//! direction, all that re-tuning and the rig can explain taken out.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::forms::Form;
use crate::diagnose::discrepancy::missing_force;
use crate::diagnose::discrepancy::missing_force::Joint;
use crate::diagnose::shooting::fitted::Fitted;
use crate::fit::problem::Problem;
use crate::fit::problem::linearize::Jacobian;
use crate::fit::segment::Segment;
use crate::fit::solve::point::Point;
use crate::model::Model;
use crate::model::effects::ActiveEffect;
use crate::sim::error::SimError;
use crate::sim::stretch::StretchSimulator;
use crate::sim::stretch::propagate::Stretcher;

/// A direction of which re-tuning explains all but this share cannot be told.
pub(crate) const UNTOLD: f64 = 1e-7;
/// Weight that keeps an unknown where it is, over what the data give it.
const LOCKED: f64 = 1e12;
/// Ridge of the baseline's own directions, as a share of each.
const RIDGE: f64 = 1e-10;

/// What a direction would bring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Promise {
    /// Fall of chi2.
    pub gain: f64,
    /// How far to go, in units of the form's strength.
    pub theta: f64,
}

/// Products of a stretch's directions, its own unknowns taken out.
#[derive(Debug, Clone)]
pub struct Products {
    /// Unknowns of the whole problem that bear on it.
    pub columns: Vec<usize>,
    /// Of those with each other.
    pub base: DMatrix<f64>,
    /// Of those with the residuals.
    pub base_slope: DVector<f64>,
    /// Of those (rows) with the probes.
    pub cross: DMatrix<f64>,
    /// Of the probes with each other.
    pub gram: DMatrix<f64>,
    /// Of the probes with the residuals.
    pub slope: DVector<f64>,
    /// Index of the stretch.
    pub segment: usize,
    /// Middle of the stretch \[s\].
    pub middle: f64,
}

impl Products {
    /// The same with the only probe as number `which` of `count`, the others zero; all are
    /// where it is none.
    pub(crate) fn spread(&self, which: Option<usize>, count: usize) -> Self {
        let mut out = Self {
            cross: DMatrix::zeros(self.cross.nrows(), count),
            gram: DMatrix::zeros(count, count),
            slope: DVector::zeros(count),
            ..self.clone()
        };
        if let Some(k) = which {
            out.cross.set_column(k, &self.cross.column(0));
            out.gram[(k, k)] = self.gram[(0, 0)];
            out.slope[k] = self.slope[0];
        }
        out
    }
}

/// A problem linearised at a point, on which directions are tried.
#[derive(Debug)]
pub struct Linear<'a> {
    problem: &'a Problem,
    point: &'a Point,
    jacobians: &'a [Option<Jacobian>],
}

impl<'a> Linear<'a> {
    /// Linearises the problem of `fitted` where it is.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn new(fitted: &'a Fitted) -> Result<Self, SimError> {
        Ok(Self {
            problem: &fitted.problem,
            point: &fitted.point,
            jacobians: fitted.jacobians()?,
        })
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        self.problem
    }

    /// Where it is linearised.
    pub fn point(&self) -> &Point {
        self.point
    }

    /// Products of the directions from `model`, which is the model at the point, to it
    /// with each of `effects`.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn products(
        &self,
        model: &Model,
        effects: &[ActiveEffect],
    ) -> Result<Vec<Products>, SimError> {
        let problem = self.problem;
        let segments = &self.point.segments;
        let probes = effects
            .iter()
            .map(|effect| {
                let with = crate::diagnose::shooting::workspace::with_effect(model, effect.clone());
                let simulator = StretchSimulator::new(&with, &problem.options)?;
                let states = problem.states(&self.point.x, &simulator, segments);
                Ok((simulator, states))
            })
            .collect::<Result<Vec<_>, SimError>>()?;
        let one = |(i, segment): (usize, &Segment)| {
            let jacobian = self.jacobians[i].as_ref()?;
            let nuisances = problem.nuisances_of(&self.point.x, segment.recording);
            let (l, g) = (jacobian.locals, jacobian.columns.len());
            let m = jacobian.weights.len();
            let mut all = DMatrix::zeros(m, g + 1 + probes.len());
            all.view_mut((0, 0), (m, g + 1))
                .copy_from(&jacobian.matrix.view((0, l), (m, g + 1)));
            // The residuals come last in the Jacobian, and have the weights in them.
            let mut r0 = Vec::with_capacity(m);
            r0.extend((0..m).map(|k| jacobian.matrix[(k, l + g)] / jacobian.weights[k]));
            let mut r = Vec::with_capacity(m);
            for (k, (simulator, states)) in probes.iter().enumerate() {
                let mut stretcher = Stretcher::new(simulator);
                stretcher.follow(&jacobian.pace);
                let z = &states[i];
                let locals = &segment.locals;
                if problem.evaluate(segment, z, &mut stretcher, &nuisances, locals, &mut r) {
                    for row in 0..m {
                        all[(row, g + 1 + k)] = jacobian.weights[row] * (r[row] - r0[row]);
                    }
                }
            }
            let own = jacobian.matrix.columns(0, l).into_owned();
            let q = own.qr().q();
            let inside = q.tr_mul(&all);
            all -= &q * inside;
            let whole = all.tr_mul(&all);
            let p = probes.len();
            let time = &problem.data[segment.recording].recording.time;
            Some(Products {
                columns: jacobian.columns.clone(),
                base: whole.view((0, 0), (g, g)).into_owned(),
                base_slope: whole.view((0, g), (g, 1)).column(0).into_owned(),
                cross: whole.view((0, g + 1), (g, p)).into_owned(),
                gram: whole.view((g + 1, g + 1), (p, p)).into_owned(),
                slope: whole.view((g + 1, g), (p, 1)).column(0).into_owned(),
                segment: i,
                middle: 0.5 * (time[segment.samples.start] + time[segment.samples.end - 1]),
            })
        };
        Ok(segments.par_iter().enumerate().filter_map(one).collect())
    }
}

/// Normal equations with the directions of some forms.
#[derive(Debug, Clone)]
pub struct Scan {
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
    unknowns: usize,
}

impl Scan {
    /// Weighs `forms` at `point`, where the model is `model`.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn new(linear: &Linear<'_>, model: &Model, forms: &[Form]) -> Result<Self, SimError> {
        let effects: Vec<ActiveEffect> = forms.iter().map(|f| f.effect(1.0)).collect();
        Self::of(linear, model, &effects)
    }

    /// Weighs effects as they are.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn of(
        linear: &Linear<'_>,
        model: &Model,
        effects: &[ActiveEffect],
    ) -> Result<Self, SimError> {
        let products = linear.products(model, effects)?;
        Ok(Self::gather(linear, &products, effects.len()))
    }

    /// What all directions would bring together, each known beforehand to be zero but for
    /// `sigma` times itself.
    pub fn within(&self, sigma: f64) -> Option<Joint> {
        let all: Vec<usize> = (0..self.gradient.len() - self.unknowns).collect();
        self.solve(&all, 1.0 / (sigma * sigma))
    }

    /// What some of the directions would bring together, all other unknowns adjusted.
    pub fn joint(&self, which: &[usize]) -> Option<Joint> {
        self.solve(which, 0.0)
    }

    fn solve(&self, which: &[usize], prior: f64) -> Option<Joint> {
        let n = self.unknowns;
        let base = self.base()?;
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
        missing_force::solve(&normal, &DVector::from_fn(m, |i, _| slope(i)))
    }

    /// The baseline's own directions, `None` if they are singular.
    pub(crate) fn base(&self) -> Option<Base> {
        Base::new(&self.normal, &self.gradient, self.unknowns)
    }

    /// The same where the first `locked` unknowns, the model's parameters, stay as they are.
    pub(crate) fn base_without(&self, locked: usize) -> Option<Base> {
        let mut normal = self.normal.clone();
        for i in 0..locked.min(self.unknowns) {
            normal[(i, i)] = LOCKED * normal[(i, i)].max(1e-200);
        }
        Base::new(&normal, &self.gradient, self.unknowns)
    }

    /// Normal equations from products with so many probes each.
    pub(crate) fn gather(linear: &Linear<'_>, products: &[Products], probes: usize) -> Self {
        let (problem, point) = (linear.problem, linear.point);
        let n = problem.unknowns();
        let mut normal = DMatrix::zeros(n + probes, n + probes);
        let mut gradient = DVector::zeros(n + probes);
        // One after the other, so that rounding is the same on any number of cores.
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
        for (i, slope, value) in problem.priors(&point.x) {
            normal[(i, i)] += slope * slope;
            gradient[i] += slope * value;
        }
        Self {
            normal,
            gradient,
            unknowns: n,
        }
    }

    /// What form `k` would bring, all other unknowns adjusted.
    pub fn promise(&self, k: usize) -> Option<Promise> {
        let at = self.unknowns + k;
        let base = self.base()?;
        let cross = self.normal.view((0, at), (self.unknowns, 1)).into_owned();
        base.promise(
            &cross.column(0).into_owned(),
            self.normal[(at, at)],
            self.gradient[at],
        )
    }

    /// What re-tuning alone would still bring.
    pub fn own_promise(&self) -> f64 {
        let n = self.unknowns;
        self.base().map_or(0.0, |base| {
            let g = self.gradient.rows(0, n).into_owned();
            base.inner(&g, &g)
        })
    }

    /// Cosine between forms `j` and `k` after all re-tuning: 1 if they cannot be told
    /// apart.
    pub fn cosine(&self, j: usize, k: usize) -> f64 {
        let n = self.unknowns;
        let Some(base) = self.base() else {
            return 0.0;
        };
        let column = |k: usize| self.normal.view((0, n + k), (n, 1)).column(0).into_owned();
        let (a, b) = (column(j), column(k));
        let product = |a: &DVector<f64>, b: &DVector<f64>, whole: f64| whole - base.inner(a, b);
        let aa = product(&a, &a, self.normal[(n + j, n + j)]);
        let bb = product(&b, &b, self.normal[(n + k, n + k)]);
        let ab = product(&a, &b, self.normal[(n + j, n + k)]);
        if aa > 0.0 && bb > 0.0 {
            (ab / (aa * bb).sqrt()).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    }
}

/// The baseline's own directions, ready to be taken out of others.
pub struct Base {
    factor: nalgebra::Cholesky<f64, nalgebra::Dyn>,
    scale: DVector<f64>,
    right: DVector<f64>,
}

impl Base {
    /// From the first `n` unknowns of normal equations; `None` if they are singular.
    pub fn new(normal: &DMatrix<f64>, gradient: &DVector<f64>, n: usize) -> Option<Self> {
        let scale = DVector::from_fn(n, |i, _| 1.0 / normal[(i, i)].max(1e-200).sqrt());
        let base = DMatrix::from_fn(n, n, |i, j| {
            normal[(i, j)] * scale[i] * scale[j] + if i == j { RIDGE } else { 0.0 }
        });
        let factor = base.cholesky()?;
        let right = DVector::from_fn(n, |i, _| gradient[i] * scale[i]);
        Some(Self {
            right: factor.solve(&right),
            factor,
            scale,
        })
    }

    /// Part of the product of two directions that lies in the baseline's own.
    pub fn inner(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        let scaled = b.component_mul(&self.scale);
        a.component_mul(&self.scale)
            .dot(&self.factor.solve(&scaled))
    }

    /// Slope along a direction that is left when the baseline adjusts.
    pub fn slope(&self, cross: &DVector<f64>, slope: f64) -> f64 {
        slope - cross.component_mul(&self.scale).dot(&self.right)
    }

    /// What a direction would bring, from its products with the baseline's own, with itself
    /// and with the residuals; `None` if it cannot be told from those.
    pub fn promise(&self, cross: &DVector<f64>, own: f64, slope: f64) -> Option<Promise> {
        let left = own - self.inner(cross, cross);
        if left.is_nan() || left <= UNTOLD * own || own <= 0.0 {
            return None;
        }
        let slope = self.slope(cross, slope);
        Some(Promise {
            gain: slope * slope / left,
            theta: -slope / left,
        })
    }
}
