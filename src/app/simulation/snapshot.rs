//! A result of the simulator as the window draws it: immutable, shared behind `Arc`.

use std::sync::Arc;
use std::time::Duration;

use super::min_max_pyramid::Pyramid;
use crate::app::setup::overlay::OverlayId;
use crate::diagnose::StretchMisfit;
use crate::fit::experiment::total_misfit;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::recording::align::Alignment;
use crate::recording::compare::Comparison;
use crate::recording::features::Features;
use crate::sim::{StartState, Trace};

/// A simulated run with everything that is drawn from it.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// Counts up with every result.
    pub generation: u64,
    /// The model it was computed with (the last valid one).
    pub model: Arc<Model>,
    /// The run. Forces are recorded when the picture asks for them.
    pub trace: Arc<Trace>,
    /// `trace.proof_mass` decimated for drawing.
    pub proof_mass_pyramid: Arc<Pyramid>,
    /// `trace.cantilever` decimated; empty for a device without that point.
    pub cantilever_pyramid: Arc<Pyramid>,
    /// Features of the simulated run, per period, once they are computed.
    pub features: Option<Arc<Features>>,
    /// One for each visible recording.
    pub comparisons: Vec<OverlayComparison>,
    /// Computing time.
    pub cost: Duration,
    /// Drive and span \[s\] of a run that starts at rest and can be repeated; a live one
    /// cannot.
    pub run_of: Option<(Waveform, f64)>,
    /// Set in Live mode.
    pub live: Option<LiveState>,
}

/// A recording compared with the run.
#[derive(Debug, Clone)]
pub struct OverlayComparison {
    /// Which recording.
    pub id: OverlayId,
    /// Residual with rms and NRMSE, or why there is none.
    pub comparison: Result<Arc<Comparison>, String>,
    /// Decimated residual for drawing: `(time [s], residual [m])` pyramid.
    pub residual_pyramid: Option<Arc<Pyramid>>,
    /// The recording's own features, once they are computed.
    pub features: Option<Arc<Features>>,
    /// Shift, scales and zeros that it was compared with, those estimated included.
    pub alignment: Alignment,
    /// Noise of the proof mass on the scale of the comparison \[m\]; `None` if it has none.
    pub noise: Option<f64>,
    /// What drives its own run, in words.
    pub drive_text: Option<String>,
    /// Its own run; `None` if it was compared with the simulation itself.
    pub own: Option<OwnRun>,
    /// The misfit over its stretches or why there is none, once it is computed.
    pub stretches: Option<Result<StretchMisfit, String>>,
}

/// The run of a recording under its own drive.
#[derive(Debug, Clone)]
pub struct OwnRun {
    /// The drive; its t = 0 is the recording's first time.
    pub drive: Waveform,
    /// The state in which it begins; `None` for that of the device, at rest unless it has `x0` or
    /// `v0`.
    pub start: Option<StartState>,
    /// By how much the drive may lie earlier or later, see `InstrumentPriors::drive_reach` \[s\].
    pub drive_reach: f64,
    /// The run.
    pub trace: Arc<Trace>,
    /// `trace.proof_mass` decimated for drawing.
    pub proof_mass_pyramid: Arc<Pyramid>,
    /// `trace.cantilever` decimated; empty for a device without that point.
    pub cantilever_pyramid: Arc<Pyramid>,
}

impl OwnRun {
    /// Prepares a run for drawing.
    pub fn new(drive: Waveform, start: Option<StartState>, trace: &Arc<Trace>) -> Self {
        let pyramid = |values: &[f64]| Arc::new(Pyramid::new(trace.t0, trace.dt, values));
        Self {
            drive,
            start,
            drive_reach: 0.0,
            proof_mass_pyramid: pyramid(&trace.proof_mass),
            cantilever_pyramid: pyramid(&trace.cantilever),
            trace: Arc::clone(trace),
        }
    }
}

impl OwnRun {
    /// With a drive whose instants are known to `reach` \[s\].
    pub fn known_to(mut self, reach: f64) -> Self {
        self.drive_reach = reach;
        self
    }
}

impl OverlayComparison {
    /// Residual in units of the noise.
    pub fn misfit(&self) -> Option<f64> {
        let comparison = self.comparison.as_ref().ok()?;
        Some(comparison.rms / self.noise?)
    }
}

/// How far a live run is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveState {
    /// Simulated time reached \[s\]. While scrubbing, the trace ends earlier.
    pub time: f64,
    /// Oldest time that can be scrubbed to \[s\].
    pub history_start: f64,
    /// Simulated seconds per wall second, as measured.
    pub speed: f64,
    /// Whether it is paused.
    pub paused: bool,
}

impl Snapshot {
    /// The total misfit of all compared recordings, in units of their noise.
    pub fn total_misfit(&self) -> Option<f64> {
        let parts: Vec<(f64, usize)> = self
            .comparisons
            .iter()
            .filter_map(|c| Some((c.misfit()?, c.comparison.as_ref().ok()?.count)))
            .collect();
        total_misfit(&parts)
    }

    /// The same over the stretches; `None` until all are computed, or if one has none.
    pub fn total_stretch_misfit(&self) -> Option<f64> {
        let compared = self.comparisons.iter().filter(|c| c.misfit().is_some());
        let parts: Option<Vec<(f64, usize)>> = compared
            .map(|c| {
                let all = c.stretches.as_ref()?.as_ref().ok()?;
                Some((all.distance.rms / all.noise, all.samples))
            })
            .collect();
        total_misfit(&parts?)
    }

    /// A run prepared for drawing; its features are added later.
    pub fn new(
        generation: u64,
        model: &Arc<Model>,
        trace: Arc<Trace>,
        comparisons: Vec<OverlayComparison>,
        cost: Duration,
    ) -> Self {
        let pyramid = |values: &[f64]| Arc::new(Pyramid::new(trace.t0, trace.dt, values));
        Self {
            generation,
            model: Arc::clone(model),
            proof_mass_pyramid: pyramid(&trace.proof_mass),
            cantilever_pyramid: pyramid(&trace.cantilever),
            features: None,
            comparisons,
            cost,
            run_of: None,
            live: None,
            trace,
        }
    }
}
