//! What the worker hands to the window: immutable, behind `Arc`.

use std::sync::Arc;
use std::time::Duration;

use crate::model::Model;
use crate::recording::compare::Comparison;
use crate::recording::features::Features;
use crate::sim::Trace;

use super::plots::pyramid::Pyramid;
use super::setup::OverlayId;

/// A simulated run with everything that is drawn of it.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// Counts up with every result.
    pub generation: u64,
    /// The model it was computed with (the last good one).
    pub model: Arc<Model>,
    /// The run. Forces are recorded when the picture asks for them.
    pub trace: Arc<Trace>,
    /// Decimation of `trace.proof_mass` and `trace.cantilever` for drawing.
    pub proof_mass_pyramid: Arc<Pyramid>,
    /// Empty for a device without that point.
    pub cantilever_pyramid: Arc<Pyramid>,
    /// Features of the simulated run, per period.
    pub features: Arc<Features>,
    /// One for each visible recording.
    pub comparisons: Vec<OverlayComparison>,
    /// What the run cost.
    pub cost: Duration,
    /// Set in Live mode.
    pub live: Option<LiveState>,
}

/// A recording against the run.
#[derive(Debug, Clone)]
pub struct OverlayComparison {
    /// Which recording.
    pub id: OverlayId,
    /// Residual with rms and NRMSE, or why there is none.
    pub comparison: Result<Arc<Comparison>, String>,
    /// Decimated residual for drawing: `(time [s], residual [m])` pyramid.
    pub residual_pyramid: Option<Arc<Pyramid>>,
    /// The recording's own features, or why there are none.
    pub features: Arc<Features>,
}

/// Where a live run stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveState {
    /// Simulated time reached [s].
    pub time: f64,
    /// Oldest time that can be scrubbed to [s].
    pub history_start: f64,
    /// Simulated seconds per wall second really reached.
    pub speed: f64,
    /// Whether it stands still.
    pub paused: bool,
}
