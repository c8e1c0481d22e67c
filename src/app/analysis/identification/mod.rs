//! The paper's identification, step by step: which steps the recordings allow, the running
//! one, and the result of each. Nothing is applied without the person's consent.

mod course;
mod plan;

use std::collections::BTreeMap;
use std::sync::Arc;

use eframe::egui::Context;
use serde::{Deserialize, Serialize};

pub use self::plan::{Course, WholeFit};
use crate::app::analysis::job::Job;
use crate::app::analysis::origin::{Origin, Source, recordings, shared_drive};
use crate::app::analysis::recording_roles::with_role;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::{OverlayId, Role};
use crate::fit::contact_readings::ContactReadings;
use crate::fit::contact_sample::Sampled;
use crate::fit::paper_steps::guide::{Allowance, Guidance, Step, guide};
use crate::fit::paper_steps::outcome::{StepResult, take};
use crate::fit::{Control, FitOptions, Progress};
use crate::model::Model;

/// What the thread sends.
#[derive(Debug, Clone)]
pub enum StepEvent {
    /// Which steps are possible.
    Guide(Guidance),
    /// The result of a step.
    Found(StepResult),
}

/// Recordings as they were set up, and the name of the device.
type Seen = (Vec<(OverlayId, Source)>, String);

/// What the guide used and read, so that the steps need not read it again.
#[derive(Debug, Clone)]
struct Looked {
    model: Arc<Model>,
    readings: Option<Arc<ContactReadings>>,
}

/// State of the identification panel.
#[derive(Debug, Clone, Default)]
pub struct Identification {
    /// Whether it is open.
    pub open: bool,
    /// Which steps are possible, for the recordings and the device of `seen`.
    pub allowances: Vec<Allowance>,
    /// What to do before any step.
    pub first: Option<String>,
    /// How much of long recordings the guide read.
    pub sampled: Option<Sampled>,
    seen: Option<Seen>,
    /// The device they are valid for, with what was read about the ground.
    looked: Option<Looked>,
    /// The running step; `None` inside while the recordings are examined.
    pub job: Option<(Option<Step>, Job<Progress, StepEvent>)>,
    /// What the running step is given.
    asked: Option<Origin>,
    /// Name of the device that the results belong to.
    of: String,
    /// Results by the id of the step, or why it failed.
    pub findings: BTreeMap<&'static str, Result<StepResult, String>>,
    /// What each result was computed from, by the id of the step.
    pub origins: BTreeMap<&'static str, Origin>,
    /// The step shown.
    pub chosen: Option<Step>,
    /// What it does on its own, as the person asked.
    pub course: Course,
    /// The fit of the whole device that the present values come from.
    pub whole: Option<WholeFit>,
}

/// What a session has of the guide and of the results' origins. The results themselves are kept
/// one by one.
#[derive(Debug, Serialize, Deserialize)]
pub struct Stored {
    open: bool,
    allowances: Vec<Allowance>,
    first: Option<String>,
    sampled: Option<Sampled>,
    seen: Option<Seen>,
    /// The device that the guide is valid for.
    looked: Option<Arc<Model>>,
    of: String,
    failed: BTreeMap<String, String>,
    origins: BTreeMap<String, Origin>,
    chosen: Option<Step>,
    whole: Option<WholeFit>,
}

impl Identification {
    /// Takes the results of the thread, and examines the recordings again if they have changed.
    pub fn poll(&mut self, setup: &Setup, context: &Context) {
        self.collect(setup);
        if self.job.is_none() && self.seen.as_ref() != Some(&seen(setup)) {
            self.look(setup, context);
        }
    }

    /// What a session keeps of it.
    pub fn stored(&self) -> Stored {
        let failed = self.findings.iter().filter_map(|(id, found)| {
            let error = found.as_ref().err()?;
            Some(((*id).to_owned(), error.clone()))
        });
        let origins = self.origins.iter();
        // While recordings are examined, what is known of them is not complete.
        let is_known = self.job.as_ref().is_none_or(|(step, _)| step.is_some());
        Stored {
            open: self.open,
            allowances: self.allowances.clone(),
            first: self.first.clone(),
            sampled: self.sampled,
            seen: self.seen.clone().filter(|_| is_known),
            looked: (self.looked.as_ref())
                .filter(|_| is_known)
                .map(|looked| Arc::clone(&looked.model)),
            of: self.of.clone(),
            failed: failed.collect(),
            origins: origins
                .map(|(id, origin)| ((*id).to_owned(), origin.clone()))
                .collect(),
            whole: self.whole.clone(),
            chosen: self.chosen,
        }
    }

    /// The state that a session kept, with its results.
    pub fn restored(stored: Stored, found: Vec<(Step, StepResult)>) -> Self {
        let mut findings: BTreeMap<&'static str, Result<StepResult, String>> = BTreeMap::new();
        let id = |id: &String| Step::find(id).map(Step::id);
        for (step, error) in &stored.failed {
            findings.extend(id(step).map(|id| (id, Err(error.clone()))));
        }
        findings.extend(
            found
                .into_iter()
                .map(|(step, found)| (step.id(), Ok(found))),
        );
        let origins = stored.origins.into_iter();
        Self {
            open: stored.open,
            allowances: stored.allowances,
            first: stored.first,
            sampled: stored.sampled,
            seen: stored.seen,
            // The steps read the ground again: its readings may be many.
            looked: stored.looked.map(|model| Looked {
                model,
                readings: None,
            }),
            job: None,
            asked: None,
            of: stored.of,
            findings,
            origins: origins
                .filter_map(|(step, origin)| Some((id(&step)?, origin)))
                .collect(),
            chosen: stored.chosen,
            course: Course::ByHand,
            whole: stored.whole,
        }
    }

    /// In what the setup differs from that of a step's result.
    pub fn differences(&self, step: Step, setup: &Setup) -> Option<String> {
        self.origins.get(step.id())?.differences(setup)
    }

    /// Takes the results of the thread, whether or not the panel is open.
    pub fn collect(&mut self, setup: &Setup) {
        if self.of != setup.preset.model.name {
            // Results of one device must not be applied to another.
            self.of.clone_from(&setup.preset.model.name);
            self.findings.clear();
            self.course = Course::ByHand;
            self.whole = None;
            self.origins.clear();
            if let Some((_, job)) = self.job.take() {
                job.cancel();
            }
        }
        if let Some((step, job)) = &self.job
            && let Some(result) = job.take()
        {
            match (step, result) {
                // A cancelled examination has no result.
                (_, Ok(StepEvent::Guide(_))) if job.is_cancelled() => self.looked = None,
                (_, Ok(StepEvent::Guide(found))) => {
                    self.allowances = found.allowances;
                    self.first = found.first;
                    self.sampled = found.sampled;
                    if let Some(looked) = &mut self.looked {
                        looked.readings = found.readings.map(Arc::new);
                    }
                }
                // A cancelled step has not failed: its earlier result stays.
                (Some(_), Err(_)) if job.is_cancelled() => {}
                (Some(step), Ok(StepEvent::Found(finding))) => {
                    let origin = self.asked.take();
                    self.origins
                        .extend(origin.map(|origin| (step.id(), origin)));
                    self.findings.insert(step.id(), Ok(finding));
                }
                (Some(step), Err(error)) => {
                    let origin = self.asked.take();
                    self.origins
                        .extend(origin.map(|origin| (step.id(), origin)));
                    self.findings.insert(step.id(), Err(error));
                }
                (None, _) => self.looked = None,
            }
            self.job = None;
        }
    }

    /// Whether the guide knows which steps the recordings allow.
    pub fn has_looked(&self) -> bool {
        !self.allowances.is_empty()
    }

    /// Examines which steps the recordings allow for the present device.
    pub fn look(&mut self, setup: &Setup, context: &Context) {
        let model = Arc::new(setup.preset.model.clone());
        let recordings = recordings(setup, Role::Train);
        self.seen = Some(seen(setup));
        self.allowances.clear();
        self.first = None;
        self.sampled = None;
        self.looked = Some(Looked {
            model: Arc::clone(&model),
            readings: None,
        });
        let job = Job::start("guide", context, move |control| {
            let report = |progress: &Progress| control.report(progress.clone());
            let control = Control {
                cancel: control.cancel(),
                progress: &report,
            };
            let options = FitOptions::for_model(&model);
            Ok(StepEvent::Guide(guide(
                &model,
                &recordings,
                &options,
                &control,
            )))
        });
        self.job = Some((None, job));
    }

    /// Whether the guide is valid for the present device.
    pub fn is_current(&self, setup: &Setup) -> bool {
        let looked = self.looked.as_ref();
        looked.is_some_and(|looked| *looked.model == setup.preset.model)
    }

    /// Runs a step with the present device.
    pub fn start(&mut self, step: Step, setup: &Setup, context: &Context) {
        let (model, recordings) = (setup.preset.model.clone(), recordings(setup, Role::Train));
        // A step uses no held-out recordings, but their roles say which are left for it.
        self.asked = Some(Origin::of(setup));
        self.chosen = Some(step);
        let known = self
            .looked
            .as_ref()
            .filter(|looked| *looked.model == model && self.seen.as_ref() == Some(&seen(setup)));
        let known = known.and_then(|looked| looked.readings.clone());
        let job = Job::start(step.id(), context, move |control| {
            let report = |progress: &Progress| control.report(progress.clone());
            let control = Control {
                cancel: control.cancel(),
                progress: &report,
            };
            let options = FitOptions::for_model(&model);
            let found = take(
                step,
                &model,
                &recordings,
                known.as_ref(),
                &options,
                &control,
            );
            found.map(StepEvent::Found).map_err(|e| e.to_string())
        });
        self.job = Some((Some(step), job));
    }
}

fn seen(setup: &Setup) -> Seen {
    let used = with_role(setup, Role::Train);
    let shared = shared_drive(setup);
    let placed = used.map(|o| (o.id, Source::of(o, shared.as_ref(), Role::Train)));
    (placed.collect(), setup.preset.model.name.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::files::built_in;
    use crate::model::preset::Preset;

    #[test]
    fn results_of_one_device_are_not_shown_for_another() {
        let mut setup = built_in::setup();
        let context = Context::default();
        let mut identification = Identification::default();
        identification.poll(&setup, &context);
        let failed = Err("no slow cycle".to_owned());
        identification.findings.insert(Step::Drive.id(), failed);
        setup
            .preset
            .model
            .parameters
            .set(crate::model::parameter::ParameterId::Alpha, 0.3);
        identification.poll(&setup, &context);
        assert_eq!(identification.findings.len(), 1);
        let (_, job) = identification.job.clone().unwrap();
        setup.preset = Preset::load("oscillator").unwrap();
        identification.poll(&setup, &context);
        assert!(identification.findings.is_empty() && job.is_cancelled());
    }
}
