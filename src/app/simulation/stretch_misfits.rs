//! How far the device is from each recording between impacts: the number of the fit and of the
//! diagnosis's proof. It takes longer than a run, so it follows once nothing newer is asked.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use super::request::SimulationRequest;
use super::snapshot::Snapshot;
use crate::app::analysis::job::in_own_pool;
use crate::app::analysis::origin::as_set_up;
use crate::app::setup::overlay::Overlay;
use crate::diagnose::{DiagnoseControl, DiagnoseOptions, StretchMisfit, evaluate};
use crate::fit::Part;
use crate::model::Model;
use crate::model::drive::Waveform;

/// What misfits are computed for: they share the noise that is common to all.
#[derive(Debug, Clone, PartialEq)]
struct Asked {
    model: Arc<Model>,
    overlays: Vec<Overlay>,
    /// The drive of the simulation.
    shared: Waveform,
}

type Found = Vec<Option<StretchMisfit>>;

/// Misfits of the recordings over their stretches.
pub struct StretchMisfits {
    known: Option<(Asked, Found)>,
    /// The running computation: what for, and how to cancel it.
    running: Option<(Asked, Arc<AtomicBool>)>,
    done: Receiver<(Asked, Found)>,
    send: Sender<(Asked, Found)>,
    repaint: Box<dyn Fn() -> Box<dyn Fn() + Send> + Send>,
}

impl StretchMisfits {
    /// `repaint` is called when misfits are ready.
    pub fn new(repaint: impl Fn() + Send + Clone + 'static) -> Self {
        let (send, done) = channel();
        Self {
            known: None,
            running: None,
            done,
            send,
            repaint: Box::new(move || Box::new(repaint.clone())),
        }
    }

    /// Whether something is being computed.
    pub fn is_waiting(&self) -> bool {
        self.running.is_some()
    }

    /// Cancels what is computed: something newer is asked.
    pub fn cancel(&mut self) {
        if let Some((_, cancel)) = self.running.take() {
            cancel.store(true, Ordering::Relaxed);
        }
    }

    /// The snapshot with all misfits known now, or `None` if it has them already. What is missing is
    /// computed on another thread.
    pub fn complete(
        &mut self,
        snapshot: &Snapshot,
        request: &SimulationRequest,
    ) -> Option<Snapshot> {
        for (asked, found) in self.done.try_iter() {
            if self.running.as_ref().is_some_and(|(of, _)| *of == asked) {
                self.running = None;
            }
            self.known = Some((asked, found));
        }
        let asked = Asked {
            model: Arc::clone(&request.model),
            overlays: request
                .overlays
                .iter()
                .filter(|o| o.visible)
                .cloned()
                .collect(),
            shared: request.drive.clone(),
        };
        let is_known = self.known.as_ref().is_some_and(|(of, _)| *of == asked);
        let is_running = self.running.as_ref().is_some_and(|(of, _)| *of == asked);
        if !is_known && !is_running && !asked.overlays.is_empty() {
            self.cancel();
            self.start(asked.clone());
        }
        let mut complete = snapshot.clone();
        let mut changed = false;
        for comparison in &mut complete.comparisons {
            let known = self.known.as_ref().filter(|(of, _)| *of == asked);
            let misfit = known.and_then(|(of, found)| {
                let k = of.overlays.iter().position(|o| o.id == comparison.id)?;
                found.get(k)?.clone()
            });
            changed |= comparison.stretches != misfit;
            comparison.stretches = misfit;
        }
        changed.then_some(complete)
    }

    fn start(&mut self, asked: Asked) {
        let cancel = Arc::new(AtomicBool::new(false));
        self.running = Some((asked.clone(), Arc::clone(&cancel)));
        let (send, repaint) = (self.send.clone(), (self.repaint)());
        let work = move || {
            let Asked {
                model,
                overlays,
                shared,
            } = &asked;
            let misfits = || stretch_misfits(model, overlays, shared, &cancel);
            // A panic must not leave the window waiting.
            let found = catch_unwind(AssertUnwindSafe(misfits)).unwrap_or_default();
            if !cancel.load(Ordering::Relaxed) {
                // The worker may have ended meanwhile.
                let _ = send.send((asked, found));
                repaint();
            }
        };
        let thread = std::thread::Builder::new().name("stretches".to_owned());
        if let Err(error) = thread.spawn(move || in_own_pool(work)) {
            log::warn!("no thread for the misfit between impacts could be started: {error}");
            self.running = None;
        }
    }
}

/// Misfits of `model` on the stretches of recordings, in their order; none if they cannot be cut into
/// any. `shared` is the drive of the simulation.
pub fn stretch_misfits(
    model: &Model,
    overlays: &[Overlay],
    shared: &Waveform,
    cancel: &AtomicBool,
) -> Vec<Option<StretchMisfit>> {
    let parts: Vec<Part> = overlays
        .iter()
        .map(|o| Part::whole(as_set_up(o, Some(shared))))
        .collect();
    let control = DiagnoseControl {
        cancel,
        progress: &|_| {},
    };
    match evaluate(model, &parts, &DiagnoseOptions::default(), &control) {
        Ok(found) => found.into_iter().map(Some).collect(),
        Err(error) => {
            log::debug!("no misfit between impacts: {error}");
            vec![None; overlays.len()]
        }
    }
}
