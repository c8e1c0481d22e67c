//! Simulates the reference curve (A) of a session again. The same input gives the same
//! curve, so a session stores only what the curve was computed from.

use std::sync::Arc;
use std::time::Instant;

use super::experiments::compare_all;
use super::request::SimulationRequest;
use super::snapshot::Snapshot;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::reference_curve::ReferenceCurve;
use crate::model::drive::Waveform;
use crate::sim::simulate;

/// Simulates the reference curve under `drive` and compares it with the recordings.
///
/// # Errors
/// Why it cannot be simulated.
pub fn run(
    curve: &ReferenceCurve,
    drive: Waveform,
    overlays: &[Overlay],
) -> Result<Arc<Snapshot>, String> {
    let started = Instant::now();
    let model = Arc::new(curve.preset.model.clone());
    let request = SimulationRequest {
        model: Arc::clone(&model),
        drive,
        duration: curve.duration,
        forces: false,
        overlays: Vec::new(),
        mode: Mode::WholeSpan,
        slow_down: 1.0,
        paused: false,
        scrub: None,
        restarts: 0,
        steps: 0,
    };
    let trace = simulate(&model, &request.drive, curve.duration, &request.options())
        .map_err(|error| error.to_string())?;
    let trace = Arc::new(trace);
    let compared = compare_all(&model, &request.drive, &trace, overlays);
    let mut snapshot = Snapshot::new(0, &model, Arc::clone(&trace), compared, started.elapsed());
    snapshot.run_of = Some((request.drive, curve.duration));
    Ok(Arc::new(snapshot))
}
