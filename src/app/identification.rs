//! The paper's identification step by step: which steps the recordings allow, the one in
//! work, and what each has found. Nothing is applied without being asked for.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use eframe::egui::Context;

use super::fitting::{Fitting, aligned};
use super::job::Job;
use super::setup::{OverlayId, Role, Setup};
use crate::fit::readings::{Readings, readings};
use crate::fit::steps::adhesion::{Adhesion, adhesion};
use crate::fit::steps::drive::{DriveFit, fit_drive};
use crate::fit::steps::film::{Film, film};
use crate::fit::steps::guide::{Allowance, Guidance, Step, guide};
use crate::fit::steps::restitution::{Restitution, restitution};
use crate::fit::steps::sensitivity::{Sensitivity, sensitivity};
use crate::fit::{Control, FitError, FitOptions, Part, Progress};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::recording::Recording;
use crate::recording::align::Alignment;

/// What a step has found.
#[derive(Debug, Clone)]
pub enum Finding {
    /// Branches of the drive.
    Drive(Arc<DriveFit>),
    /// Restitution.
    Restitution(Arc<Restitution>),
    /// Adhesion.
    Adhesion(Arc<Adhesion>),
    /// The film.
    Film(Arc<Film>),
    /// The sensitivity.
    Sensitivity(Arc<Sensitivity>),
}

/// What the thread beside the window brings.
#[derive(Debug, Clone)]
pub enum News {
    /// Which steps are allowed.
    Guide(Guidance),
    /// What one found.
    Found(Finding),
}

/// Recordings, where they are put, and the name of the device.
type Seen = (Vec<(OverlayId, Alignment)>, String);

/// What the guide has looked with and read; the steps need not read it again.
#[derive(Debug, Clone)]
struct Looked {
    model: Arc<Model>,
    readings: Option<Arc<Readings>>,
}

/// State of the window.
#[derive(Debug, Clone, Default)]
pub struct Identification {
    /// Whether it is open.
    pub open: bool,
    /// Which steps are allowed, for the recordings and the device of `seen`.
    pub allowances: Vec<Allowance>,
    seen: Option<Seen>,
    /// The device that they hold for, with what was read of the ground.
    looked: Option<Looked>,
    /// The step in work; none while the recordings are looked at.
    pub job: Option<(Option<Step>, Job<Progress, News>)>,
    /// What has been found, by the step's id; or why not.
    pub findings: BTreeMap<&'static str, Result<Finding, String>>,
    /// The step that is looked at.
    pub chosen: Option<Step>,
}

/// The recordings that the fit panel uses.
fn recordings(setup: &Setup, fitting: &Fitting) -> Vec<Arc<Recording>> {
    let used = setup
        .overlays
        .iter()
        .filter(|overlay| fitting.role(overlay) == Role::Train);
    used.map(aligned).collect()
}

impl Identification {
    /// Takes what a thread has brought, and looks at the recordings anew if they changed.
    pub fn poll(&mut self, setup: &Setup, fitting: &Fitting, context: &Context) {
        if let Some((step, job)) = &self.job
            && let Some(result) = job.take()
        {
            match (step, result) {
                // What was broken off says nothing.
                (_, Ok(News::Guide(_))) if job.is_cancelled() => self.looked = None,
                (_, Ok(News::Guide(found))) => {
                    self.allowances = found.allowances;
                    if let Some(looked) = &mut self.looked {
                        looked.readings = found.readings.map(Arc::new);
                    }
                }
                // Nor does a step that a person broke off fail: what it found before stays.
                (Some(_), Err(_)) if job.is_cancelled() => {}
                (Some(step), Ok(News::Found(finding))) => {
                    self.findings.insert(step.id(), Ok(finding));
                }
                (Some(step), Err(error)) => {
                    self.findings.insert(step.id(), Err(error));
                }
                (None, _) => self.looked = None,
            }
            self.job = None;
        }
        if self.job.is_none() && self.seen.as_ref() != Some(&seen(setup, fitting)) {
            self.look(setup, fitting, context);
        }
    }

    /// Looks which steps the recordings allow with the device as it is now.
    pub fn look(&mut self, setup: &Setup, fitting: &Fitting, context: &Context) {
        let model = Arc::new(setup.preset.model.clone());
        let recordings = recordings(setup, fitting);
        self.seen = Some(seen(setup, fitting));
        self.allowances.clear();
        self.looked = Some(Looked {
            model: Arc::clone(&model),
            readings: None,
        });
        let job = Job::start("guide", context, move |desk| {
            let report = |progress: &Progress| desk.report(progress.clone());
            let control = Control {
                cancel: desk.cancel(),
                progress: &report,
            };
            let options = FitOptions::for_model(&model);
            Ok(News::Guide(guide(&model, &recordings, &options, &control)))
        });
        self.job = Some((None, job));
    }

    /// Whether what the guide says holds for the device as it is now.
    pub fn is_current(&self, setup: &Setup) -> bool {
        let looked = self.looked.as_ref();
        looked.is_some_and(|looked| *looked.model == setup.preset.model)
    }

    /// Takes a step with the device as it is now.
    pub fn start(&mut self, step: Step, setup: &Setup, fitting: &Fitting, context: &Context) {
        let (model, recordings) = (setup.preset.model.clone(), recordings(setup, fitting));
        self.chosen = Some(step);
        let known = self.looked.as_ref().filter(|looked| {
            *looked.model == model && self.seen.as_ref() == Some(&seen(setup, fitting))
        });
        let known = known.and_then(|looked| looked.readings.clone());
        let job = Job::start(step.id(), context, move |desk| {
            let report = |progress: &Progress| desk.report(progress.clone());
            let control = Control {
                cancel: desk.cancel(),
                progress: &report,
            };
            take(step, &model, &recordings, known, &control).map(News::Found)
        });
        self.job = Some((Some(step), job));
    }
}

fn seen(setup: &Setup, fitting: &Fitting) -> Seen {
    let overlays = setup.overlays.iter();
    let used = overlays.filter(|overlay| fitting.role(overlay) == Role::Train);
    let placed = used.map(|overlay| (overlay.id, overlay.alignment));
    (placed.collect(), setup.preset.model.name.clone())
}

fn take(
    step: Step,
    model: &Model,
    recordings: &[Arc<Recording>],
    known: Option<Arc<Readings>>,
    control: &Control<'_>,
) -> Result<Finding, String> {
    let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
    let names = names.join(", ");
    let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
    let options = FitOptions::for_model(model);
    let read = || match &known {
        Some(readings) => Ok(Arc::clone(readings)),
        None => {
            let read = readings(model, &parts, &options, control).map_err(|e| e.to_string())?;
            // Readings broken off are some of them: a law through those would not say so.
            if control.cancel.load(Ordering::Relaxed) {
                return Err(FitError::Cancelled.to_string());
            }
            Ok(Arc::new(read))
        }
    };
    match step {
        Step::Drive => {
            let slices: Vec<&Recording> = recordings.iter().map(Arc::as_ref).collect();
            let fit = fit_drive(model, &slices).map_err(|e| e.to_string())?;
            Ok(Finding::Drive(Arc::new(fit)))
        }
        Step::Restitution => {
            let found = restitution(&names, read()?.as_ref()).map_err(|e| e.to_string())?;
            Ok(Finding::Restitution(Arc::new(found)))
        }
        Step::Adhesion => {
            let found = adhesion(&names, read()?.as_ref()).map_err(|e| e.to_string())?;
            Ok(Finding::Adhesion(Arc::new(found)))
        }
        Step::Film => {
            let found = film(model, &parts, &options, control);
            Ok(Finding::Film(Arc::new(found.map_err(|e| e.to_string())?)))
        }
        Step::Sensitivity => {
            let found = sensitivity(model, &parts, &options, control);
            let found = found.map_err(|e| e.to_string())?;
            Ok(Finding::Sensitivity(Arc::new(found)))
        }
    }
}

impl Finding {
    /// Gives the device what was found; the sensitivity is a comparison and changes
    /// nothing.
    pub fn apply(&self, model: &mut Model) {
        let p = &mut model.parameters;
        match self {
            Finding::Drive(found) => model.piezo = Some(found.piezo()),
            Finding::Restitution(found) => p.set(ParameterId::Alpha, found.mean),
            Finding::Adhesion(found) => {
                p.set(ParameterId::Ca, found.rate.0.max(0.0));
                p.set(ParameterId::Ca0, found.start.0.max(0.0));
            }
            Finding::Film(found) => {
                for id in [ParameterId::Cs, ParameterId::Gp] {
                    p.set(id, found.fit.model.parameters[id]);
                }
            }
            Finding::Sensitivity(_) => {}
        }
    }
}
