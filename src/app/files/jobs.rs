//! What the window knows of files being worked on: how far they are, and a way to stop.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use super::event::FileEvent;
use crate::app::analysis::job::panic_text;

/// A file being worked on.
#[derive(Debug)]
pub struct Job {
    what: &'static str,
    path: PathBuf,
    /// Share done in per cent.
    percent: AtomicU32,
    cancelled: AtomicBool,
}

/// A file being worked on, for the screen.
#[derive(Debug, Clone, PartialEq)]
pub struct Working {
    /// What is done with it, as `reading`.
    pub what: &'static str,
    /// The file.
    pub path: PathBuf,
    /// Share done, 0 to 1.
    pub fraction: f32,
}

/// Asks the window to look again.
pub type Repaint = Arc<dyn Fn() + Send + Sync>;

/// The jobs in progress; a finished one is only a dead reference.
#[derive(Debug, Clone, Default)]
pub struct Jobs(Arc<Mutex<Vec<Weak<Job>>>>);

impl Jobs {
    fn lock(&self) -> MutexGuard<'_, Vec<Weak<Job>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Jobs that are not finished.
    pub fn running(&self) -> Vec<Arc<Job>> {
        self.lock().iter().filter_map(Weak::upgrade).collect()
    }

    /// The same for the screen.
    pub fn working(&self) -> Vec<Working> {
        let show = |job: Arc<Job>| Working {
            what: job.what,
            path: job.path.clone(),
            fraction: job.percent.load(Ordering::Relaxed) as f32 / 100.0,
        };
        self.running().into_iter().map(show).collect()
    }

    /// Asks all to stop.
    pub fn cancel(&self) {
        for job in self.running() {
            job.cancel();
        }
    }
}

impl Job {
    /// Asks it to stop; it does at its next report of progress.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// What a job has at hand while it works.
pub struct Context {
    pub(crate) job: Arc<Job>,
    jobs: Jobs,
    pub(crate) send: Sender<FileEvent>,
    repaint: Repaint,
}

impl Context {
    /// Starts a job on a file; `what` is done with it, as `reading`.
    pub fn new(
        what: &'static str,
        path: PathBuf,
        jobs: &Jobs,
        send: &Sender<FileEvent>,
        repaint: &Repaint,
    ) -> Self {
        let job = Arc::new(Job {
            what,
            path,
            percent: AtomicU32::new(0),
            cancelled: AtomicBool::new(false),
        });
        jobs.lock().push(Arc::downgrade(&job));
        Self {
            job,
            jobs: jobs.clone(),
            send: send.clone(),
            repaint: Arc::clone(repaint),
        }
    }

    /// Does the work, catches its panics, and tells the window.
    pub fn run(self, work: impl FnOnce(&Self) -> Option<FileEvent>) {
        let event = catch_unwind(AssertUnwindSafe(|| work(&self))).unwrap_or_else(|panic| {
            Some(FileEvent::Failed {
                message: format!(
                    "{}: internal error while working on this file: {}; the window goes on",
                    self.job.path.display(),
                    panic_text(panic.as_ref())
                ),
            })
        });
        if let Some(event) = event {
            // The window may be gone.
            let _ = self.send.send(event);
        }
        let Self {
            job, jobs, repaint, ..
        } = self;
        drop(job);
        jobs.lock().retain(|job| job.strong_count() > 0);
        repaint();
    }

    /// Notes the share done; returns whether to go on.
    pub fn progress(&self, share: f32) -> bool {
        let percent = (share.clamp(0.0, 1.0) * 100.0) as u32;
        if self.job.percent.swap(percent, Ordering::Relaxed) != percent {
            (self.repaint)();
        }
        !self.job.cancelled.load(Ordering::Relaxed)
    }
}
