//! How far the device is from each recording between impacts: the number of the fit and of the
//! diagnosis's proof. It takes longer than a run, so it follows once nothing newer is asked.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use super::request::SimulationRequest;
use super::snapshot::Snapshot;
use crate::app::analysis::job::{in_own_pool, panic_text};
use crate::app::analysis::origin::as_set_up;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::overlay::{Overlay, have_same_numbers};
use crate::diagnose::{DiagnoseControl, DiagnoseOptions, StretchMisfit, evaluate};
use crate::fit::Part;
use crate::model::Model;
use crate::model::drive::Waveform;

/// What misfits are computed for: they share the noise that is common to all.
#[derive(Debug, Clone)]
struct Asked {
    model: Arc<Model>,
    /// The visible recordings, at least one.
    overlays: Vec<Overlay>,
    /// The drive of the simulation, if any of them is under it.
    shared: Option<Waveform>,
}

impl PartialEq for Asked {
    fn eq(&self, other: &Self) -> bool {
        self.model == other.model
            && have_same_numbers(&self.overlays, &other.overlays)
            && self.shared == other.shared
    }
}

impl Asked {
    /// What is asked with a request; `None` if it compares nothing.
    fn of(request: &SimulationRequest) -> Option<Self> {
        let visible = request.overlays.iter().filter(|o| o.visible);
        let overlays: Vec<Overlay> = visible.cloned().collect();
        let is_shared =
            request.model.piezo.is_some() && overlays.iter().any(Overlay::is_under_shared_drive);
        let is_any = request.mode == Mode::WholeSpan && !overlays.is_empty();
        is_any.then(|| Self {
            model: Arc::clone(&request.model),
            overlays,
            shared: is_shared.then(|| request.drive.clone()),
        })
    }
}

/// A misfit, or why there is none, of each recording.
type Found = Vec<Result<StretchMisfit, String>>;

/// The end of a computation. `None` if it was cancelled.
struct Ended(Option<(Asked, Found)>);

/// Misfits of the recordings over their stretches.
pub struct StretchMisfits {
    known: Option<(Asked, Found)>,
    /// The computation whose end has not been heard of: what for, and how to cancel it. There is
    /// never more than one.
    running: Option<(Asked, Arc<AtomicBool>)>,
    ended: Receiver<Ended>,
    send: Sender<Ended>,
    repaint: Box<dyn Fn() -> Box<dyn Fn() + Send> + Send>,
    compute: fn(&Asked, &AtomicBool) -> Found,
}

impl StretchMisfits {
    /// `repaint` is called when misfits are ready.
    pub fn new(repaint: impl Fn() + Send + Clone + 'static) -> Self {
        let (send, ended) = channel();
        Self {
            known: None,
            running: None,
            ended,
            send,
            repaint: Box::new(move || Box::new(repaint.clone())),
            compute: |asked, cancel| {
                stretch_misfits(&asked.model, &asked.overlays, asked.shared.as_ref(), cancel)
            },
        }
    }

    /// Whether something is being computed, or waits until what was cancelled has ended.
    pub fn is_waiting(&self) -> bool {
        self.running.is_some()
    }

    /// Cancels what is computed, unless the request asks for just that.
    pub fn cancel_unless_asked(&mut self, request: &SimulationRequest) {
        self.cancel_unless(Asked::of(request).as_ref());
    }

    fn cancel_unless(&mut self, asked: Option<&Asked>) {
        if let Some((of, cancel)) = &self.running
            && asked != Some(of)
        {
            cancel.store(true, Ordering::Relaxed);
        }
    }

    /// The snapshot with all misfits known now, or `None` if it has them already. What is missing is
    /// computed on another thread, once the one before has ended.
    pub fn complete(
        &mut self,
        snapshot: &Snapshot,
        request: &SimulationRequest,
    ) -> Option<Snapshot> {
        for Ended(found) in self.ended.try_iter() {
            self.running = None;
            self.known = found.or(self.known.take());
        }
        let asked = Asked::of(request);
        self.cancel_unless(asked.as_ref());
        let known = self
            .known
            .as_ref()
            .filter(|(of, _)| Some(of) == asked.as_ref());
        let mut complete = snapshot.clone();
        let mut changed = false;
        for comparison in &mut complete.comparisons {
            let misfit = known.and_then(|(of, found)| {
                let k = of.overlays.iter().position(|o| o.id == comparison.id)?;
                found.get(k).cloned()
            });
            changed |= comparison.stretches != misfit;
            comparison.stretches = misfit;
        }
        if let Some(asked) = asked
            && known.is_none()
            && self.running.is_none()
        {
            self.start(asked);
        }
        changed.then_some(complete)
    }

    fn start(&mut self, asked: Asked) {
        let cancel = Arc::new(AtomicBool::new(false));
        self.running = Some((asked.clone(), Arc::clone(&cancel)));
        let (send, repaint, compute) = (self.send.clone(), (self.repaint)(), self.compute);
        let work = move || {
            // A panic must not leave the window waiting.
            let found = catch_unwind(AssertUnwindSafe(|| compute(&asked, &cancel)));
            let found = found.unwrap_or_else(|panic| {
                let text = format!("internal error: {}", panic_text(panic.as_ref()));
                vec![Err(text); asked.overlays.len()]
            });
            let is_cancelled = cancel.load(Ordering::Relaxed);
            // The worker may have ended meanwhile.
            let _ = send.send(Ended((!is_cancelled).then_some((asked, found))));
            if !is_cancelled {
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

impl Drop for StretchMisfits {
    fn drop(&mut self) {
        self.cancel_unless(None);
    }
}

/// Misfits of `model` on the stretches of recordings, in their order, or why there is none. `shared`
/// is the drive of the simulation, for those under it.
pub fn stretch_misfits(
    model: &Model,
    overlays: &[Overlay],
    shared: Option<&Waveform>,
    cancel: &AtomicBool,
) -> Vec<Result<StretchMisfit, String>> {
    let parts: Vec<Part> = overlays
        .iter()
        .map(|o| Part::whole(as_set_up(o, shared)))
        .collect();
    let control = DiagnoseControl {
        cancel,
        progress: &|_| {},
    };
    usable_together(parts.len(), |these| {
        let these: Vec<Part> = these.iter().map(|&k| parts[k].clone()).collect();
        let found = evaluate(model, &these, &DiagnoseOptions::default(), &control);
        found.map_err(|error| error.to_string())
    })
}

/// What `evaluate` finds for all of `count` recordings together. If that fails, for those together
/// that it can use alone, and why it cannot use the others.
fn usable_together<T>(
    count: usize,
    evaluate: impl Fn(&[usize]) -> Result<Vec<T>, String>,
) -> Vec<Result<T, String>> {
    let all: Vec<usize> = (0..count).collect();
    let error = match evaluate(&all) {
        Ok(found) => return found.into_iter().map(Ok).collect(),
        Err(error) => error,
    };
    if count == 1 {
        return vec![Err(error)];
    }
    let alone = |k: usize| {
        let found = evaluate(&[k])?;
        let first = found.into_iter().next();
        first.ok_or_else(|| "it has no stretch between impacts".to_owned())
    };
    let mut found: Vec<Result<T, String>> = all.into_iter().map(alone).collect();
    let usable: Vec<usize> = (0..count).filter(|&k| found[k].is_ok()).collect();
    if usable.len() > 1
        && usable.len() < count
        && let Ok(together) = evaluate(&usable)
    {
        for (k, misfit) in usable.into_iter().zip(together) {
            found[k] = Ok(misfit);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::app::simulation::worker::tests as worker_tests;
    use std::sync::atomic::AtomicUsize;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::app::files::built_in;
    use crate::app::setup::overlay::Role;
    use crate::app::setup::own_drive::OwnDrive;
    use crate::model::parameter::ParameterId;
    use crate::sim::Trace;

    fn request() -> SimulationRequest {
        worker_tests::request(&built_in::setup())
    }

    fn other_device(request: &SimulationRequest, alpha: f64) -> SimulationRequest {
        let mut other = request.clone();
        let model = Arc::make_mut(&mut other.model);
        model.parameters.set(ParameterId::Alpha, alpha);
        other
    }

    #[test]
    fn only_what_changes_the_numbers_is_asked_anew() {
        let before = request();
        let asked = Asked::of(&before);
        let mut after = before.clone();
        after.overlays[0].color += 1;
        after.overlays[0].role = Some(Role::Unused);
        after.drive = Waveform::Rest;
        // No recording is under the drive of the simulation.
        assert!(asked.is_some() && asked == Asked::of(&after));
        after.overlays[0].drive = OwnDrive::Shared;
        let shared = Asked::of(&after);
        assert_ne!(asked, shared);
        after.drive = before.drive.clone();
        assert_ne!(Asked::of(&after), shared);
        let mut shifted = before.clone();
        shifted.overlays[0].alignment.time_shift += 1e-4;
        assert_ne!(Asked::of(&shifted), asked);
        assert_ne!(Asked::of(&other_device(&before, 0.9)), asked);
        let live = SimulationRequest {
            mode: Mode::Live,
            ..before
        };
        assert_eq!(Asked::of(&live), None);
    }

    static RUNNING: AtomicUsize = AtomicUsize::new(0);
    static MOST_AT_ONCE: AtomicUsize = AtomicUsize::new(0);
    static CANCELLED: AtomicUsize = AtomicUsize::new(0);

    /// Ends a while after it was cancelled; only that for the newest device ends by itself.
    fn slow(asked: &Asked, cancel: &AtomicBool) -> Found {
        let now = RUNNING.fetch_add(1, Ordering::SeqCst) + 1;
        MOST_AT_ONCE.fetch_max(now, Ordering::SeqCst);
        let alpha = asked.model.parameters[ParameterId::Alpha];
        let begun = Instant::now();
        while alpha != 0.7 && begun.elapsed() < Duration::from_secs(60) {
            if cancel.load(Ordering::Relaxed) {
                CANCELLED.fetch_add(1, Ordering::SeqCst);
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(150));
        RUNNING.fetch_sub(1, Ordering::SeqCst);
        vec![Err(alpha.to_string()); asked.overlays.len()]
    }

    #[test]
    fn one_thread_computes_at_a_time_and_the_newest_request_gets_its_numbers() {
        let mut stretches = StretchMisfits::new(|| {});
        stretches.compute = slow;
        let request = request();
        let trace = Arc::new(Trace::default());
        let drive = &request.drive;
        let (model, overlays) = (&request.model, &request.overlays);
        let compared =
            crate::app::simulation::experiments::compare_all(model, drive, &trace, overlays);
        let shown = Snapshot::new(1, model, trace, compared, Duration::ZERO);
        assert!(stretches.complete(&shown, &request).is_none());
        // A request that asks for the same cancels nothing, one for another device does.
        stretches.cancel_unless_asked(&request);
        let (_, flag) = stretches.running.clone().unwrap();
        assert!(!flag.load(Ordering::Relaxed));
        let newest = other_device(&request, 0.7);
        for changed in [other_device(&request, 0.5), other_device(&request, 0.6)] {
            stretches.cancel_unless_asked(&changed);
            assert!(stretches.complete(&shown, &changed).is_none());
        }
        assert!(flag.load(Ordering::Relaxed) && stretches.is_waiting());
        let begun = Instant::now();
        let complete = loop {
            assert!(begun.elapsed() < Duration::from_secs(60));
            if let Some(complete) = stretches.complete(&shown, &newest) {
                break complete;
            }
            assert!(stretches.is_waiting(), "nobody would ask again");
            std::thread::sleep(Duration::from_millis(5));
        };
        for comparison in &complete.comparisons {
            assert_eq!(comparison.stretches, Some(Err("0.7".to_owned())));
        }
        assert_eq!(complete.total_stretch_misfit(), None);
        assert!(!stretches.is_waiting());
        assert_eq!(MOST_AT_ONCE.load(Ordering::SeqCst), 1);
        assert!(CANCELLED.load(Ordering::SeqCst) >= 1);
    }

    #[test]
    fn one_unusable_recording_takes_no_number_from_the_others() {
        // A number is how many recordings it was found with.
        let without = |bad: &'static [usize]| {
            move |these: &[usize]| match these.iter().find(|k| bad.contains(k)) {
                Some(k) => Err(format!("{k} cannot be used")),
                None => Ok(vec![these.len(); these.len()]),
            }
        };
        assert_eq!(usable_together(3, without(&[])), [Ok(3), Ok(3), Ok(3)]);
        let reason = Err("1 cannot be used".to_owned());
        assert_eq!(
            usable_together(3, without(&[1])),
            [Ok(2), reason.clone(), Ok(2)]
        );
        assert_eq!(usable_together(2, without(&[1])), [Ok(1), reason.clone()]);
        assert_eq!(usable_together(2, without(&[0, 1]))[1], reason);
    }
}
