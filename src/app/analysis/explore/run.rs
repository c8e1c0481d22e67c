//! A long computation that grows in view: it begins anew when its question changes, and can be
//! stopped and begun again by hand.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use eframe::egui::Context;

use crate::app::analysis::job::Job;

/// What a thread has done so far.
#[derive(Debug)]
pub struct Grown<A> {
    /// The answer as far as it is known.
    pub answer: A,
    /// Share done, 0 to 1.
    pub share: f64,
    /// Counts its changes.
    pub version: u64,
    /// Time from the start to the first part of the answer.
    pub first_after: Option<Duration>,
    /// Time from the start to the newest part.
    pub last_after: Duration,
}

/// The growing answer, shared with its thread.
#[derive(Debug)]
pub struct Growing<A>(Arc<Mutex<Grown<A>>>);

impl<A> Clone for Growing<A> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<A> Growing<A> {
    /// Looks at it, or changes it.
    pub fn lock(&self) -> MutexGuard<'_, Grown<A>> {
        // A poisoned lock only says that a panic happened elsewhere.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What the thread uses to hand over parts.
pub struct Parts<'a, A> {
    growing: Growing<A>,
    started: Instant,
    repaint: &'a (dyn Fn(f64) + Sync),
    /// Becomes true when the work should stop.
    pub cancel: &'a AtomicBool,
}

impl<A> Parts<'_, A> {
    /// Changes the answer, and says which share is done.
    pub fn add(&self, share: f64, change: impl FnOnce(&mut A)) {
        let mut grown = self.growing.lock();
        change(&mut grown.answer);
        grown.share = share.max(grown.share);
        grown.version += 1;
        let passed = self.started.elapsed();
        grown.first_after.get_or_insert(passed);
        grown.last_after = passed;
        drop(grown);
        (self.repaint)(share);
    }
}

/// A question, its growing answer and the work on it.
#[derive(Debug)]
pub struct Run<Q, A> {
    asked: Option<Arc<Q>>,
    growing: Option<Growing<A>>,
    job: Option<Job<f64, ()>>,
    /// Why there is no answer.
    pub error: Option<String>,
}

impl<Q, A> Default for Run<Q, A> {
    fn default() -> Self {
        Self {
            asked: None,
            growing: None,
            job: None,
            error: None,
        }
    }
}

impl<Q, A> Clone for Run<Q, A> {
    fn clone(&self) -> Self {
        Self {
            asked: self.asked.clone(),
            growing: self.growing.clone(),
            job: self.job.clone(),
            error: self.error.clone(),
        }
    }
}

impl<Q, A> Run<Q, A>
where
    Q: PartialEq + Send + Sync + 'static,
    A: Send + 'static,
{
    /// The question of the present answer.
    pub fn asked(&self) -> Option<&Arc<Q>> {
        self.asked.as_ref()
    }

    /// The answer so far.
    pub fn growing(&self) -> Option<&Growing<A>> {
        self.growing.as_ref()
    }

    /// The work in progress.
    pub fn job(&self) -> Option<&Job<f64, ()>> {
        self.job.as_ref()
    }

    /// Whether `question` is another one than that of the present answer.
    pub fn is_outdated(&self, question: &Q) -> bool {
        self.asked.as_deref() != Some(question)
    }

    /// Begins anew: `empty` is the answer without any part, `work` adds them.
    pub fn start(
        &mut self,
        name: &'static str,
        question: Q,
        empty: A,
        context: &Context,
        work: impl FnOnce(&Q, &Parts<'_, A>) -> Result<(), String> + Send + 'static,
    ) {
        self.stop();
        let question = Arc::new(question);
        let growing = Growing(Arc::new(Mutex::new(Grown {
            answer: empty,
            share: 0.0,
            version: 0,
            first_after: None,
            last_after: Duration::ZERO,
        })));
        let (of_thread, asked) = (growing.clone(), Arc::clone(&question));
        self.job = Some(Job::start(name, context, move |control| {
            let repaint = |share: f64| control.report(share);
            let parts = Parts {
                growing: of_thread,
                started: Instant::now(),
                repaint: &repaint,
                cancel: control.cancel(),
            };
            work(&asked, &parts)
        }));
        self.asked = Some(question);
        self.growing = Some(growing);
        self.error = None;
    }

    /// Takes the outcome of work that has ended. Called once a frame.
    pub fn poll(&mut self) {
        if let Some(result) = self.job.as_ref().and_then(Job::take) {
            self.job = None;
            self.error = result.err();
        }
    }

    /// Ends the work; what is done stays.
    pub fn stop(&self) {
        if let Some(job) = &self.job {
            job.cancel();
        }
    }

    /// Refuses a question: no answer to an earlier one stays in view as if it were its.
    pub fn refuse(&mut self, reason: String) {
        self.stop();
        *self = Self {
            error: Some(reason),
            ..Self::default()
        };
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use super::super::run::*;

    #[test]
    fn an_answer_grows_is_stopped_and_begun_anew() {
        let context = Context::default();
        let mut run: Run<u32, Vec<u32>> = Run::default();
        let work = |n: &u32, parts: &Parts<'_, Vec<u32>>| {
            for i in 0..*n {
                if parts.cancel.load(Ordering::Relaxed) {
                    return Ok(());
                }
                parts.add(f64::from(i + 1) / f64::from(*n), |all| all.push(i));
            }
            if *n == 3 {
                return Err("no more".to_owned());
            }
            // Until it is stopped.
            while *n == 2 && !parts.cancel.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(())
        };
        let wait = |run: &mut Run<u32, Vec<u32>>| {
            for _ in 0..2000 {
                run.poll();
                if run.job().is_none() {
                    return;
                }
                std::thread::sleep(Duration::from_millis(2));
            }
            panic!("it never ended");
        };
        run.start("test", 3, Vec::new(), &context, work);
        wait(&mut run);
        assert_eq!(run.error.as_deref(), Some("no more"));
        assert_eq!(run.growing().unwrap().lock().answer, [0, 1, 2]);
        run.start("test", 2, Vec::new(), &context, work);
        assert!(run.is_outdated(&3) && !run.is_outdated(&2) && run.error.is_none());
        run.stop();
        wait(&mut run);
        run.refuse("empty range".to_owned());
        assert!(run.growing().is_none() && run.is_outdated(&2));
    }
}
