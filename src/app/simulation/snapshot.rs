//! A result of the simulator as the window draws it: immutable, shared behind `Arc`.

use std::sync::Arc;
use std::time::Duration;

use super::min_max_pyramid::Pyramid;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::recording::compare::{Comparison, compare};
use crate::recording::features::Features;
use crate::recording::{Channel, Grid};
use crate::sim::Trace;

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
    /// A run prepared for drawing; its features are added later.
    pub fn new(
        generation: u64,
        model: &Arc<Model>,
        trace: Arc<Trace>,
        overlays: &[Overlay],
        cost: Duration,
    ) -> Self {
        let pyramid = |values: &[f64]| Arc::new(Pyramid::new(trace.t0, trace.dt, values));
        Self {
            generation,
            model: Arc::clone(model),
            proof_mass_pyramid: pyramid(&trace.proof_mass),
            cantilever_pyramid: pyramid(&trace.cantilever),
            features: None,
            comparisons: overlays
                .iter()
                .filter(|overlay| overlay.visible)
                .map(|overlay| OverlayComparison::new(overlay, &trace))
                .collect(),
            cost,
            run_of: None,
            live: None,
            trace,
        }
    }
}

impl OverlayComparison {
    fn new(overlay: &Overlay, trace: &Trace) -> Self {
        let simulated = Grid {
            t0: trace.t0,
            dt: trace.dt,
            values: &trace.proof_mass,
            slopes: Some(&trace.proof_mass_velocity),
        };
        let recording = &overlay.recording;
        let comparison = compare(recording, Channel::ProofMass, &overlay.alignment, simulated);
        let residual_pyramid = comparison.as_ref().ok().map(|comparison| {
            let compared = comparison.first..comparison.first + comparison.residual.len();
            let times: Vec<f64> = recording.time[compared]
                .iter()
                .map(|&t| overlay.alignment.time(t))
                .collect();
            Arc::new(Pyramid::xy(&times, &comparison.residual))
        });
        Self {
            id: overlay.id,
            comparison: comparison.map(Arc::new).map_err(|error| error.to_string()),
            residual_pyramid,
            features: None,
        }
    }
}
