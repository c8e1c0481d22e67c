//! Long work on a thread of its own, with progress, cancellation and a result. A panic in it
//! becomes an error message. What the work splits among threads runs in a pool of its own, so
//! that neither the simulator nor another job waits for it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use eframe::egui::Context;

#[derive(Debug)]
struct Shared<P, T> {
    cancel: AtomicBool,
    progress: Mutex<Option<P>>,
    result: Mutex<Option<Result<T, String>>>,
}

/// Work on a thread of its own, with progress `P` and result `T`. Clones are handles of the
/// same work.
#[derive(Debug)]
pub struct Job<P, T>(Arc<Shared<P, T>>);

impl<P, T> Clone for Job<P, T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

/// Threads of a job where there are few cores. The simulator and the window work for short times only,
/// and the system gives them their turn.
const LEAST_JOB_THREADS: usize = 2;

/// Threads of a job: all cores up to [`LEAST_JOB_THREADS`], else all but one, which is left to the
/// simulator and the window.
fn job_threads(cores: usize) -> usize {
    cores.saturating_sub(1).max(LEAST_JOB_THREADS.min(cores))
}

/// Runs `work` so that what it splits among threads runs in a pool of its own. In rayon's shared
/// pool a short task of the simulator would wait until a long task of a fit has ended.
pub fn in_own_pool<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(job_threads(cores))
        .thread_name(|i| format!("job {i}"))
        .build();
    match pool {
        Ok(pool) => pool.install(work),
        Err(error) => {
            // The shared pool is slower for the others, but the work is done.
            log::warn!("a job shares its threads with the simulator: {error}");
            work()
        }
    }
}

/// What the work uses to report progress and to see that it is cancelled.
pub struct JobControl<P, T> {
    shared: Arc<Shared<P, T>>,
    context: Context,
}

fn lock<V>(mutex: &Mutex<V>) -> MutexGuard<'_, V> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<P, T> JobControl<P, T> {
    /// Becomes true when the work should stop.
    pub fn cancel(&self) -> &AtomicBool {
        &self.shared.cancel
    }

    /// Reports progress.
    pub fn report(&self, progress: P) {
        *lock(&self.shared.progress) = Some(progress);
        self.context.request_repaint();
    }
}

impl<P: Send + 'static, T: Send + 'static> Job<P, T> {
    /// Starts `work` on a thread called `name`.
    pub fn start(
        name: &str,
        context: &Context,
        work: impl FnOnce(&JobControl<P, T>) -> Result<T, String> + Send + 'static,
    ) -> Self {
        let shared = Arc::new(Shared {
            cancel: AtomicBool::new(false),
            progress: Mutex::new(None),
            result: Mutex::new(None),
        });
        let control = JobControl {
            shared: Arc::clone(&shared),
            context: context.clone(),
        };
        let thread = std::thread::Builder::new().name(name.to_owned());
        let started = thread.spawn(move || {
            let result = catch_unwind(AssertUnwindSafe(|| in_own_pool(|| work(&control))))
                .unwrap_or_else(|panic| {
                    let text = panic_text(panic.as_ref());
                    Err(format!("internal error: {text}"))
                });
            *lock(&control.shared.result) = Some(result);
            control.context.request_repaint();
        });
        if let Err(error) = started {
            let text = format!("no thread could be started: {error}; close other programs");
            *lock(&shared.result) = Some(Err(text));
        }
        Self(shared)
    }

    /// Cancels the work; it stops soon.
    pub fn cancel(&self) {
        self.0.cancel.store(true, Ordering::Relaxed);
    }

    /// Whether it was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.cancel.load(Ordering::Relaxed)
    }

    /// The newest progress.
    pub fn progress(&self) -> Option<P>
    where
        P: Clone,
    {
        lock(&self.0.progress).clone()
    }

    /// Whether the work has ended and its result was not taken yet.
    pub fn has_ended(&self) -> bool {
        lock(&self.0.result).is_some()
    }

    /// The result, once, after the work has ended.
    pub fn take(&self) -> Option<Result<T, String>> {
        lock(&self.0.result).take()
    }
}

/// The message of a panic.
pub fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    panic
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::super::job::*;

    fn wait<T: Send + 'static>(job: &Job<u32, T>) -> Result<T, String> {
        for _ in 0..1000 {
            if let Some(result) = job.take() {
                return result;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        panic!("it never ended");
    }

    #[test]
    fn a_job_leaves_a_core_where_there_are_many_and_uses_both_of_two() {
        assert_eq!([1, 2, 3, 4, 16].map(job_threads), [1, 2, 2, 3, 15]);
    }

    #[test]
    fn work_reports_is_cancelled_and_may_panic() {
        let context = Context::default();
        let job: Job<u32, u32> = Job::start("test", &context, |control| {
            let mut n = 0;
            while !control.cancel().load(Ordering::Relaxed) {
                n += 1;
                control.report(n);
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            Ok(n)
        });
        while job.progress().is_none_or(|n| n < 3) {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        job.cancel();
        assert!(job.is_cancelled() && wait(&job).unwrap() >= 3);
        let job: Job<u32, u32> = Job::start("test", &context, |_| panic!("on purpose"));
        let error = wait(&job).unwrap_err();
        assert!(error.contains("on purpose"), "{error}");
    }

    #[test]
    fn the_shared_pool_is_free_while_jobs_keep_all_their_threads_busy() {
        use rayon::prelude::*;
        let context = Context::default();
        let busy = || -> Job<u32, u32> {
            Job::start("test", &context, |control| {
                let threads = rayon::current_num_threads() as u32;
                // Every thread of the pool, and a queue behind it.
                (0..4 * threads).into_par_iter().for_each(|_| {
                    while !control.cancel().load(Ordering::Relaxed) {
                        control.report(1);
                        std::thread::sleep(std::time::Duration::from_millis(1));
                    }
                });
                Ok(threads)
            })
        };
        // Two jobs at once: both begin, and what others do in parallel is done meanwhile.
        let jobs = [busy(), busy()];
        for job in &jobs {
            let mut waits = 0;
            while job.progress().is_none() {
                waits += 1;
                assert!(waits < 2000, "a job waits for another one");
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        }
        let (send, receive) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let sum: u64 = (0..1000_u64).into_par_iter().sum();
            let _ = send.send(sum);
        });
        let sum = receive.recv_timeout(std::time::Duration::from_secs(10));
        for job in &jobs {
            job.cancel();
        }
        assert_eq!(sum, Ok(499_500), "the shared pool waits for the jobs");
        for job in &jobs {
            assert!(wait(job).unwrap() >= 1);
        }
    }
}
