//! A limit on the time that work may take. Everything that watches whether it is cancelled also keeps
//! to it: the work is given a flag that is set when it is cancelled or its time is used up.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Longest time between two looks at the flag of the caller.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Why work ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// It was done, or cancelled by the caller.
    OfItself,
    /// Its time was used up before.
    OutOfTime,
}

/// Sets a flag when it goes out of scope, also by a panic.
struct Done<'a>(&'a AtomicBool, thread::Thread);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        self.1.unpark();
    }
}

/// Does `work` with a flag to stop, which is set when `cancel` is, or when `budget` is used up. Without
/// a budget the flag is `cancel` itself.
pub(crate) fn within_budget<T>(
    budget: Option<Duration>,
    cancel: &AtomicBool,
    work: impl FnOnce(&AtomicBool) -> T,
) -> (T, Ending) {
    let Some(budget) = budget else {
        return (work(cancel), Ending::OfItself);
    };
    let begun = Instant::now();
    let (stop, done) = (AtomicBool::new(false), AtomicBool::new(false));
    let watch = || {
        while !done.load(Ordering::Relaxed) {
            let left = budget.saturating_sub(begun.elapsed());
            if left.is_zero() || cancel.load(Ordering::Relaxed) {
                stop.store(true, Ordering::Relaxed);
                break;
            }
            thread::park_timeout(left.min(LOOK_EVERY));
        }
    };
    let made = thread::scope(|scope| {
        let watcher = scope.spawn(watch);
        let _done = Done(&done, watcher.thread().clone());
        work(&stop)
    });
    let is_out_of_time = stop.load(Ordering::Relaxed) && !cancel.load(Ordering::Relaxed);
    let ending = if is_out_of_time {
        Ending::OutOfTime
    } else {
        Ending::OfItself
    };
    (made, ending)
}

#[cfg(test)]
mod tests {
    use super::super::budget::*;

    /// Works until it is stopped; the time that took.
    fn endless(stop: &AtomicBool) -> Duration {
        let begun = Instant::now();
        while !stop.load(Ordering::Relaxed) && begun.elapsed() < Duration::from_secs(20) {
            thread::sleep(Duration::from_millis(1));
        }
        begun.elapsed()
    }

    #[test]
    fn work_ends_with_its_time() {
        let go_on = AtomicBool::new(false);
        let budget = Duration::from_millis(100);
        let (took, ending) = within_budget(Some(budget), &go_on, endless);
        assert_eq!(ending, Ending::OutOfTime);
        assert!(
            took >= Duration::from_millis(99) && took < Duration::from_secs(10),
            "{took:?}"
        );
        assert!(!go_on.load(Ordering::Relaxed));
    }

    #[test]
    fn work_that_is_done_or_cancelled_before_is_not_out_of_time() {
        let go_on = AtomicBool::new(false);
        let hour = Some(Duration::from_secs(3600));
        let begun = Instant::now();
        assert_eq!(within_budget(hour, &go_on, |_| 7), (7, Ending::OfItself));
        // The watcher does not make the caller wait.
        assert!(begun.elapsed() < Duration::from_secs(5));
        let cancelled = AtomicBool::new(true);
        for budget in [hour, None] {
            let (took, ending) = within_budget(budget, &cancelled, endless);
            assert_eq!(ending, Ending::OfItself);
            assert!(took < Duration::from_secs(10));
        }
    }
}
