//! Segments linearized: their Jacobians by differences, and the reduced problem with their own
//! unknowns eliminated by a QR decomposition (variable projection: Golub and Pereyra 1973).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::huber::Huber;
use super::{FreeNuisance, Nuisance, Problem};
use crate::fit::residual::residual_rows::{Nuisances, Row};
use crate::fit::residual::segment_start::begins_from_reading;
use crate::fit::segment::Segment;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::{SimError, StepSequence, StretchSimulator, Stretcher};

/// Step of a parameter's coordinate for differences.
pub const COORDINATE_STEP: f64 = 1e-4;
/// Ridge that keeps a segment's unknowns determined, as a share of their columns.
const LOCAL_RIDGE_SHARE: f64 = 1e-7;

/// A segment's linearized residuals with its own unknowns eliminated. The cost is
/// `|s d + c|^2` for a change `d` of the unknowns in `columns`.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// Unknowns of the whole problem that bear on the segment.
    pub columns: Vec<usize>,
    /// Weighted columns of the segment's own unknowns.
    own: DMatrix<f64>,
    /// Roots of the rows' weights.
    weights: Vec<f64>,
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
    /// the former may lead away, however small `d` is.
    pub fn local_changes(&self, d: &[f64]) -> Option<[DVector<f64>; 2]> {
        let own = DVector::from_iterator(self.columns.len(), self.columns.iter().map(|&c| d[c]));
        let follows = -(&self.coupling * own);
        let whole = self
            .local
            .solve_upper_triangular(&(&follows - &self.local_right))?;
        Some([whole, self.local.solve_upper_triangular(&follows)?])
    }

    /// Best change of the segment's own unknowns near by, where the residuals are `r`, and by
    /// how much it should lower their squares.
    pub fn correction(&self, r: &[f64]) -> Option<(DVector<f64>, f64)> {
        let weighted = self.weights.iter().zip(r).map(|(w, r)| w * r);
        let right = DVector::from_iterator(r.len(), weighted);
        let along = self
            .local
            .tr_solve_upper_triangular(&self.own.tr_mul(&right))?;
        Some((
            -self.local.solve_upper_triangular(&along)?,
            along.norm_squared(),
        ))
    }
}

/// A segment's linearized residuals, weighted.
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
    /// Steps in which the segment was simulated, for what is to be compared with it.
    pub pace: StepSequence,
}

/// A simulator that is a step away in one parameter.
struct PerturbedSimulator {
    parameter: usize,
    step: f64,
    simulator: StretchSimulator,
    /// The effects' states at the segments' starts.
    states: Vec<Vec<f64>>,
}

/// What a segment's Jacobian is made with.
#[derive(Clone, Copy)]
struct LinearizationPoint<'a> {
    /// The segment's number.
    index: usize,
    base: &'a StretchSimulator,
    /// The effects' states at its start.
    states: &'a [f64],
    /// One for each parameter that may move.
    moved: &'a [PerturbedSimulator],
    locked: &'a [usize],
}

/// Whether two devices' effects are left alike by the same drive and motion: they feel the
/// voltage, its gain and the film, and nothing of the structure.
fn same_states(a: &Model, b: &Model) -> bool {
    let film = [ParameterId::Cs, ParameterId::Gp, ParameterId::Dp];
    let same = |id: ParameterId| a.parameters[id] == b.parameters[id];
    a.effects == b.effects && a.piezo == b.piezo && film.into_iter().all(same)
}

impl Problem {
    /// Linearizes the segments that are used at unknowns `x`, in all of these but the `locked`
    /// ones; `None` for the other segments and for those that cannot be simulated.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense at `x`.
    pub fn linearize(
        &self,
        x: &[f64],
        segments: &[Segment],
        used: &[bool],
        huber: Huber,
        locked: &[usize],
    ) -> Result<Vec<Option<Reduced>>, SimError> {
        self.each(x, (segments, used), locked, |segment, around| {
            self.reduce(x, segment, huber, around)
        })
    }

    /// The segments' Jacobians at unknowns `x`, none of them locked, as [`Self::linearize`]
    /// uses them.
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
        self.each(x, (segments, used), &[], |segment, around| {
            self.jacobian(x, segment, huber, around)
        })
    }

    /// Calls `make` for each segment that is used, with the simulator at `x` and those a
    /// step away in each parameter that is not locked.
    fn each<T: Send>(
        &self,
        x: &[f64],
        (segments, used): (&[Segment], &[bool]),
        locked: &[usize],
        make: impl Fn(&Segment, LinearizationPoint<'_>) -> Option<T> + Sync,
    ) -> Result<Vec<Option<T>>, SimError> {
        let base = self.simulator(x)?;
        let seen = self.unseen();
        let states = self.states_seen(x, &base, segments, &seen);
        let model = self.space.model(x);
        let entries = self.space.entries.par_iter().enumerate();
        let free = entries.filter(|(j, _)| !locked.contains(j));
        let moved = free.map(|(j, entry)| {
            let mut there = x.to_vec();
            there[j] += if there[j] + COORDINATE_STEP > entry.high {
                -COORDINATE_STEP
            } else {
                COORDINATE_STEP
            };
            let step = there[j] - x[j];
            let simulator = self.simulator(&there)?;
            // Most parameters have no bearing on what the drive leaves in the effects.
            let states = if same_states(&self.space.model(&there), &model) {
                states.clone()
            } else {
                self.states_seen(x, &simulator, segments, &seen)
            };
            Ok(PerturbedSimulator {
                parameter: j,
                step,
                simulator,
                states,
            })
        });
        let moved = moved.collect::<Result<Vec<_>, SimError>>()?;
        let one = |(index, segment): (usize, &Segment)| {
            let around = LinearizationPoint {
                index,
                base: &base,
                states: &states[index],
                moved: &moved,
                locked,
            };
            used[index].then(|| make(segment, around)).flatten()
        };
        Ok(segments.par_iter().enumerate().map(one).collect())
    }

    fn reduce(
        &self,
        x: &[f64],
        segment: &Segment,
        huber: Huber,
        around: LinearizationPoint<'_>,
    ) -> Option<Reduced> {
        let Jacobian {
            columns,
            mut matrix,
            weights,
            locals: l,
            ..
        } = self.jacobian(x, segment, huber, around)?;
        let (m, g) = (weights.len(), columns.len());
        let height = (m + l).max(l + g + 1);
        let own = matrix.columns(0, l).into_owned();
        matrix = matrix.resize_vertically(height, 0.0);
        for j in 0..l {
            let norm = matrix.column(j).norm().max(1e-12);
            matrix[(m.min(height - l) + j, j)] = LOCAL_RIDGE_SHARE * norm;
        }
        let upper = matrix.qr().unpack_r();
        Some(Reduced {
            columns,
            own,
            weights,
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
        around: LinearizationPoint<'_>,
    ) -> Option<Jacobian> {
        let LinearizationPoint { base, states, .. } = around;
        let nuisances = self.nuisances_of(x, segment.recording);
        let mut stretcher = Stretcher::new(base);
        let mut r0 = Vec::new();
        let locals = &segment.locals;
        stretcher.record_steps();
        if !self.evaluate(segment, states, &mut stretcher, &nuisances, locals, &mut r0) {
            return None;
        }
        let pace = stretcher.recorded_steps();
        let parameters = self.space.len();
        let own: Vec<usize> = (0..self.nuisances.len())
            .filter(|&i| self.nuisances[i].recording == segment.recording)
            .filter(|i| !around.locked.contains(&(parameters + i)))
            .collect();
        let mut columns: Vec<usize> = around.moved.iter().map(|m| m.parameter).collect();
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
            stretcher.replay_steps(&pace);
            if !self.evaluate(segment, states, &mut stretcher, &nuisances, &there, &mut r) {
                return None;
            }
            fill(j, &r, step);
            there[j] = locals[j];
        }
        for (k, moved) in around.moved.iter().enumerate() {
            let states = &moved.states[around.index];
            let mut stretcher = Stretcher::new(&moved.simulator);
            stretcher.replay_steps(&pace);
            if !self.evaluate(segment, states, &mut stretcher, &nuisances, locals, &mut r) {
                return None;
            }
            fill(l + k, &r, moved.step);
        }
        for (k, &i) in own.iter().enumerate() {
            let column = l + around.moved.len() + k;
            let step = 0.5;
            if self.shown_otherwise(
                &self.nuisances[i],
                segment,
                (base, &nuisances),
                step,
                (&r0, &mut r),
            ) {
                fill(column, &r, step);
                continue;
            }
            let mut there = x.to_vec();
            there[parameters + i] += step;
            let nuisances = self.nuisances_of(&there, segment.recording);
            stretcher.replay_steps(&pace);
            if !self.evaluate(segment, states, &mut stretcher, &nuisances, locals, &mut r) {
                return None;
            }
            fill(column, &r, step);
        }
        for i in 0..m {
            a[(i, l + g)] = weights[i] * r0[i];
        }
        Some(Jacobian {
            columns,
            matrix: a,
            weights,
            locals: l,
            pace,
        })
    }

    /// Writes to `r` what residuals `r0` become where an offset or a scale is a `step` larger,
    /// without simulating: `r0` and the present `nuisances` give the motion. False for other
    /// nuisances, and where the motion begins from a reading.
    fn shown_otherwise(
        &self,
        nuisance: &FreeNuisance,
        segment: &Segment,
        (simulator, nuisances): (&StretchSimulator, &Nuisances),
        step: f64,
        (r0, r): (&[f64], &mut Vec<f64>),
    ) -> bool {
        if begins_from_reading(segment, simulator) {
            return false;
        }
        let data = &self.data[segment.recording];
        let (recording, sigmas) = (&data.recording, &data.sigmas);
        let (xp, xc) = (Some(&recording.proof_mass), recording.cantilever.as_ref());
        let (row, readings, sigma, (offset, scale)) = match nuisance.what {
            Nuisance::OffsetP => (Row::ProofMass, xp, sigmas.xp, (1.0, None)),
            Nuisance::OffsetC => (Row::Cantilever, xc, sigmas.xc, (1.0, None)),
            Nuisance::ScaleP => (
                Row::ProofMass,
                xp,
                sigmas.xp,
                (nuisances.offset_p, Some(nuisances.scale_p)),
            ),
            Nuisance::ScaleC => (
                Row::Cantilever,
                xc,
                sigmas.xc,
                (nuisances.offset_c, Some(nuisances.scale_c)),
            ),
            Nuisance::Skew => return false,
        };
        let change = step * nuisance.unit;
        let rows = self.rows(segment);
        let first = rows.iter().position(|own| *own == row).unwrap_or(0);
        let finite = readings
            .into_iter()
            .flat_map(|all| &all[segment.samples.clone()]);
        let finite = finite.filter(|x| x.is_finite());
        // What is shown of the motion is the reading without the offset and what is left.
        let mut moved: Vec<f64> = match scale {
            None => finite.map(|_| -change / sigma).collect(),
            Some(scale) => finite
                .map(|x| -change / scale * (x - offset) / sigma)
                .collect(),
        };
        sigmas.colour.whiten(&mut moved);
        r.clear();
        r.extend_from_slice(r0);
        let left = scale.map_or(0.0, |scale| change / scale);
        for (r, moved) in r[first..].iter_mut().zip(moved) {
            *r += moved + left * *r;
        }
        true
    }
}

#[cfg(test)]
#[path = "linearize_tests.rs"]
mod tests;
