//! What each slider changes in the residual, computed on a thread of its own while its tool is open:
//! anew whenever the simulator has sent another result, and given up for a newer one.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Weak};

use eframe::egui::Context;

use super::job::Job;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::OverlayId;
use crate::app::simulation::experiments::shown_experiment;
use crate::app::simulation::snapshot::Snapshot;
use crate::fit::experiment::{
    Experiment, ExperimentError, ExperimentResult, Influence, Probe, Sensitivity, sensitivity,
};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::parameter::{ParameterId, ParameterSpec, Scale};
use crate::sim::{Options, simulate_while};

/// Share of a parameter's value, or of its slider, that influences are stated for.
pub const STEP_SHARE: f64 = 0.01;
/// Correlation of two columns above which two sliders do nearly the same.
const TWIN_CORRELATION: f64 = 0.95;

/// State of the sensitivity tool.
#[derive(Debug, Clone, Default)]
pub struct Sensing {
    /// Whether its panel is open.
    pub open: bool,
    /// The slider whose column stays in the residual, and the one under the pointer.
    pub selected: Option<String>,
    /// See `selected`.
    pub hovered: Option<String>,
    /// Why there is no result.
    pub error: Option<String>,
    job: Option<Job<f64, Sensitivity>>,
    asked: Option<Arc<Asked>>,
    found: Option<Arc<Found>>,
    /// The result of the simulator that was looked at last.
    seen: Weak<Snapshot>,
}

/// A result, and what it belongs to.
#[derive(Debug)]
pub struct Found {
    /// The device.
    pub model: Arc<Model>,
    /// The recordings, in the order of the columns.
    pub overlays: Vec<OverlayId>,
    /// The result.
    pub sensitivity: Sensitivity,
    /// Pairs of sliders that do nearly the same, see [`Sensitivity::twins`].
    pub twins: Vec<(usize, usize, f64)>,
}

impl Found {
    /// A result for a device and recordings.
    pub fn new(model: &Arc<Model>, overlays: &[OverlayId], sensitivity: Sensitivity) -> Self {
        Self {
            model: Arc::clone(model),
            overlays: overlays.to_vec(),
            twins: sensitivity.twins(TWIN_CORRELATION),
            sensitivity,
        }
    }
}

/// What a result depends on.
#[derive(Debug)]
struct Asked {
    model: Arc<Model>,
    overlays: Vec<OverlayId>,
    experiments: Vec<Experiment>,
    /// For those compared with the simulation itself: its drive, span and rate.
    shared: Vec<Option<(Waveform, f64, f64)>>,
    probes: Vec<Probe>,
}

impl PartialEq for Asked {
    fn eq(&self, other: &Self) -> bool {
        let same = |(a, b): (&Experiment, &Experiment)| {
            Arc::ptr_eq(&a.recording, &b.recording)
                && a.drive == b.drive
                && a.start == b.start
                && a.alignment == b.alignment
                && a.priors == b.priors
                && a.noise == b.noise
        };
        self.overlays == other.overlays
            && self.model == other.model
            && self.probes == other.probes
            && self.shared == other.shared
            && self.experiments.iter().zip(&other.experiments).all(same)
    }
}

/// All sliders of the device: its parameters and those of its effects.
pub fn probes(setup: &Setup) -> Vec<Probe> {
    let model = &setup.preset.model;
    let used = ParameterId::ALL.into_iter().filter(|id| model.uses(*id));
    let mut all: Vec<Probe> = used
        .map(|id| {
            let spec = ParameterSpec {
                range: setup.preset.range(id),
                ..*id.spec()
            };
            probe(spec.id.to_owned(), &spec, model.parameters[id])
        })
        .collect();
    for effect in &model.effects {
        for (i, spec) in effect.spec.parameters.iter().enumerate() {
            if effect.is_moved_by(i) {
                let id = format!("{}.{}", effect.spec.id, spec.id);
                all.push(probe(id, spec, effect.values[i]));
            }
        }
    }
    all
}

/// A suggestion stays on the slider.
fn probe(id: String, spec: &ParameterSpec, value: f64) -> Probe {
    let (low, high) = (spec.range.0.min(value), spec.range.1.max(value));
    let is_ratio = is_share_of_value(spec.scale, value);
    Probe {
        id,
        step: STEP_SHARE * if is_ratio { value } else { high - low },
        scale: if is_ratio { Scale::Log } else { Scale::Linear },
        limits: (low.max(spec.limits.0), high.min(spec.limits.1)),
    }
}

/// Whether a step is a share of the value, and not of the slider.
fn is_share_of_value(scale: Scale, value: f64) -> bool {
    scale == Scale::Log && value > 0.0
}

/// What is asked about a result of the simulator: the recordings that were compared and have noise.
fn asked_about(setup: &Setup, snapshot: &Snapshot) -> Asked {
    let mut asked = Asked {
        model: Arc::clone(&snapshot.model),
        overlays: Vec::new(),
        experiments: Vec::new(),
        shared: Vec::new(),
        probes: probes(setup),
    };
    for compared in &snapshot.comparisons {
        if compared.misfit().is_none() {
            continue;
        }
        let overlay = setup.overlays.iter().find(|o| o.id == compared.id);
        let Some(overlay) = overlay.filter(|o| o.visible) else {
            continue;
        };
        let shared = match (&compared.own, &snapshot.run_of) {
            (Some(_), _) => None,
            (None, Some((drive, span))) => Some((drive.clone(), *span, 1.0 / snapshot.trace.dt)),
            // A live run cannot be repeated.
            (None, None) => continue,
        };
        let drive = shared.as_ref().map(|(drive, ..)| drive);
        let Some(experiment) = shown_experiment(overlay, compared, drive) else {
            continue;
        };
        asked.overlays.push(overlay.id);
        asked.experiments.push(experiment);
        asked.shared.push(shared);
    }
    asked
}

impl Sensing {
    /// Follows the simulator: takes a finished result, gives up what is outdated, and starts anew
    /// when nothing is being dragged (`busy`).
    pub fn update(
        &mut self,
        setup: &Setup,
        snapshot: Option<&Arc<Snapshot>>,
        busy: bool,
        context: &Context,
    ) {
        self.take();
        let usable = snapshot.filter(|shown| self.open && shown.live.is_none());
        let Some(snapshot) = usable else {
            self.stop();
            return;
        };
        let is_seen = std::ptr::eq(self.seen.as_ptr(), Arc::as_ptr(snapshot));
        // What is shown may be the curve of a fit, or of the values before the last change.
        let is_newest = *snapshot.model == setup.preset.model;
        if is_seen && is_newest {
            return;
        }
        if !is_newest || busy {
            if self
                .asked
                .as_ref()
                .is_some_and(|a| a.model != snapshot.model)
            {
                self.stop();
            }
            return;
        }
        self.seen = Arc::downgrade(snapshot);
        let asked = asked_about(setup, snapshot);
        if self.asked.as_deref() == Some(&asked) {
            return;
        }
        self.stop();
        self.error = None;
        if asked.experiments.is_empty() {
            self.found = None;
            return;
        }
        let asked = Arc::new(asked);
        self.asked = Some(Arc::clone(&asked));
        self.job = Some(start(asked, context));
    }

    fn take(&mut self) {
        let Some(result) = self.job.as_ref().and_then(Job::take) else {
            return;
        };
        self.job = None;
        match (result, &self.asked) {
            (Ok(sensitivity), Some(asked)) => {
                let found = Found::new(&asked.model, &asked.overlays, sensitivity);
                self.found = Some(Arc::new(found));
            }
            (Err(error), _) => self.error = Some(error),
            (Ok(_), None) => {}
        }
    }

    /// Gives up what is being computed. The last result stays until there is another.
    fn stop(&mut self) {
        if let Some(job) = self.job.take() {
            job.cancel();
        }
        self.asked = None;
        self.seen = Weak::new();
    }

    /// The job in progress.
    pub fn job(&self) -> Option<&Job<f64, Sensitivity>> {
        self.job.as_ref()
    }

    /// The share done of a result that is being computed.
    pub fn progress(&self) -> Option<f64> {
        let job = self.job.as_ref()?;
        Some(job.progress().unwrap_or(0.0))
    }

    /// The newest result, of whatever device.
    pub fn found(&self) -> Option<&Arc<Found>> {
        self.found.as_ref()
    }

    /// The result for the device of a run.
    pub fn found_for(&self, snapshot: &Snapshot) -> Option<&Arc<Found>> {
        let found = self.found.as_ref()?;
        let is_same = Arc::ptr_eq(&found.model, &snapshot.model) || *found.model == *snapshot.model;
        (self.open && is_same).then_some(found)
    }

    /// The slider whose column is drawn over the residual.
    pub fn looked_at(&self) -> Option<&Influence> {
        let id = self.hovered.as_ref().or(self.selected.as_ref())?;
        let all = &self.found.as_ref()?.sensitivity.influences;
        all.iter().find(|influence| influence.id == *id)
    }
}

fn start(asked: Arc<Asked>, context: &Context) -> Job<f64, Sensitivity> {
    Job::start("sensitivity", context, move |control| {
        let go_on = || !control.cancel().load(Ordering::Relaxed);
        let (count, finished) = (asked.probes.len().max(1), AtomicUsize::new(0));
        let done = || {
            let finished = finished.fetch_add(1, Ordering::Relaxed) + 1;
            control.report(finished as f64 / count as f64);
        };
        let run = |i: usize, model: &Model| run_one(&asked, i, model, go_on);
        let (model, experiments) = (&asked.model, &asked.experiments);
        match sensitivity(model, experiments, &asked.probes, &run, &done) {
            Ok(Some(found)) => Ok(found),
            Ok(None) => Err("it was cancelled".to_owned()),
            Err(error) => Err(error.to_string()),
        }
    })
}

/// Simulates an experiment as it is shown, with another device.
fn run_one(
    asked: &Asked,
    i: usize,
    model: &Model,
    go_on: impl Fn() -> bool,
) -> Result<Option<ExperimentResult>, ExperimentError> {
    let experiment = &asked.experiments[i];
    let Some((drive, span, rate)) = &asked.shared[i] else {
        return experiment.run(model, go_on);
    };
    let options = Options {
        rate: *rate,
        ..Options::default()
    };
    match simulate_while(model, drive, *span, &options, go_on)? {
        Some(trace) => experiment.compare(Arc::new(trace)).map(Some),
        None => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::files::built_in;
    use crate::app::simulation::experiments::experiment_of;
    use crate::sim::StartState;

    #[test]
    fn another_start_is_another_question() {
        let setup = built_in::setup();
        let model = Arc::new(setup.preset.model.clone());
        let overlay = &setup.overlays[0];
        let asked = |start| {
            let mut experiment = experiment_of(overlay, Waveform::Rest, 0.0);
            experiment.start = start;
            Asked {
                model: Arc::clone(&model),
                overlays: vec![overlay.id],
                experiments: vec![experiment],
                shared: vec![None],
                probes: probes(&setup),
            }
        };
        let start = StartState::of_model(&model).unwrap();
        assert_eq!(asked(None), asked(None));
        assert_eq!(asked(Some(start.clone())), asked(Some(start.clone())));
        assert_ne!(asked(Some(start)), asked(None));
    }
}
