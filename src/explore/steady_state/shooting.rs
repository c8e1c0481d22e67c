//! Newton's method on the stroboscopic map, and the multipliers of the map.

use nalgebra::{Complex, DMatrix, DVector};

use super::coordinates::Scale;
use super::error::SteadyError;
use super::stroboscope::{PeriodRecord, Stroboscope};
use crate::sim::MotionState;

/// Step of a one-sided difference, as a share of the response: its error goes by the step, that of
/// the simulation by its reciprocal.
const NEWTON_DIFFERENCE: f64 = 1e-5;
/// Step of a central difference: its error goes by the square.
const MULTIPLIER_DIFFERENCE: f64 = 1e-4;
/// Newton steps at most.
const MAX_NEWTON_STEPS: usize = 12;
/// A step that leaves more than this share of the residual needs a new Jacobian.
const SLOW_CONVERGENCE: f64 = 0.1;
/// A step that leaves more than this share has failed.
const NO_CONVERGENCE: f64 = 0.9;
/// Longest step, as a share of the response: farther away another response may lie.
const LONGEST_STEP: f64 = 1.0;

/// A fixed point of the map of several periods.
#[derive(Debug, Clone)]
pub(super) struct FixedPoint {
    pub start: MotionState,
    pub records: Vec<PeriodRecord>,
    pub end: MotionState,
    pub residual: f64,
}

impl FixedPoint {
    /// The same as one of fewer periods, where it is one within `tolerance`.
    pub fn of_fewest_periods(mut self, scale: &Scale, tolerance: f64) -> Self {
        let n = self.records.len();
        let divisors = (1..n).filter(|m| n.is_multiple_of(*m));
        for m in divisors {
            let end = self.records[m].start.clone();
            let residual = scale.distance(&self.start, &end);
            if residual <= tolerance {
                self.records.truncate(m);
                return Self {
                    residual,
                    end,
                    ..self
                };
            }
        }
        self
    }
}

/// Why the map has no Jacobian at a state, or an end of the work.
pub(super) enum NoJacobian {
    /// Another sequence of events, or another phase, beside it.
    NotSmooth,
    Failed(SteadyError),
}

impl From<SteadyError> for NoJacobian {
    fn from(error: SteadyError) -> Self {
        Self::Failed(error)
    }
}

/// The map of `multiple` periods near one state.
pub(super) struct LocalMap<'a> {
    pub stroboscope: &'a mut Stroboscope,
    pub scale: &'a Scale,
    pub multiple: usize,
}

impl LocalMap<'_> {
    /// Coordinates of a state in which the map can be differentiated.
    fn pack(
        &self,
        state: &MotionState,
        records: &[PeriodRecord],
    ) -> Result<DVector<f64>, NoJacobian> {
        let ends = records.iter().any(PeriodRecord::has_release);
        let packed = self.scale.pack(state, ends).ok_or(NoJacobian::NotSmooth)?;
        Ok(DVector::from_vec(packed))
    }

    /// The state beside `at` by `step` of coordinate `i`, mapped.
    fn beside(
        &mut self,
        at: &MotionState,
        packed: &DVector<f64>,
        records: &[PeriodRecord],
        (i, step): (usize, f64),
    ) -> Result<DVector<f64>, NoJacobian> {
        let mut moved = packed.clone();
        moved[i] += step;
        let state = self.scale.unpack(moved.as_slice(), at);
        let (others, end) = self.stroboscope.map(&state, self.multiple)?;
        let same = records.iter().zip(&others).all(|(a, b)| a.has_events_of(b));
        let mapped = self.pack(&end, &others)?;
        if same && mapped.len() == packed.len() {
            Ok(mapped)
        } else {
            Err(NoJacobian::NotSmooth)
        }
    }

    /// Jacobian at `start`, which goes over to `end`, by one-sided differences or by central ones.
    fn jacobian(
        &mut self,
        start: &MotionState,
        records: &[PeriodRecord],
        end: &MotionState,
        central: bool,
    ) -> Result<DMatrix<f64>, NoJacobian> {
        let from = self.pack(start, records)?;
        let to = self.pack(end, records)?;
        let n = from.len();
        if to.len() != n {
            return Err(NoJacobian::NotSmooth);
        }
        let mut jacobian = DMatrix::zeros(n, n);
        for i in 0..n {
            let column = if central {
                let d = MULTIPLIER_DIFFERENCE;
                let above = self.beside(start, &from, records, (i, d))?;
                let below = self.beside(start, &from, records, (i, -d))?;
                (above - below) / (2.0 * d)
            } else {
                let d = NEWTON_DIFFERENCE;
                (self.beside(start, &from, records, (i, d))? - &to) / d
            };
            jacobian.set_column(i, &column);
        }
        Ok(jacobian)
    }

    /// The fixed point to which Newton's method leads from `guess`, if it does so surely.
    ///
    /// # Errors
    /// Those of the simulation.
    pub fn fixed_point(
        &mut self,
        guess: &MotionState,
        tolerance: f64,
    ) -> Result<Option<FixedPoint>, SteadyError> {
        match self.newton(guess, tolerance) {
            Ok(found) => Ok(found),
            Err(NoJacobian::NotSmooth) => Ok(None),
            Err(NoJacobian::Failed(error)) => Err(error),
        }
    }

    fn newton(
        &mut self,
        guess: &MotionState,
        tolerance: f64,
    ) -> Result<Option<FixedPoint>, NoJacobian> {
        let mut start = guess.clone();
        let (mut records, mut end) = self.stroboscope.map(&start, self.multiple)?;
        let mut residual = self.scale.distance(&start, &end);
        let mut jacobian: Option<DMatrix<f64>> = None;
        for _ in 0..MAX_NEWTON_STEPS {
            let own = match jacobian.take() {
                Some(known) => known,
                None => self.jacobian(&start, &records, &end, false)?,
            };
            let (from, to) = (self.pack(&start, &records)?, self.pack(&end, &records)?);
            let system = DMatrix::identity(from.len(), from.len()) - &own;
            let Some(step) = system.lu().solve(&(to - &from)) else {
                return Ok(None);
            };
            let length = step.norm();
            if length.is_nan() || length > LONGEST_STEP {
                return Ok(None);
            }
            let next = self.scale.unpack((from + step).as_slice(), &start);
            let (others, reached) = self.stroboscope.map(&next, self.multiple)?;
            let left = self.scale.distance(&next, &reached);
            let same = records.iter().zip(&others).all(|(a, b)| a.has_events_of(b));
            if left <= tolerance {
                return Ok(Some(FixedPoint {
                    start: next,
                    records: others,
                    end: reached,
                    residual: left,
                }));
            }
            if !same || left.is_nan() || left >= NO_CONVERGENCE * residual {
                return Ok(None);
            }
            jacobian = (left < SLOW_CONVERGENCE * residual).then_some(own);
            (start, records, end, residual) = (next, others, reached, left);
        }
        Ok(None)
    }

    /// Multipliers at a fixed point in falling order of their modulus; `None` where the map is not
    /// smooth.
    ///
    /// # Errors
    /// Those of the simulation.
    pub fn multipliers(
        &mut self,
        start: &MotionState,
        records: &[PeriodRecord],
        end: &MotionState,
    ) -> Result<Option<Vec<Complex<f64>>>, SteadyError> {
        match self.jacobian(start, records, end, true) {
            Ok(jacobian) => {
                let mut all: Vec<_> = jacobian.complex_eigenvalues().iter().copied().collect();
                all.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
                Ok(Some(all))
            }
            Err(NoJacobian::NotSmooth) => Ok(None),
            Err(NoJacobian::Failed(error)) => Err(error),
        }
    }
}
