//! Features of the run and of the recordings. They take longer than the curves, so a
//! snapshot gets them later. A recording's features are computed once, on other threads.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use super::request::SimulationRequest;
use super::snapshot::Snapshot;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::app::setup::own_drive::OwnDrive;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::recording::features::{FeatureOptions, Features, features, recording_features};
use crate::recording::{Recording, TimeAxis};
use crate::sim::Trace;

/// What the period of a recording's features comes from.
#[derive(Debug, Clone, PartialEq)]
struct PeriodSource {
    drive: OwnDrive,
    /// Period of the simulation's drive \[s\], for a recording that is under it.
    shared: Option<f64>,
}

impl PeriodSource {
    fn of(overlay: &Overlay, request: &SimulationRequest) -> Self {
        let is_shared = request.model.piezo.is_some() && overlay.is_under_shared_drive();
        Self {
            drive: overlay.drive.clone(),
            shared: is_shared.then(|| request.drive.period()).flatten(),
        }
    }

    /// The period \[s\]; `None` if there is none.
    fn period(&self, recording: &Recording) -> Option<f64> {
        match &self.drive {
            OwnDrive::Chosen(waveform) => waveform.period(),
            OwnDrive::Shared => self.shared,
            OwnDrive::Measured(reading) => match recording.drive(*reading) {
                Some(drive) => drive.ok()?.period(),
                None => self.shared,
            },
        }
    }
}

/// Features of one recording.
#[derive(Debug)]
struct Entry {
    of: PeriodSource,
    /// `None` while they are being computed.
    features: Option<Arc<Features>>,
}

/// Features of recordings and of the last run.
pub struct FeatureCache {
    known: HashMap<OverlayId, Entry>,
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
        self.known.values().any(|entry| entry.features.is_none())
    }

    /// The snapshot with all features known now, or `None` if it has them already.
    pub fn complete(
        &mut self,
        mut snapshot: Snapshot,
        request: &SimulationRequest,
    ) -> Option<Snapshot> {
        for (id, features) in self.done.try_iter() {
            if let Some(entry) = self.known.get_mut(&id) {
                entry.features = Some(features);
            }
        }
        for overlay in &request.overlays {
            self.ask(overlay, request);
        }
        let ready = self.known.values();
        let ready = ready.filter(|entry| entry.features.is_some()).count();
        if self.finished == Some((snapshot.generation, ready)) {
            return None;
        }
        if self.finished.is_none_or(|(g, _)| g != snapshot.generation) {
            snapshot.features = Some(Arc::new(simulated_features(&snapshot, request)));
        }
        for comparison in &mut snapshot.comparisons {
            let known = self.known.get(&comparison.id);
            comparison.features = known.and_then(|entry| entry.features.clone());
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

    fn ask(&mut self, overlay: &Overlay, request: &SimulationRequest) {
        let of = PeriodSource::of(overlay, request);
        if let Some(entry) = self.known.get(&overlay.id)
            // What is being computed ends first, so that a drag starts no crowd of computations.
            && (entry.of == of || entry.features.is_none())
        {
            return;
        }
        let features = None;
        let entry = Entry {
            of: of.clone(),
            features,
        };
        self.known.insert(overlay.id, entry);
        let recording: Arc<Recording> = Arc::clone(&overlay.recording);
        let (id, send) = (overlay.id, self.send.clone());
        let repaint = (self.repaint)();
        rayon::spawn(move || {
            let options = FeatureOptions {
                period: of.period(&recording),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::files::built_in;
    use crate::app::simulation::worker::tests::request;
    use crate::model::drive::DriveReading;
    use crate::sim::simulate;

    /// The period of the first recording's features \[s\].
    fn period(cache: &mut FeatureCache, request: &SimulationRequest, generation: u64) -> f64 {
        let (model, drive) = (&request.model, &request.drive);
        let trace = simulate(model, drive, request.duration, &request.options());
        let trace = Arc::new(trace.unwrap());
        let compared = crate::app::simulation::experiments::compare_all(
            model,
            drive,
            &trace,
            &request.overlays,
        );
        let shown = Snapshot::new(generation, model, trace, compared, Duration::ZERO);
        let begun = Instant::now();
        loop {
            let complete = cache.complete(shown.clone(), request);
            let features = complete.and_then(|c| c.comparisons[0].features.clone());
            if let Some(features) = features {
                return features.period.clone().unwrap();
            }
            assert!(cache.is_waiting() && begun.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn the_period_of_features_is_that_of_the_chosen_drive() {
        let mut setup = built_in::setup();
        setup.overlays.truncate(1);
        let mut request = request(&setup);
        request.drive = Waveform::parse("square:20Hz:8V", 0.1).unwrap();
        let recording = Arc::clone(&request.overlays[0].recording);
        let recognised = recording.drive(DriveReading::Recognised).unwrap().unwrap();
        let own = recognised.period().unwrap();
        let mut cache = FeatureCache::new(|| {});
        assert_eq!(period(&mut cache, &request, 1), own);
        let chosen = Waveform::parse("square:25Hz:8V", 0.1).unwrap();
        request.overlays[0].drive = OwnDrive::Chosen(chosen);
        assert_eq!(period(&mut cache, &request, 2), 1.0 / 25.0);
        request.overlays[0].drive = OwnDrive::Shared;
        assert_eq!(period(&mut cache, &request, 3), 1.0 / 20.0);
        request.overlays[0].drive = OwnDrive::default();
        assert_eq!(period(&mut cache, &request, 4), own);
    }
}
