//! The least-squares problem: recordings cut into segments, parameters and nuisances as
//! one vector, and each segment's residuals linearised with its own unknowns eliminated.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::chain::{Nuisances, Row, Setting, Sigmas, residuals, rows};
use super::robust::Huber;
use super::segment::Segment;
use super::space::Space;
use super::track::Track;
use crate::recording::Recording;
use crate::sim::{Options, Points, SimError, StretchSimulator, Stretcher};

/// Step of a parameter's coordinate for differences.
const STEP: f64 = 1e-4;
/// Ridge that keeps a segment's unknowns determined, as a share of their columns.
const RIDGE: f64 = 1e-7;

/// One of a recording's nuisances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nuisance {
    /// Offset of xp.
    OffsetP,
    /// Offset of xc.
    OffsetC,
    /// Scale of xp.
    ScaleP,
    /// Scale of xc.
    ScaleC,
    /// Skew of the clocks.
    Skew,
}

/// A nuisance that is left free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeNuisance {
    /// Of which recording.
    pub recording: usize,
    /// Which.
    pub what: Nuisance,
    /// SI value of one unit.
    pub unit: f64,
    /// Standard deviation of what was known before \[SI\]; infinite if nothing.
    pub sigma: f64,
}

/// A recording made ready.
#[derive(Debug, Clone)]
pub struct Data {
    /// The recording.
    pub recording: Arc<Recording>,
    /// Its drive.
    pub track: Track,
    /// Standard deviations.
    pub sigmas: Sigmas,
    /// Time from the beginning of the series to that of the recording \[s\].
    pub epoch: f64,
}

/// Everything that does not change while the fit runs.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The parameters.
    pub space: Space,
    /// The recordings.
    pub data: Vec<Data>,
    /// The nuisances, after the parameters in the vector of unknowns.
    pub nuisances: Vec<FreeNuisance>,
    /// Tolerance of the simulations.
    pub options: Options,
}

/// A segment's linearised residuals with its own unknowns eliminated: what is left is
/// `|s d + c|^2` for a change `d` of the unknowns in `columns`.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// Unknowns of the whole problem that bear on the segment.
    pub columns: Vec<usize>,
    local: DMatrix<f64>,
    coupling: DMatrix<f64>,
    local_right: DVector<f64>,
    /// Reduced Jacobian.
    pub s: DMatrix<f64>,
    /// Reduced residual.
    pub c: DVector<f64>,
}

impl Reduced {
    /// Best change of the segment's own unknowns for a change `d` of all others. First the
    /// whole of it, then only what follows from `d`: where the segment is not quadratic
    /// the former may lead astray, however small `d` is.
    pub fn local_changes(&self, d: &[f64]) -> Option<[DVector<f64>; 2]> {
        let own = DVector::from_iterator(self.columns.len(), self.columns.iter().map(|&c| d[c]));
        let follows = -(&self.coupling * own);
        let whole = self
            .local
            .solve_upper_triangular(&(&follows - &self.local_right))?;
        Some([whole, self.local.solve_upper_triangular(&follows)?])
    }
}

/// A segment's linearised residuals, weighted.
#[derive(Debug, Clone)]
pub struct Jacobian {
    /// Unknowns of the whole problem that bear on the segment.
    pub columns: Vec<usize>,
    /// Its own unknowns' columns, those of `columns`, and the residuals.
    pub matrix: DMatrix<f64>,
    /// Roots of the rows' weights.
    pub weights: Vec<f64>,
    /// Number of its own unknowns.
    pub locals: usize,
}

/// Simulators that are a step away in one parameter.
trait Moved {
    /// The step, the simulator there, and the effects' states at the segment's start.
    fn by(&self, parameter: usize) -> (f64, &StretchSimulator, &[f64]);
}

struct Steps<'a>(&'a [(f64, StretchSimulator, Vec<Vec<f64>>)], usize);

impl Moved for Steps<'_> {
    fn by(&self, parameter: usize) -> (f64, &StretchSimulator, &[f64]) {
        let (step, simulator, states) = &self.0[parameter];
        (*step, simulator, &states[self.1])
    }
}

impl Problem {
    /// Number of unknowns but for the segments' own.
    pub fn unknowns(&self) -> usize {
        self.space.len() + self.nuisances.len()
    }

    /// Nuisances of a recording at unknowns `x`.
    pub fn nuisances_of(&self, x: &[f64], recording: usize) -> Nuisances {
        let mut result = Nuisances::default();
        for (n, x) in self.nuisances.iter().zip(&x[self.space.len()..]) {
            if n.recording == recording {
                let value = x * n.unit;
                match n.what {
                    Nuisance::OffsetP => result.offset_p = value,
                    Nuisance::OffsetC => result.offset_c = value,
                    Nuisance::ScaleP => result.scale_p = 1.0 + value,
                    Nuisance::ScaleC => result.scale_c = 1.0 + value,
                    Nuisance::Skew => result.skew = value,
                }
            }
        }
        result
    }

    /// The simulator at unknowns `x`.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense there.
    pub fn simulator(&self, x: &[f64]) -> Result<StretchSimulator, SimError> {
        StretchSimulator::new(&self.space.model(x), &self.options)
    }

    /// Extra states of the effects at the start of each segment, if there are any.
    pub fn states(&self, simulator: &StretchSimulator, segments: &[Segment]) -> Vec<Vec<f64>> {
        let count = simulator.state_rates().len();
        let mut out = vec![Vec::new(); segments.len()];
        if count == 0 {
            return out;
        }
        for (index, data) in self.data.iter().enumerate() {
            let own: Vec<usize> = (0..segments.len())
                .filter(|&i| segments[i].recording == index)
                .collect();
            let r = &data.recording;
            let times: Vec<f64> = own
                .iter()
                .map(|&i| r.time[segments[i].samples.start])
                .collect();
            let half = r.interval();
            let motion = |t: f64| {
                use crate::recording::Channel;
                let at = |c, t| r.value_at(c, t);
                // Slopes over two samples on either side: less noise, and still quick.
                let slope = |c| {
                    let (a, b) = (at(c, t - 2.0 * half)?, at(c, t + 2.0 * half)?);
                    Some((b - a) / (4.0 * half))
                };
                Points {
                    xp: at(Channel::ProofMass, t).unwrap_or(0.0),
                    vp: slope(Channel::ProofMass).unwrap_or(0.0),
                    xc: at(Channel::Cantilever, t).unwrap_or(0.0),
                    vc: slope(Channel::Cantilever).unwrap_or(0.0),
                }
            };
            let states = simulator.states_from_drive(&data.track.pieces, &times, &motion);
            for (&i, z) in own.iter().zip(states.chunks(count)) {
                out[i] = z.to_vec();
            }
        }
        out
    }

    /// Surroundings of a segment.
    pub fn setting<'a>(&'a self, segment: &Segment, states: &'a [f64]) -> Setting<'a> {
        let data = &self.data[segment.recording];
        Setting {
            recording: &data.recording,
            sigmas: &data.sigmas,
            states,
            epoch: data.epoch,
        }
    }

    /// Kinds of a segment's rows.
    pub fn rows(&self, segment: &Segment) -> Vec<Row> {
        rows(segment, &self.setting(segment, &[]))
    }

    /// What the priors of the nuisances add: residuals with their unknowns.
    pub fn priors(&self, x: &[f64]) -> Vec<(usize, f64, f64)> {
        let first = self.space.len();
        self.nuisances
            .iter()
            .enumerate()
            .filter(|(_, n)| n.sigma.is_finite())
            .map(|(i, n)| {
                let slope = n.unit / n.sigma;
                (first + i, slope, slope * x[first + i])
            })
            .collect()
    }

    /// Residuals of one segment; infinite cost where no simulation is possible.
    pub fn evaluate(
        &self,
        segment: &Segment,
        states: &[f64],
        stretcher: &mut Stretcher<'_>,
        nuisances: &Nuisances,
        locals: &[f64],
        out: &mut Vec<f64>,
    ) -> bool {
        let setting = self.setting(segment, states);
        residuals(segment, &setting, stretcher, nuisances, locals, out).is_ok()
            && out.iter().all(|r| r.is_finite())
    }

    /// Linearises the segments that are used at unknowns `x`; `None` for the others and
    /// for those that cannot be simulated.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense at `x`.
    pub fn linearise(
        &self,
        x: &[f64],
        segments: &[Segment],
        used: &[bool],
        huber: Huber,
    ) -> Result<Vec<Option<Reduced>>, SimError> {
        self.each(x, segments, used, |segment, base, moved| {
            self.reduce(x, segment, huber, base, moved)
        })
    }

    /// The segments' Jacobians at unknowns `x`, as [`Self::linearise`] uses them.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense at `x`.
    pub fn jacobians(
        &self,
        x: &[f64],
        segments: &[Segment],
        used: &[bool],
        huber: Huber,
    ) -> Result<Vec<Option<Jacobian>>, SimError> {
        self.each(x, segments, used, |segment, base, moved| {
            self.jacobian(x, segment, huber, base, moved)
        })
    }

    /// Calls `make` for each segment that is used, with the simulator at `x` and those a
    /// step away in each parameter.
    fn each<T: Send>(
        &self,
        x: &[f64],
        segments: &[Segment],
        used: &[bool],
        make: impl Fn(&Segment, (&StretchSimulator, &[f64]), &dyn Moved) -> Option<T> + Sync,
    ) -> Result<Vec<Option<T>>, SimError> {
        let base = self.simulator(x)?;
        let mut steps = Vec::with_capacity(self.space.len());
        for (j, entry) in self.space.entries.iter().enumerate() {
            let mut there = x.to_vec();
            there[j] += if there[j] + STEP > entry.high {
                -STEP
            } else {
                STEP
            };
            let step = there[j] - x[j];
            let simulator = self.simulator(&there)?;
            let states = self.states(&simulator, segments);
            steps.push((step, simulator, states));
        }
        let states = self.states(&base, segments);
        let one = |(i, segment): (usize, &Segment)| {
            used[i]
                .then(|| make(segment, (&base, &states[i]), &Steps(&steps, i)))
                .flatten()
        };
        Ok(segments.par_iter().enumerate().map(one).collect())
    }

    fn reduce(
        &self,
        x: &[f64],
        segment: &Segment,
        huber: Huber,
        base: (&StretchSimulator, &[f64]),
        moved: &dyn Moved,
    ) -> Option<Reduced> {
        let Jacobian {
            columns,
            mut matrix,
            weights,
            locals: l,
        } = self.jacobian(x, segment, huber, base, moved)?;
        let (m, g) = (weights.len(), columns.len());
        let height = (m + l).max(l + g + 1);
        matrix = matrix.resize_vertically(height, 0.0);
        for j in 0..l {
            let norm = matrix.column(j).norm().max(1e-12);
            matrix[(m.min(height - l) + j, j)] = RIDGE * norm;
        }
        let upper = matrix.qr().unpack_r();
        Some(Reduced {
            columns,
            local: upper.view((0, 0), (l, l)).into_owned(),
            coupling: upper.view((0, l), (l, g)).into_owned(),
            local_right: upper.view((0, l + g), (l, 1)).column(0).into_owned(),
            s: upper.view((l, l), (g, g)).into_owned(),
            c: upper.view((l, l + g), (g, 1)).column(0).into_owned(),
        })
    }

    fn jacobian(
        &self,
        x: &[f64],
        segment: &Segment,
        huber: Huber,
        (base, states): (&StretchSimulator, &[f64]),
        moved: &dyn Moved,
    ) -> Option<Jacobian> {
        let nuisances = self.nuisances_of(x, segment.recording);
        let mut stretcher = Stretcher::new(base);
        let mut r0 = Vec::new();
        let locals = &segment.locals;
        if !self.evaluate(segment, states, &mut stretcher, &nuisances, locals, &mut r0) {
            return None;
        }
        let own: Vec<usize> = (0..self.nuisances.len())
            .filter(|&i| self.nuisances[i].recording == segment.recording)
            .collect();
        let parameters = self.space.len();
        let mut columns: Vec<usize> = (0..parameters).collect();
        columns.extend(own.iter().map(|i| parameters + i));
        let (l, g, m) = (locals.len(), columns.len(), r0.len());
        let mut a = DMatrix::zeros(m, l + g + 1);
        let weights: Vec<f64> = r0.iter().map(|r| huber.root_weight(*r)).collect();
        let mut r = Vec::with_capacity(m);
        let mut fill = |column: usize, r: &[f64], step: f64| {
            for i in 0..m {
                a[(i, column)] = weights[i] * (r[i] - r0[i]) / step;
            }
        };
        let mut there = locals.clone();
        for j in 0..l {
            let step = segment.step(locals, j);
            there[j] = locals[j] + step;
            if !self.evaluate(segment, states, &mut stretcher, &nuisances, &there, &mut r) {
                return None;
            }
            fill(j, &r, step);
            there[j] = locals[j];
        }
        for j in 0..parameters {
            let (step, simulator, states) = moved.by(j);
            let mut stretcher = Stretcher::new(simulator);
            if !self.evaluate(segment, states, &mut stretcher, &nuisances, locals, &mut r) {
                return None;
            }
            fill(l + j, &r, step);
        }
        for (k, &i) in own.iter().enumerate() {
            let mut there = x.to_vec();
            let step = 0.5;
            there[parameters + i] += step;
            let nuisances = self.nuisances_of(&there, segment.recording);
            if !self.evaluate(segment, states, &mut stretcher, &nuisances, locals, &mut r) {
                return None;
            }
            fill(l + parameters + k, &r, step);
        }
        for i in 0..m {
            a[(i, l + g)] = weights[i] * r0[i];
        }
        Some(Jacobian {
            columns,
            matrix: a,
            weights,
            locals: l,
        })
    }

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
