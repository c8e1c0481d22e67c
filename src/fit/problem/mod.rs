//! The least-squares problem. Recordings are cut into segments; parameters and nuisances form one
//! vector; each segment's residuals are linearized with its own unknowns eliminated.

pub mod huber;
pub(crate) mod linearize;
mod measured_motion;
pub mod parameter_space;
pub mod prepare;
pub(crate) mod prior_rows;
pub(crate) mod segment_fit;

pub use self::linearize::{COORDINATE_STEP, Jacobian, Reduced};
pub use self::segment_fit::MAX_REUSE_COST_PER_ROW;

use std::sync::Arc;

use rayon::prelude::*;

use self::measured_motion::{Motion, MotionCache};
use self::parameter_space::Space;
use super::residual::residual_rows::{Nuisances, Row, SegmentContext, Sigmas, rows};
use super::segment::Segment;
use super::segment::voltage_track::Track;
use crate::fit::residual::residuals::residuals;
use crate::model::preset::known_value::KnownValue;
use crate::recording::Recording;
use crate::sim::{Options, SimError, StretchSimulator, Stretcher};

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

/// A free nuisance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeNuisance {
    /// Of which recording.
    pub recording: usize,
    /// Which.
    pub what: Nuisance,
    /// SI value of one unit.
    pub unit: f64,
    /// Mean of its prior \[SI\], and the standard deviation; infinite without a prior.
    pub mean: f64,
    /// See `mean`.
    pub sigma: f64,
}

impl FreeNuisance {
    /// Whether single ones may lie far beyond their prior. A clock may be off by a mistake; a scale
    /// that may leave its prior takes what a missing force does.
    pub(crate) fn has_outliers(&self) -> bool {
        !matches!(self.what, Nuisance::ScaleP | Nuisance::ScaleC)
    }
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
    /// What is known of the parameters beforehand.
    pub known: Vec<KnownValue>,
    /// Tolerance of the simulations.
    pub options: Options,
}

impl Problem {
    /// Number of unknowns without the segments' own.
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

    /// Extra states of the effects at the start of each segment, if there are any. They follow from
    /// the measured motion, corrected by the nuisances at unknowns `x`: the film depends on the
    /// height of the mass, not on its reading.
    pub fn states(
        &self,
        x: &[f64],
        simulator: &StretchSimulator,
        segments: &[Segment],
    ) -> Vec<Vec<f64>> {
        self.states_seen(x, simulator, segments, &self.unseen())
    }

    /// An empty cache of the motion for each recording.
    fn unseen(&self) -> Vec<MotionCache> {
        self.data.iter().map(|_| MotionCache::default()).collect()
    }

    /// The same for one of several simulators that share the cache `seen` of the measured motion.
    fn states_seen(
        &self,
        x: &[f64],
        simulator: &StretchSimulator,
        segments: &[Segment],
        seen: &[MotionCache],
    ) -> Vec<Vec<f64>> {
        let count = simulator.state_rates().len();
        let mut out = vec![Vec::new(); segments.len()];
        if count == 0 {
            return out;
        }
        let of_recording = |(index, data): (usize, &Data)| {
            let own: Vec<usize> = (0..segments.len())
                .filter(|&i| segments[i].recording == index)
                .collect();
            let r = &data.recording;
            let times: Vec<f64> = own
                .iter()
                .map(|&i| r.time[segments[i].samples.start])
                .collect();
            let motion = Motion {
                recording: r,
                nuisances: self.nuisances_of(x, index),
                noise: data.sigmas.xp,
            };
            let reading = seen[index].reading(&motion);
            let motion = |t| reading.at(t);
            let states = simulator.states_from_drive(&data.track.pieces, &times, &motion);
            seen[index].keep(reading);
            (own, states)
        };
        let all: Vec<_> = self.data.par_iter().enumerate().map(of_recording).collect();
        for (own, states) in all {
            for (i, z) in own.into_iter().zip(states.chunks(count)) {
                out[i] = z.to_vec();
            }
        }
        out
    }

    /// Context of a segment.
    pub fn context<'a>(&'a self, segment: &Segment, states: &'a [f64]) -> SegmentContext<'a> {
        let data = &self.data[segment.recording];
        SegmentContext {
            recording: &data.recording,
            sigmas: &data.sigmas,
            states,
            epoch: data.epoch,
        }
    }

    /// Kinds of a segment's rows.
    pub fn rows(&self, segment: &Segment) -> Vec<Row> {
        rows(segment, &self.context(segment, &[]))
    }

    /// Writes the residuals of one segment to `out`; false if it cannot be simulated.
    pub fn evaluate(
        &self,
        segment: &Segment,
        states: &[f64],
        stretcher: &mut Stretcher<'_>,
        nuisances: &Nuisances,
        locals: &[f64],
        out: &mut Vec<f64>,
    ) -> bool {
        let context = self.context(segment, states);
        residuals(segment, &context, stretcher, nuisances, locals, out).is_ok()
            && out.iter().all(|r| r.is_finite())
    }
}
