//! A problem linearised at a fit: products of its Jacobians with the directions to be tested, each
//! segment's own unknowns projected out.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnose::shooting::fitted::Fitted;
use crate::fit::problem::{Jacobian, Problem};
use crate::fit::segment::Segment;
use crate::fit::solve::point::Point;
use crate::model::Model;
use crate::model::effects::ActiveEffect;
use crate::sim::{SimError, StretchSimulator, Stretcher};

/// Products of the directions of one segment, its own unknowns projected out by a QR
/// decomposition.
#[derive(Debug, Clone)]
pub struct SegmentGram {
    /// Unknowns of the problem that act on it.
    pub columns: Vec<usize>,
    /// Products of those with each other.
    pub base: DMatrix<f64>,
    /// Products of those with the residuals.
    pub base_slope: DVector<f64>,
    /// Products of those (rows) with the tested directions.
    pub cross: DMatrix<f64>,
    /// Products of the tested directions with each other.
    pub gram: DMatrix<f64>,
    /// Products of the tested directions with the residuals.
    pub slope: DVector<f64>,
    /// Index of the segment.
    pub segment: usize,
    /// Middle of the segment \[s\].
    pub middle: f64,
}

impl SegmentGram {
    /// The same with its only direction as number `which` of `count`, the others zero; all are
    /// zero for `None`.
    pub(crate) fn in_group(&self, which: Option<usize>, count: usize) -> Self {
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

/// A problem linearised at a point, on which directions are tested.
#[derive(Debug)]
pub struct Linearized<'a> {
    pub(crate) problem: &'a Problem,
    /// The point of linearisation.
    pub(crate) point: &'a Point,
    jacobians: &'a [Option<Jacobian>],
}

impl<'a> Linearized<'a> {
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

    /// Products of the directions that lead from `model`, the model at the point, to it with
    /// each of `effects`.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn segment_grams(
        &self,
        model: &Model,
        effects: &[ActiveEffect],
    ) -> Result<Vec<SegmentGram>, SimError> {
        let problem = self.problem;
        let segments = &self.point.segments;
        let probes = effects
            .iter()
            .map(|effect| {
                let with = crate::model::with_effect(model, effect.clone());
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
                stretcher.replay_steps(&jacobian.pace);
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
            Some(SegmentGram {
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
