//! The thread that simulates kept curves and compares them with the recordings. A newer request
//! replaces one that has not been started. A run that is known is not simulated again, and a
//! comparison that is up to date is not repeated.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::runs::KeptRun;
use crate::app::analysis::job::{in_own_pool, panic_text};
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::setup::kept_curve::{RunOrigin, same_origin};
use crate::app::setup::overlay::{Overlay, have_same_numbers};
use crate::app::simulation::experiments::{ExperimentCache, SharedRun};
use crate::app::simulation::features::features_of_run;
use crate::app::simulation::recorded_drive::{DriveMaking, recorded_drive};
use crate::app::simulation::request::SimulationRequest;
use crate::app::simulation::snapshot::Snapshot;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::simulate_while;

/// A computation that takes longer is given up when something newer is requested. Shorter ones
/// are finished, so that numbers follow while a recording is shifted.
const MAX_OUTDATED_WORK: Duration = Duration::from_millis(500);

/// A curve whose numbers are wanted.
#[derive(Debug, Clone)]
pub struct KeptTask {
    /// What it is computed from.
    pub origin: Arc<RunOrigin>,
    /// Its run, if it is known; it is then not simulated.
    pub known: Option<Arc<Snapshot>>,
}

impl PartialEq for KeptTask {
    /// What is known of the run does not change what is wanted.
    fn eq(&self, other: &Self) -> bool {
        same_origin(&self.origin, &other.origin)
    }
}

/// The curves whose numbers are wanted, and the recordings that they are compared with.
#[derive(Debug, Clone)]
pub struct KeptRequest {
    /// Curves that can be simulated.
    pub curves: Vec<KeptTask>,
    /// All recordings; the visible ones are compared.
    pub overlays: Vec<Overlay>,
}

impl PartialEq for KeptRequest {
    fn eq(&self, other: &Self) -> bool {
        self.curves == other.curves && have_same_numbers(&self.overlays, &other.overlays)
    }
}

#[derive(Debug, Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    wake: Condvar,
    outbox: Mutex<Vec<KeptRun>>,
}

#[derive(Debug, Default)]
struct Inbox {
    request: Option<KeptRequest>,
    quit: bool,
}

/// A poisoned lock only says that a panic happened elsewhere; the data is a plain slot.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Handle of the thread; ends it when dropped.
#[derive(Debug)]
pub struct KeptWorker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl KeptWorker {
    /// Starts the thread. `repaint` is called when there is a result.
    ///
    /// # Errors
    /// The system's, if no thread can be started.
    pub fn start(repaint: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let engine = Engine {
            shared: Arc::clone(&shared),
            repaint,
            entries: Vec::new(),
        };
        let thread = std::thread::Builder::new()
            .name("kept curves".to_owned())
            // A pool of its own: the simulator waits for none of this.
            .spawn(move || in_own_pool(|| engine.run()))?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Asks for numbers; replaces a request that has not been started.
    pub fn send(&self, request: KeptRequest) {
        lock(&self.shared.inbox).request = Some(request);
        self.shared.wake.notify_one();
    }

    /// What was computed since the last call, at most one result for each curve.
    pub fn results(&self) -> Vec<KeptRun> {
        std::mem::take(&mut *lock(&self.shared.outbox))
    }
}

impl Drop for KeptWorker {
    fn drop(&mut self) {
        lock(&self.shared.inbox).quit = true;
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // The thread catches its panics; there is nothing to report at the end.
            let _ = thread.join();
        }
    }
}

/// A curve as far as it is computed.
struct Entry {
    origin: Arc<RunOrigin>,
    model: Arc<Model>,
    drive: Waveform,
    snapshot: Snapshot,
    cache: ExperimentCache,
    /// The recordings that it is completely compared with.
    compared: Option<Vec<Overlay>>,
}

/// The thread's own state.
struct Engine<R> {
    shared: Arc<Shared>,
    repaint: R,
    entries: Vec<Entry>,
}

/// A newer request, or the end of the thread, makes the present one pointless.
struct Outdated;

impl<R: Fn() + Send + 'static> Engine<R> {
    fn run(mut self) {
        while let Some(request) = self.next_request() {
            let served = catch_unwind(AssertUnwindSafe(|| self.serve(&request)));
            if let Err(panic) = served {
                // Whatever was half done is done again.
                self.entries.clear();
                let text = format!("internal error: {}", panic_text(panic.as_ref()));
                for task in &request.curves {
                    self.post(&task.origin, Err(text.clone()), true);
                }
            }
        }
    }

    /// Waits for a request; `None` ends the thread.
    fn next_request(&self) -> Option<KeptRequest> {
        let mut inbox = lock(&self.shared.inbox);
        loop {
            if inbox.quit {
                return None;
            }
            if let Some(request) = inbox.request.take() {
                return Some(request);
            }
            let woken = self.shared.wake.wait(inbox);
            inbox = woken.unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// All curves are compared first, then what takes longer is done for each. Ends early when
    /// something newer is requested; what is finished by then is not lost.
    fn serve(&mut self, request: &KeptRequest) {
        let begun = Instant::now();
        let is_wanted = |entry: &Entry| {
            let mut tasks = request.curves.iter();
            tasks.any(|task| same_origin(&task.origin, &entry.origin))
        };
        self.entries.retain(is_wanted);
        for task in &request.curves {
            if self.compare(task, &request.overlays, begun).is_err() {
                return;
            }
        }
        for i in 0..self.entries.len() {
            if self.complete(i, &request.overlays).is_err() {
                return;
            }
        }
    }

    /// Simulates a curve if it is new, and compares it.
    fn compare(
        &mut self,
        task: &KeptTask,
        overlays: &[Overlay],
        begun: Instant,
    ) -> Result<(), Outdated> {
        let shared = Arc::clone(&self.shared);
        let go_on = || {
            let inbox = lock(&shared.inbox);
            let is_short = begun.elapsed() < MAX_OUTDATED_WORK;
            !inbox.quit && (inbox.request.is_none() || is_short)
        };
        let known = (self.entries.iter()).position(|e| same_origin(&e.origin, &task.origin));
        let i = match known {
            Some(i) => i,
            None => match entry(task, overlays, &go_on) {
                Ok(Some(entry)) => {
                    self.entries.push(entry);
                    self.entries.len() - 1
                }
                Ok(None) => return Err(Outdated),
                Err(reason) => {
                    self.post(&task.origin, Err(reason), true);
                    return Ok(());
                }
            },
        };
        let entry = &mut self.entries[i];
        let before = entry.compared.as_deref();
        if before.is_some_and(|before| have_same_numbers(before, overlays)) {
            return Ok(());
        }
        entry.compared = None;
        let run = SharedRun {
            model: &entry.model,
            drive: &entry.drive,
            trace: &entry.snapshot.trace,
        };
        let compared = entry.cache.compare(&entry.model, run, overlays, go_on);
        entry.snapshot.comparisons = compared.ok_or(Outdated)?;
        self.show(i, false);
        Ok(())
    }

    /// Lets the readings decide what the recordings' voltages leave open, as for the present run,
    /// and finds the features.
    fn complete(&mut self, i: usize, overlays: &[Overlay]) -> Result<(), Outdated> {
        let shared = Arc::clone(&self.shared);
        let go_on = || {
            let inbox = lock(&shared.inbox);
            !inbox.quit && inbox.request.is_none()
        };
        let entry = &mut self.entries[i];
        if entry.compared.is_some() {
            return Ok(());
        }
        let snapshot = &mut entry.snapshot;
        let better = (entry.cache).improve(&entry.model, overlays, &snapshot.comparisons, go_on);
        if !go_on() {
            return Err(Outdated);
        }
        for comparison in better.into_iter().flatten() {
            let mut own = snapshot.comparisons.iter_mut();
            if let Some(own) = own.find(|own| own.id == comparison.id) {
                *own = comparison;
            }
        }
        if snapshot.features.is_none() {
            let features = features_of_run(&snapshot.trace, &entry.model, &entry.drive);
            snapshot.features = Some(Arc::new(features));
        }
        entry.compared = Some(overlays.to_vec());
        self.show(i, true);
        Ok(())
    }

    fn show(&self, i: usize, is_complete: bool) {
        let entry = &self.entries[i];
        let run = Ok(Arc::new(entry.snapshot.clone()));
        self.post(&entry.origin, run, is_complete);
    }

    fn post(&self, origin: &Arc<RunOrigin>, run: Result<Arc<Snapshot>, String>, done: bool) {
        let mut outbox = lock(&self.shared.outbox);
        // What nobody has taken yet is replaced by what is newer.
        outbox.retain(|old| !same_origin(&old.origin, origin));
        outbox.push(KeptRun {
            origin: Arc::clone(origin),
            run,
            is_complete: done,
        });
        drop(outbox);
        (self.repaint)();
    }
}

/// A curve's run, not compared yet; `None` if `go_on` said no.
///
/// # Errors
/// Why it cannot be simulated.
fn entry(
    task: &KeptTask,
    overlays: &[Overlay],
    go_on: &impl Fn() -> bool,
) -> Result<Option<Entry>, String> {
    let origin = &task.origin;
    let started = Instant::now();
    let known = task.known.as_ref();
    let (drive, snapshot) = match known.and_then(|run| Some((run, run.run_of.as_ref()?))) {
        Some((run, (drive, _))) => (drive.clone(), run.as_ref().clone()),
        None => {
            let drive = drive_of(origin, overlays)?;
            let model = Arc::new(origin.preset.model.clone());
            let request = SimulationRequest {
                model: Arc::clone(&model),
                drive: drive.clone(),
                duration: origin.duration,
                forces: false,
                overlays: Vec::new(),
                from_steady: false,
                mode: Mode::WholeSpan,
                slow_down: 1.0,
                paused: false,
                scrub: None,
                restarts: 0,
                steps: 0,
            };
            let options = request.options();
            let trace = simulate_while(&model, &drive, origin.duration, &options, go_on)
                .map_err(|error| error.to_string())?;
            let Some(trace) = trace else {
                return Ok(None);
            };
            let cost = started.elapsed();
            let mut snapshot = Snapshot::new(0, &model, Arc::new(trace), Vec::new(), cost);
            snapshot.run_of = Some((drive.clone(), origin.duration));
            (drive, snapshot)
        }
    };
    Ok(Some(Entry {
        origin: Arc::clone(origin),
        model: Arc::clone(&snapshot.model),
        drive,
        snapshot,
        cache: ExperimentCache::default(),
        compared: None,
    }))
}

/// The drive of a kept curve.
///
/// # Errors
/// Why the recording that supplied it gives none.
fn drive_of(origin: &RunOrigin, overlays: &[Overlay]) -> Result<Waveform, String> {
    match &origin.drive {
        DriveChoice::Waveform(waveform) => Ok(waveform.clone()),
        DriveChoice::Recorded(id) => match overlays.iter().find(|o| o.id == *id) {
            Some(overlay) => {
                let making = DriveMaking {
                    shift: origin.shift,
                    reading: origin.reading,
                };
                recorded_drive(overlay, making)
            }
            None => Err(
                "the recording that supplied its drive is missing; load it again, or remove the curve"
                    .to_owned(),
            ),
        },
    }
}

#[cfg(test)]
#[path = "worker_tests.rs"]
mod tests;
