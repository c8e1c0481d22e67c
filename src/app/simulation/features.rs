//! Features of the run and of the recordings. They take longer than the curves, so a
//! snapshot gets them later. A recording's features are computed once, on other threads.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use super::request::SimulationRequest;
use super::snapshot::Snapshot;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::model::Model;
use crate::model::drive::{DriveReading, Waveform};
use crate::model::parameter::ParameterId;
use crate::recording::features::{FeatureOptions, Features, features, recording_features};
use crate::recording::{Recording, TimeAxis};
use crate::sim::Trace;

/// Features of recordings and of the last run.
pub struct FeatureCache {
    known: HashMap<OverlayId, Option<Arc<Features>>>,
    done: Receiver<(OverlayId, Arc<Features>)>,
    send: Sender<(OverlayId, Arc<Features>)>,
    repaint: Box<dyn Fn() -> Box<dyn Fn() + Send> + Send>,
    /// Generation whose features are complete, and how many recordings were ready then.
    finished: Option<(u64, usize)>,
    /// Features of the live run, and when they were computed.
    live: Option<(Instant, Arc<Features>)>,
}

/// Time between two computations of the features of a moving live run. More often would
/// slow the run down.
const LIVE_FEATURE_INTERVAL: Duration = Duration::from_millis(500);

impl FeatureCache {
    /// `repaint` is called when a recording's features are ready.
    pub fn new(repaint: impl Fn() + Send + Clone + 'static) -> Self {
        let (send, done) = channel();
        Self {
            known: HashMap::new(),
            done,
            send,
            repaint: Box::new(move || Box::new(repaint.clone())),
            finished: None,
            live: None,
        }
    }

    /// Whether features of a recording are still being computed.
    pub fn is_waiting(&self) -> bool {
        self.known.values().any(Option::is_none)
    }

    /// The snapshot with all features known now, or `None` if it has them already.
    pub fn complete(
        &mut self,
        mut snapshot: Snapshot,
        request: &SimulationRequest,
    ) -> Option<Snapshot> {
        for (id, features) in self.done.try_iter() {
            self.known.insert(id, Some(features));
        }
        for overlay in &request.overlays {
            self.ask(overlay);
        }
        let ready = self.known.values().flatten().count();
        if self.finished == Some((snapshot.generation, ready)) {
            return None;
        }
        if self.finished.is_none_or(|(g, _)| g != snapshot.generation) {
            snapshot.features = Some(Arc::new(simulated_features(&snapshot, request)));
        }
        for comparison in &mut snapshot.comparisons {
            comparison.features = self.known.get(&comparison.id).cloned().flatten();
        }
        self.finished = Some((snapshot.generation, ready));
        Some(snapshot)
    }

    /// Adds the features of the visible part of a live run. While it moves, those of a moment
    /// ago are reused.
    pub fn follow(&mut self, snapshot: &mut Snapshot, request: &SimulationRequest, still: bool) {
        let recent = self
            .live
            .take()
            .filter(|(at, _)| !still && at.elapsed() < LIVE_FEATURE_INTERVAL);
        let found = recent.unwrap_or_else(|| {
            (
                Instant::now(),
                Arc::new(simulated_features(snapshot, request)),
            )
        });
        snapshot.features = Some(Arc::clone(&found.1));
        self.live = Some(found);
    }

    fn ask(&mut self, overlay: &Overlay) {
        if self.known.contains_key(&overlay.id) {
            return;
        }
        self.known.insert(overlay.id, None);
        let recording: Arc<Recording> = Arc::clone(&overlay.recording);
        let (id, send) = (overlay.id, self.send.clone());
        let repaint = (self.repaint)();
        rayon::spawn(move || {
            let drive = recording
                .drive(DriveReading::Recognised)
                .and_then(Result::ok);
            let options = FeatureOptions {
                period: drive.and_then(|drive| drive.period()),
                ..FeatureOptions::default()
            };
            let features = recording_features(&recording, &options);
            // The worker may have ended meanwhile.
            let _ = send.send((id, Arc::new(features)));
            repaint();
        });
    }
}

/// Features of a simulated run, with the noise of its sensor.
fn simulated_features(snapshot: &Snapshot, request: &SimulationRequest) -> Features {
    features_of_run(&snapshot.trace, &request.model, &request.drive)
}

/// Features of a run of `model` under `drive`, with the noise of its sensor.
pub(super) fn features_of_run(trace: &Trace, model: &Model, drive: &Waveform) -> Features {
    let options = FeatureOptions {
        contact_level: trace.ground_level,
        period: drive.period(),
        noise: Some(model.parameters[ParameterId::Noise]),
        ..FeatureOptions::default()
    };
    features(
        TimeAxis::Uniform {
            t0: trace.t0,
            dt: trace.dt,
        },
        Some(&trace.voltage),
        &trace.proof_mass,
        &options,
    )
}
