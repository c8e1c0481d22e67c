//! The window's side of the thread for kept curves: asks for their numbers, takes the results and
//! says which curve cannot be shown.

use std::sync::Arc;

use crate::app::services::Services;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::kept_curve::{KeptCurve, RunOrigin, same_origin};
use crate::app::simulation::kept::{KeptRequest, KeptRun, KeptTask, KeptWorker};

/// Connection to the thread, which is started for the first curve.
pub(super) struct KeptCurves {
    worker: Option<KeptWorker>,
    repaint: Box<dyn Fn() -> Box<dyn Fn() + Send>>,
    /// The last request sent.
    sent: Option<KeptRequest>,
    /// Curves that the person knows cannot be shown.
    reported: Vec<Arc<RunOrigin>>,
}

impl KeptCurves {
    /// No curve yet. `repaint` is called when a result is there.
    pub(super) fn new(repaint: impl Fn() + Send + Clone + 'static) -> Self {
        Self {
            worker: None,
            repaint: Box::new(move || Box::new(repaint.clone())),
            sent: None,
            reported: Vec::new(),
        }
    }

    /// Called once a frame. `all_read`: no recording of a session is still to come, so that a
    /// missing one is really missing.
    pub(super) fn update(&mut self, services: &mut Services, all_read: bool) {
        let results = self.worker.as_ref().map(KeptWorker::results);
        for run in results.into_iter().flatten() {
            self.take(services, run);
        }
        forget_removed(services);
        if all_read {
            self.request(services);
        }
    }

    /// Takes a result, unless its curve was removed meanwhile.
    fn take(&mut self, services: &mut Services, run: KeptRun) {
        let kept = &services.state.setup.kept;
        let Some(curve) = kept.iter().find(|c| same_origin(&c.origin, &run.origin)) else {
            return;
        };
        let was_reported = self.reported.iter().any(|o| same_origin(o, &run.origin));
        match &run.run {
            Err(reason) if !was_reported => {
                self.reported.push(Arc::clone(&run.origin));
                let text = format!("The kept curve {:?} cannot be shown: {reason}", curve.name);
                services.fail(text);
            }
            Err(_) => {}
            Ok(_) => self.reported.retain(|o| !same_origin(o, &run.origin)),
        }
        services.state.kept_runs.put(run);
    }

    /// Asks for the numbers of all curves, if curves or recordings have changed.
    fn request(&mut self, services: &mut Services) {
        let state = &services.state;
        let can_be_simulated = |curve: &&KeptCurve| curve.origin.live.is_none();
        let lasting = state.setup.kept.iter().filter(can_be_simulated);
        let curves: Vec<KeptTask> = lasting
            .map(|curve| KeptTask {
                origin: Arc::clone(&curve.origin),
                known: state.kept_runs.drawn(&curve.origin).cloned(),
            })
            .collect();
        if self.worker.is_none() && curves.is_empty() {
            return;
        }
        let overlays = state.setup.overlays.clone();
        let request = KeptRequest { curves, overlays };
        if self.sent.as_ref() == Some(&request) {
            return;
        }
        // What was sent is only compared with; it need not keep runs alive.
        let mut sent = request.clone();
        for task in &mut sent.curves {
            task.known = None;
        }
        self.sent = Some(sent);
        if self.worker.is_none() {
            match KeptWorker::start((self.repaint)()) {
                Ok(worker) => self.worker = Some(worker),
                Err(error) => {
                    let text = format!(
                        "No thread for the kept curves could be started: {error}; close other programs and keep a curve again"
                    );
                    return services.fail(text);
                }
            }
        }
        if let Some(worker) = &self.worker {
            worker.send(request);
        }
    }
}

/// Forgets the runs of curves that are gone. A live one cannot be computed again: it is kept as
/// long as undo can bring its curve back.
fn forget_removed(services: &mut Services) {
    let Services { state, history, .. } = services;
    let setup = &state.setup;
    let has = |setup: &Setup, origin: &Arc<RunOrigin>| {
        let mut kept = setup.kept.iter();
        kept.any(|curve| same_origin(&curve.origin, origin))
    };
    state.kept_runs.retain(|origin| {
        has(setup, origin) || (origin.live.is_some() && history.holds(|before| has(before, origin)))
    });
}
