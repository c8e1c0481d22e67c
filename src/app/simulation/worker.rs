//! The thread that owns the simulator. The window sends what it wants shown, whole; the
//! newest wish replaces one not yet taken up, so that a slider drag never queues.
//! Results come back immutable behind `Arc`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::features::Summaries;
use super::live::Live;
use super::request::SimulationRequest;
use super::snapshot::Snapshot;
use crate::app::analysis::job::panic_text;
use crate::app::setup::drive_choice::Mode;
use crate::sim::{SimError, simulate_while};

/// A run that takes longer is given up when something newer is wished.
const LONG_RUN: Duration = Duration::from_millis(500);

/// What the worker has to say.
#[derive(Debug, Clone)]
pub enum News {
    /// A new result.
    Snapshot(Arc<Snapshot>),
    /// The wish cannot be simulated; the last good result stays.
    Refused(SimError),
    /// Live: the device cannot go on; it is paused.
    Stopped(SimError),
    /// A panic, caught: the text says where.
    Broken(String),
}

#[derive(Debug, Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    wake: Condvar,
    outbox: Mutex<Vec<News>>,
}

#[derive(Debug, Default)]
struct Inbox {
    wish: Option<SimulationRequest>,
    quit: bool,
}

/// A poisoned lock only says that a panic happened elsewhere; the data is a plain slot.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Handle of the worker thread; ends it when dropped.
#[derive(Debug)]
pub struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread. `repaint` is called when there is news.
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

    /// Asks for a result; replaces a wish not yet taken up.
    pub fn send(&self, wish: SimulationRequest) {
        lock(&self.shared.inbox).wish = Some(wish);
        self.shared.wake.notify_one();
    }

    /// News since the last call, oldest first.
    pub fn news(&self) -> Vec<News> {
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
    summaries: Summaries,
    live: Option<Live>,
    last: Option<SimulationRequest>,
    /// The last result, and the wish that it fulfils.
    shown: Option<(SimulationRequest, Arc<Snapshot>)>,
    generation: u64,
}

impl<R: Fn() + Send + Clone + 'static> Engine<R> {
    fn new(shared: Arc<Shared>, repaint: R) -> Self {
        Self {
            summaries: Summaries::new(repaint.clone()),
            shared,
            repaint,
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
            let Some(wish) = self.next_wish(patience) else {
                return;
            };
            let result = catch_unwind(AssertUnwindSafe(|| self.serve(wish)));
            patience = result.unwrap_or_else(|panic| {
                self.live = None;
                self.last = None;
                self.post(News::Broken(panic_text(panic.as_ref())));
                None
            });
        }
    }

    /// Waits for a wish: for ever, or at most `patience`. `None` ends the thread.
    #[allow(clippy::type_complexity)]
    fn next_wish(&self, patience: Option<Duration>) -> Option<Option<SimulationRequest>> {
        let mut inbox = lock(&self.shared.inbox);
        loop {
            if inbox.quit {
                return None;
            }
            if let Some(wish) = inbox.wish.take() {
                return Some(Some(wish));
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
                        Some(inbox.wish.take())
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

    fn post(&self, news: News) {
        let mut outbox = lock(&self.shared.outbox);
        // What nobody has looked at yet is replaced by newer news of its kind.
        outbox.retain(|old| std::mem::discriminant(old) != std::mem::discriminant(&news));
        outbox.push(news);
        drop(outbox);
        (self.repaint)();
    }

    /// Does what is wished, or goes on with what runs; returns how long to wait for the
    /// next wish.
    fn serve(&mut self, wish: Option<SimulationRequest>) -> Option<Duration> {
        let fresh = wish.is_some();
        let wish = wish.or_else(|| self.last.clone())?;
        let patience = match wish.mode {
            Mode::Window => {
                self.live = None;
                self.serve_window(&wish, fresh)
            }
            Mode::Live => self.serve_live(&wish),
        };
        self.last = Some(wish);
        patience
    }

    fn serve_window(&mut self, wish: &SimulationRequest, fresh: bool) -> Option<Duration> {
        let reuse = self
            .shown
            .as_ref()
            .filter(|(of, _)| of.mode == Mode::Window && of.same_run(wish))
            .map(|(_, shown)| Arc::clone(shown));
        let snapshot = if let (Some(shown), false) = (&reuse, fresh) {
            shown.as_ref().clone()
        } else {
            let started = Instant::now();
            let trace = match &reuse {
                Some(shown) => Arc::clone(&shown.trace),
                None => {
                    let go_on = || self.goes_on(started);
                    let (model, drive) = (&wish.model, &wish.drive);
                    match simulate_while(model, drive, wish.duration, &wish.options(), go_on) {
                        Ok(Some(trace)) => Arc::new(trace),
                        // The newer wish is in the inbox.
                        Ok(None) => return None,
                        Err(error) => {
                            self.post(News::Refused(error));
                            return None;
                        }
                    }
                }
            };
            let cost = match &reuse {
                Some(shown) => shown.cost,
                None => started.elapsed(),
            };
            self.generation += 1;
            let mut snapshot =
                Snapshot::new(self.generation, &wish.model, trace, &wish.overlays, cost);
            snapshot.run_of = Some((wish.drive.clone(), wish.duration));
            self.show(wish, snapshot.clone());
            snapshot
        };
        // The curve is out; now the slower numbers, unless something newer is wished.
        if lock(&self.shared.inbox).wish.is_some() {
            return None;
        }
        if let Some(complete) = self.summaries.complete(snapshot, wish) {
            self.show(wish, complete);
        }
        // Recordings' own features arrive from other threads.
        self.summaries
            .is_waiting()
            .then_some(Duration::from_millis(50))
    }

    /// Whether a run begun at `started` is worth finishing. A short one is, also when
    /// something newer is wished: during a drag every curve is one to see.
    fn goes_on(&self, started: Instant) -> bool {
        let inbox = lock(&self.shared.inbox);
        !inbox.quit && (inbox.wish.is_none() || started.elapsed() < LONG_RUN)
    }

    fn show(&mut self, wish: &SimulationRequest, snapshot: Snapshot) {
        let snapshot = Arc::new(snapshot);
        self.shown = Some((wish.clone(), Arc::clone(&snapshot)));
        self.post(News::Snapshot(snapshot));
    }

    fn serve_live(&mut self, wish: &SimulationRequest) -> Option<Duration> {
        let mut live = match self.live.take().map_or_else(|| Live::start(wish), Ok) {
            Ok(live) => live,
            Err(error) => {
                self.post(News::Refused(error));
                return None;
            }
        };
        let adopted = live.adopt(wish);
        let outcome = live.slice(wish);
        self.generation += 1;
        let mut snapshot = live.snapshot(self.generation, wish);
        let still = live.is_still(wish);
        if outcome.is_err() || live.has_changed() {
            self.summaries.follow(&mut snapshot, wish, still);
            self.show(wish, snapshot);
        }
        self.live = Some(live);
        // After the picture, which is of the last good parameters.
        if let Err(error) = adopted {
            self.post(News::Refused(error));
        }
        if let Err(error) = outcome {
            self.post(News::Stopped(error));
            return None;
        }
        // Sixty pictures a second while it moves, none while it stands.
        (!still).then_some(Duration::from_millis(16))
    }
}

#[cfg(test)]
#[path = "worker_tests.rs"]
mod tests;
