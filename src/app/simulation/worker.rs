//! The thread that owns the simulator. The window sends complete requests; a new one
//! replaces one that has not been started, so that a slider drag never builds up a queue.
//! Results come back immutable, behind `Arc`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::experiments::{ExperimentCache, SharedRun};
use super::features::FeatureCache;
use super::live::Live;
use super::request::SimulationRequest;
use super::snapshot::{OverlayComparison, Snapshot};
use super::stretch_misfits::StretchMisfits;
use crate::app::analysis::explore::steady::steady_run;
use crate::app::analysis::job::panic_text;
use crate::app::setup::drive_choice::Mode;
use crate::sim::{SimError, Trace, simulate_while};

/// A run that takes longer is given up when something newer is requested. Shorter ones are
/// finished, so that a slider drag shows all its curves.
const MAX_OUTDATED_RUN: Duration = Duration::from_millis(500);

/// What the simulator thread reports.
#[derive(Debug, Clone)]
pub enum WorkerEvent {
    /// A new result.
    Snapshot(Arc<Snapshot>),
    /// The request cannot be simulated; the last result stays.
    Refused(SimError),
    /// Live: the device cannot be simulated any further; it is paused.
    Stopped(SimError),
    /// The simulator panicked; the text says where.
    Broken(String),
}

#[derive(Debug, Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    wake: Condvar,
    outbox: Mutex<Vec<WorkerEvent>>,
}

#[derive(Debug, Default)]
struct Inbox {
    request: Option<SimulationRequest>,
    quit: bool,
}

/// A poisoned lock only says that a panic happened elsewhere; the data is a plain slot.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The run of the whole span; `None` if `go_on` said no.
fn whole_span(
    request: &SimulationRequest,
    go_on: impl FnMut() -> bool,
) -> Result<Option<Trace>, SimError> {
    let (model, drive) = (&*request.model, &request.drive);
    let (duration, options) = (request.duration, request.options());
    if request.from_steady {
        return steady_run((model, drive), duration, &options, go_on);
    }
    simulate_while(model, drive, duration, &options, go_on)
}

/// Handle of the worker thread; ends it when dropped.
#[derive(Debug)]
pub struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread. `repaint` is called when there is an event.
    ///
    /// # Errors
    /// The system's, if no thread can be started.
    pub fn start(repaint: impl Fn() + Send + Clone + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("simulator".to_owned())
            .spawn(move || Engine::new(of_thread, repaint).run())?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Requests a result; replaces a request that has not been started.
    pub fn send(&self, request: SimulationRequest) {
        lock(&self.shared.inbox).request = Some(request);
        self.shared.wake.notify_one();
    }

    /// Events since the last call, oldest first.
    pub fn events(&self) -> Vec<WorkerEvent> {
        std::mem::take(&mut *lock(&self.shared.outbox))
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        lock(&self.shared.inbox).quit = true;
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // The thread catches its panics; there is nothing to report at the end.
            let _ = thread.join();
        }
    }
}

/// The thread's own state.
struct Engine<R> {
    shared: Arc<Shared>,
    repaint: R,
    features: FeatureCache,
    experiments: ExperimentCache,
    stretches: StretchMisfits,
    /// Generation whose drives were improved.
    improved: Option<u64>,
    live: Option<Live>,
    last: Option<SimulationRequest>,
    /// The last result and its request.
    shown: Option<(SimulationRequest, Arc<Snapshot>)>,
    generation: u64,
}

impl<R: Fn() + Send + Clone + 'static> Engine<R> {
    fn new(shared: Arc<Shared>, repaint: R) -> Self {
        Self {
            features: FeatureCache::new(repaint.clone()),
            stretches: StretchMisfits::new(repaint.clone()),
            shared,
            repaint,
            experiments: ExperimentCache::default(),
            improved: None,
            live: None,
            last: None,
            shown: None,
            generation: 0,
        }
    }

    fn run(mut self) {
        // While the device runs live the thread wakes for the next slice.
        let mut patience = None;
        loop {
            let Some(request) = self.next_request(patience) else {
                return;
            };
            let result = catch_unwind(AssertUnwindSafe(|| self.serve(request)));
            patience = result.unwrap_or_else(|panic| {
                self.live = None;
                self.last = None;
                self.post(WorkerEvent::Broken(panic_text(panic.as_ref())));
                None
            });
        }
    }

    /// Waits for a request: for ever, or at most `patience`. `None` ends the thread.
    #[allow(clippy::type_complexity)]
    fn next_request(&self, patience: Option<Duration>) -> Option<Option<SimulationRequest>> {
        let mut inbox = lock(&self.shared.inbox);
        loop {
            if inbox.quit {
                return None;
            }
            if let Some(request) = inbox.request.take() {
                return Some(Some(request));
            }
            match patience {
                Some(time) => {
                    let (mut inbox, _) = self
                        .shared
                        .wake
                        .wait_timeout(inbox, time)
                        .unwrap_or_else(PoisonError::into_inner);
                    return if inbox.quit {
                        None
                    } else {
                        Some(inbox.request.take())
                    };
                }
                None => {
                    inbox = self
                        .shared
                        .wake
                        .wait_timeout(inbox, Duration::from_secs(3600))
                        .unwrap_or_else(PoisonError::into_inner)
                        .0;
                }
            }
        }
    }

    fn post(&self, event: WorkerEvent) {
        let mut outbox = lock(&self.shared.outbox);
        // An event nobody has taken yet is replaced by a newer one of its kind.
        outbox.retain(|old| std::mem::discriminant(old) != std::mem::discriminant(&event));
        outbox.push(event);
        drop(outbox);
        (self.repaint)();
    }

    /// Serves a new request, or continues the last one. Returns how long to wait for the
    /// next request.
    fn serve(&mut self, request: Option<SimulationRequest>) -> Option<Duration> {
        let fresh = request.is_some();
        if let Some(request) = &request {
            self.stretches.cancel_unless_asked(request);
        }
        let request = request.or_else(|| self.last.clone())?;
        let patience = match request.mode {
            Mode::WholeSpan => {
                self.live = None;
                self.serve_whole_span(&request, fresh)
            }
            Mode::Live => self.serve_live(&request),
        };
        self.last = Some(request);
        patience
    }

    fn serve_whole_span(&mut self, request: &SimulationRequest, fresh: bool) -> Option<Duration> {
        let reuse = self
            .shown
            .as_ref()
            .filter(|(of, _)| of.mode == Mode::WholeSpan && of.same_run(request))
            .map(|(_, shown)| Arc::clone(shown));
        let snapshot = if let (Some(shown), false) = (&reuse, fresh) {
            shown.as_ref().clone()
        } else {
            let started = Instant::now();
            let shared_slot = Arc::clone(&self.shared);
            let trace = match &reuse {
                Some(shown) => Arc::clone(&shown.trace),
                None => {
                    let go_on = || Self::is_worth_finishing(&shared_slot, started);
                    match whole_span(request, go_on) {
                        Ok(Some(trace)) => Arc::new(trace),
                        // The newer request is in the inbox.
                        Ok(None) => return None,
                        Err(error) => {
                            self.post(WorkerEvent::Refused(error));
                            return None;
                        }
                    }
                }
            };
            let cost = match &reuse {
                Some(shown) => shown.cost,
                None => started.elapsed(),
            };
            let shared = SharedRun {
                model: &request.model,
                drive: &request.drive,
                trace: &trace,
            };
            let mut experiments = std::mem::take(&mut self.experiments);
            let go_on = || Self::is_worth_finishing(&shared_slot, started);
            let compared = experiments.compare(&request.model, shared, &request.overlays, go_on);
            self.experiments = experiments;
            // The newer request is in the inbox.
            let compared = compared?;
            self.generation += 1;
            let mut snapshot =
                Snapshot::new(self.generation, &request.model, trace, compared, cost);
            // A run that begins in the steady response is not that of its drive from rest.
            let of = || (request.drive.clone(), request.duration);
            snapshot.run_of = (!request.from_steady).then(of);
            self.show(request, snapshot.clone());
            snapshot
        };
        // The curve is sent first; its features follow, unless something newer is requested.
        if lock(&self.shared.inbox).request.is_some() {
            return None;
        }
        let snapshot = match self.improve(request, &snapshot) {
            Some(improved) => improved,
            None if lock(&self.shared.inbox).request.is_some() => return None,
            None => snapshot,
        };
        let snapshot = match self.features.complete(snapshot.clone(), request) {
            Some(complete) => {
                self.show(request, complete.clone());
                complete
            }
            None => snapshot,
        };
        if let Some(complete) = self.stretches.complete(&snapshot, request) {
            self.show(request, complete);
        }
        // Recordings' own features and misfits over stretches arrive from other threads.
        (self.features.is_waiting() || self.stretches.is_waiting())
            .then_some(Duration::from_millis(50))
    }

    /// Lets the readings decide what the recordings' voltages leave open of their drives, once for
    /// each result, and shows what is better by it.
    fn improve(&mut self, request: &SimulationRequest, snapshot: &Snapshot) -> Option<Snapshot> {
        if self.improved == Some(snapshot.generation) {
            return None;
        }
        let slot = Arc::clone(&self.shared);
        let go_on = || {
            let inbox = lock(&slot.inbox);
            !inbox.quit && inbox.request.is_none()
        };
        let (overlays, compared) = (&request.overlays, &snapshot.comparisons);
        let better = self
            .experiments
            .improve(&request.model, overlays, compared, go_on);
        if lock(&self.shared.inbox).request.is_some() {
            return None;
        }
        self.improved = Some(snapshot.generation);
        let mut improved = snapshot.clone();
        for comparison in better? {
            let own = improved
                .comparisons
                .iter_mut()
                .find(|c| c.id == comparison.id);
            if let Some(own) = own {
                let (features, stretches) = (own.features.take(), own.stretches.take());
                *own = OverlayComparison {
                    features,
                    stretches,
                    ..comparison
                };
            }
        }
        self.show(request, improved.clone());
        Some(improved)
    }

    /// Whether a run begun at `started` is worth finishing. A short one always is: during a
    /// drag every curve is shown.
    fn is_worth_finishing(shared: &Shared, started: Instant) -> bool {
        let inbox = lock(&shared.inbox);
        !inbox.quit && (inbox.request.is_none() || started.elapsed() < MAX_OUTDATED_RUN)
    }

    fn show(&mut self, request: &SimulationRequest, snapshot: Snapshot) {
        let snapshot = Arc::new(snapshot);
        self.shown = Some((request.clone(), Arc::clone(&snapshot)));
        self.post(WorkerEvent::Snapshot(snapshot));
    }

    fn serve_live(&mut self, request: &SimulationRequest) -> Option<Duration> {
        let mut live = match self.live.take().map_or_else(|| Live::start(request), Ok) {
            Ok(live) => live,
            Err(error) => {
                self.post(WorkerEvent::Refused(error));
                return None;
            }
        };
        let adopted = live.adopt(request);
        let outcome = live.slice(request);
        self.generation += 1;
        let mut snapshot = live.snapshot(self.generation, request);
        let still = live.is_still(request);
        if outcome.is_err() || live.has_changed() {
            self.features.follow(&mut snapshot, request, still);
            self.show(request, snapshot);
        }
        self.live = Some(live);
        // Sent after the picture, which shows the last valid parameters.
        if let Err(error) = adopted {
            self.post(WorkerEvent::Refused(error));
        }
        if let Err(error) = outcome {
            self.post(WorkerEvent::Stopped(error));
            return None;
        }
        // Sixty pictures a second while it moves, none while it stands still.
        (!still).then_some(Duration::from_millis(16))
    }
}

#[cfg(test)]
#[path = "worker_tests.rs"]
pub(super) mod tests;
