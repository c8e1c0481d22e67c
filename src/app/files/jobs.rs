//! Work on files in progress: how far it is, and a way to stop it.

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
    /// Progress in per cent.
    percent: AtomicU32,
    cancelled: AtomicBool,
    /// Whether the work has asked whether to continue.
    can_cancel: AtomicBool,
}

/// A file being worked on, as it is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Working {
    /// The work, for example `reading`.
    pub what: &'static str,
    /// The file.
    pub path: PathBuf,
    /// Progress, 0 to 1.
    pub fraction: f32,
    /// Whether cancelling stops it. Only imports ask whether to continue.
    pub can_cancel: bool,
}

/// Requests a new frame of the window.
pub type Repaint = Arc<dyn Fn() + Send + Sync>;

/// The jobs in progress; a finished one is a dead reference.
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

    /// The same, as they are shown.
    pub fn working(&self) -> Vec<Working> {
        let show = |job: Arc<Job>| Working {
            what: job.what,
            path: job.path.clone(),
            fraction: job.percent.load(Ordering::Relaxed) as f32 / 100.0,
            can_cancel: job.can_cancel.load(Ordering::Relaxed),
        };
        self.running().into_iter().map(show).collect()
    }

    /// Cancels all jobs.
    pub fn cancel(&self) {
        for job in self.running() {
            job.cancel();
        }
    }
}

impl Job {
    /// Cancels the job; it stops at its next report of progress.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// The connection of a job to the window.
pub struct Context {
    pub(crate) job: Arc<Job>,
    jobs: Jobs,
    pub(crate) send: Sender<FileEvent>,
    repaint: Repaint,
}

impl Context {
    /// Registers a job on a file; `what` names the work, for example `reading`.
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
            can_cancel: AtomicBool::new(false),
        });
        jobs.lock().push(Arc::downgrade(&job));
        Self {
            job,
            jobs: jobs.clone(),
            send: send.clone(),
            repaint: Arc::clone(repaint),
        }
    }

    /// Does the work, catches its panics, and sends the outcome to the window.
    pub fn run(self, work: impl FnOnce(&Self) -> Option<FileEvent>) {
        let event = catch_unwind(AssertUnwindSafe(|| work(&self))).unwrap_or_else(|panic| {
            Some(FileEvent::Failed {
                message: format!(
                    "{}: internal error while working on this file: {}",
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

    /// Reports progress, 0 to 1; returns whether to continue.
    pub fn progress(&self, share: f32) -> bool {
        self.job.can_cancel.store(true, Ordering::Relaxed);
        let percent = (share.clamp(0.0, 1.0) * 100.0) as u32;
        if self.job.percent.swap(percent, Ordering::Relaxed) != percent {
            (self.repaint)();
        }
        !self.job.cancelled.load(Ordering::Relaxed)
    }
}
