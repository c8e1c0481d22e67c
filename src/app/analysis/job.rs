//! Long work on a thread of its own, with progress, cancellation and a result. A panic in it
//! becomes an error message.

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
            let result =
                catch_unwind(AssertUnwindSafe(|| work(&control))).unwrap_or_else(|panic| {
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
}
