//! Running a fit, and its result. A fit changes nothing by itself: the person applies its
//! values.

use std::collections::BTreeSet;
use std::sync::Arc;

use eframe::egui::Context;
use serde::{Deserialize, Serialize};

use super::job::Job;
use super::origin::{Origin, recordings};
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::Role;
use crate::fit::{
    Control, FitOptions, FitResult, Part, ProfilePoint, Progress, default_free, fit, profile_of,
};
use crate::model::Model;

/// State of the fit panel.
#[derive(Debug, Clone, Default)]
pub struct Fitting {
    /// Whether its panel is open.
    pub open: bool,
    /// Parameters ticked; `None` for the default selection.
    pub free: Option<BTreeSet<String>>,
    /// The running fit.
    pub job: Option<Job<Progress, FitResult>>,
    /// Ids of the fitted parameters, and the model the fit started from.
    pub moved: (Vec<String>, Option<Arc<Model>>),
    /// What the last fit was asked.
    pub(crate) asked: Option<Arc<Asked>>,
    /// The fit before the one that is running; saved until that one has ended.
    previous: Option<Finished>,
    /// Result of the last fit.
    pub result: Option<Arc<FitResult>>,
    /// Why the last fit failed.
    pub error: Option<String>,
    /// The profile likelihood of one parameter.
    pub profile: Profile,
    /// Whether the plots show the fitted curve, while the fit runs and until it is applied or
    /// discarded.
    pub shown: bool,
}

/// The input of a fit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Asked {
    /// The device and the recordings.
    pub origin: Origin,
    /// The device that the fit started from.
    pub start: Arc<Model>,
    /// The options.
    pub options: FitOptions,
    /// The parts of recordings that were fitted to; `None` after a session was opened.
    #[serde(skip)]
    parts: Option<Vec<Part>>,
}

impl Asked {
    /// The present device and recordings of a setup; `parts` of these are fitted to.
    pub(crate) fn of(setup: &Setup, options: FitOptions, parts: Option<Vec<Part>>) -> Self {
        Self {
            origin: Origin::of(setup),
            start: Arc::new(setup.preset.model.clone()),
            options,
            parts,
        }
    }

    /// The parts of recordings that were fitted to, if they are still open.
    fn parts(&self, setup: &Setup) -> Option<Vec<Part>> {
        if let Some(parts) = &self.parts {
            return Some(parts.clone());
        }
        let of = |role| self.origin.recordings(setup, role);
        Some(Part::sides(of(Role::Train)?, of(Role::HeldOut)?).0)
    }
}

/// A finished fit with its input.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The result.
    pub result: Arc<FitResult>,
    /// The input.
    pub asked: Arc<Asked>,
}

/// A profile likelihood on request.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    /// The chosen parameter.
    pub id: Option<String>,
    /// The running profile, with its parameter.
    pub job: Option<(String, Job<Progress, Vec<ProfilePoint>>)>,
    /// The last one, with its parameter.
    pub result: Option<(String, Result<Vec<ProfilePoint>, String>)>,
    /// Whether the last one was cancelled before its last point.
    pub is_incomplete: bool,
}

/// Points of a profile, in standard errors of the parameter from its fitted value.
const PROFILE_SHIFTS: [f64; 9] = [-3.0, -2.0, -1.2, -0.5, 0.0, 0.5, 1.2, 2.0, 3.0];

impl Profile {
    /// Cancels the running profile and removes the last one: their fit result is gone.
    fn clear(&mut self) {
        if let Some((_, job)) = self.job.take() {
            job.cancel();
        }
        self.result = None;
    }
}

impl Fitting {
    /// Ids of the parameters to fit: those ticked, without the locked ones.
    pub fn free(&self, setup: &Setup) -> Vec<String> {
        let model = &setup.preset.model;
        let ticked = |id: &String| match &self.free {
            Some(free) => free.contains(id),
            // What is known is fitted against that knowledge.
            None => default_free(model).contains(id) || is_known(setup, id),
        };
        // Those that are free by default come first, in the order of the command line.
        let mut ids = default_free(model);
        let more = candidates(model);
        ids.extend(
            more.into_iter()
                .filter(|id| !default_free(model).contains(id)),
        );
        ids.into_iter()
            .filter(|id| ticked(id) && !setup.locked.contains(id))
            .collect()
    }

    /// The last finished fit, also while another one runs.
    pub fn finished(&self) -> Option<Finished> {
        match (&self.result, &self.asked) {
            (Some(result), Some(asked)) => Some(Finished {
                result: Arc::clone(result),
                asked: Arc::clone(asked),
            }),
            _ => self.previous.clone(),
        }
    }

    /// Shows a fit that was finished earlier.
    pub fn adopt(&mut self, Finished { result, asked }: Finished) {
        self.moved = (asked.options.free.clone(), Some(Arc::clone(&asked.start)));
        (self.result, self.asked) = (Some(result), Some(asked));
    }

    /// In what the setup differs from that of the result.
    pub fn differences(&self, setup: &Setup) -> Option<String> {
        self.result.as_ref()?;
        self.asked.as_ref()?.origin.differences(setup)
    }

    /// Why no profile can be computed around the result, if so.
    pub fn profile_obstacle(&self, setup: &Setup) -> Option<&'static str> {
        let asked = self.asked.as_ref();
        let has_parts = asked.is_some_and(|asked| asked.parts(setup).is_some());
        (!has_parts).then_some("The recordings that were fitted to are not open, or have changed")
    }

    /// Starts a fit of the present device.
    pub fn start(&mut self, setup: &Setup, context: &Context) {
        self.previous = self.finished();
        self.error = None;
        self.result = None;
        self.profile.clear();
        let model = setup.preset.model.clone();
        let (train, held_out, options) = inputs(setup, self.free(setup));
        let asked = Asked::of(setup, options.clone(), Some(train.clone()));
        self.moved = (options.free.clone(), Some(Arc::clone(&asked.start)));
        self.asked = Some(Arc::new(asked));
        self.shown = true;
        self.job = Some(Job::start("fit", context, move |control| {
            let report = |progress: &Progress| control.report(progress.clone());
            let control = Control {
                cancel: control.cancel(),
                progress: &report,
            };
            fit(&model, &train, &held_out, &options, &control).map_err(|e| e.to_string())
        }));
    }

    /// Takes the result of a finished fit. If a slider has moved since the fit started, the
    /// plots show the slider values again.
    pub fn poll(&mut self, setup: &Setup) {
        let (_, start) = &self.moved;
        if start.as_deref() != Some(&setup.preset.model) {
            self.shown = false;
        }
        if let Some((id, job)) = &self.profile.job
            && let Some(points) = job.take()
        {
            let missing = points
                .as_ref()
                .is_ok_and(|points| points.len() < PROFILE_SHIFTS.len());
            self.profile.is_incomplete = missing && job.is_cancelled();
            self.profile.result = Some((id.clone(), points));
            self.profile.job = None;
        }
        let Some(result) = self.job.as_ref().and_then(Job::take) else {
            return;
        };
        self.job = None;
        self.previous = None;
        match result {
            Ok(result) => self.result = Some(Arc::new(result)),
            Err(error) => {
                self.error = Some(error);
                self.shown = false;
            }
        }
    }

    /// The model shown instead of the device's own, if any.
    pub fn preview(&self) -> Option<Model> {
        if !self.shown {
            return None;
        }
        if let Some(result) = &self.result {
            return Some(result.model.clone());
        }
        let progress = self.job.as_ref()?.progress()?;
        let (ids, start) = &self.moved;
        let mut model = start.as_deref()?.clone();
        for (id, value) in ids.iter().zip(&progress.values) {
            model.set(id, *value).ok()?;
        }
        model.check().is_ok().then_some(model)
    }

    /// Starts the profile of the chosen parameter around the last result, with the same
    /// recordings.
    pub fn start_profile(&mut self, setup: &Setup, context: &Context) {
        let (Some(result), Some(asked)) = (self.result.clone(), self.asked.clone()) else {
            return;
        };
        let (Some(id), Some(train)) = (self.profile.id.clone(), asked.parts(setup)) else {
            return;
        };
        self.profile.result = None;
        let of = id.clone();
        let job = Job::start("profile", context, move |control| {
            let report = |progress: &Progress| control.report(progress.clone());
            let control = Control {
                cancel: control.cancel(),
                progress: &report,
            };
            let points = profile_of(
                &result,
                &train,
                &of,
                &PROFILE_SHIFTS,
                &asked.options,
                &control,
            );
            points.map_err(|e| e.to_string())
        });
        self.profile.job = Some((id, job));
    }

    /// Discards the result and its profile.
    pub fn discard(&mut self) {
        self.result = None;
        self.previous = None;
        self.profile.clear();
        self.shown = false;
    }

    /// Whether the device has the fitted values.
    pub fn is_applied(&self, setup: &Setup) -> bool {
        let model = &setup.preset.model;
        self.result.as_ref().is_some_and(|result| {
            let mut all = result.parameters.iter();
            result.model.name == model.name && all.all(|p| model.get(&p.id) == Some(p.value))
        })
    }

    /// Applies the fitted values to the device.
    pub fn apply(&mut self, setup: &mut Setup) {
        if let Some(result) = &self.result {
            for parameter in &result.parameters {
                // These ids belong to the fitted device; the present one may lack some.
                let _ = setup.preset.model.set(&parameter.id, parameter.value);
            }
            self.shown = false;
        }
    }
}

/// Ids that can be fitted, of the device and its effects.
pub fn candidates(model: &Model) -> Vec<String> {
    let own = model.parameters.iter().map(|(id, _)| id);
    let mut ids: Vec<String> = own
        .filter(|id| model.uses(*id) && is_physical(*id))
        .map(|id| id.spec().id.to_owned())
        .collect();
    ids.extend(model.effect_ids());
    ids
}

/// Whether a parameter belongs to the device. Those of the run and the sensor are estimated
/// for each recording anyway.
fn is_physical(id: crate::model::parameter::ParameterId) -> bool {
    use crate::model::parameter::ParameterId as P;
    !matches!(id, P::X0 | P::V0 | P::OffsetP | P::OffsetC | P::Noise)
}

/// Whether the preset knows a parameter beforehand.
fn is_known(setup: &Setup, id: &str) -> bool {
    setup.preset.known.iter().any(|known| known.id == id)
}

/// What a fit in the window is given: parts to fit, parts held out, and the options, for the
/// parameters `free`. The command line gives the same for the same recordings.
pub(crate) fn inputs(setup: &Setup, free: Vec<String>) -> (Vec<Part>, Vec<Part>, FitOptions) {
    let (train, held_out) = (
        recordings(setup, Role::Train),
        recordings(setup, Role::HeldOut),
    );
    let (train, held_out) = Part::sides(train, held_out);
    let known = setup.preset.known.iter();
    let options = FitOptions {
        known: known
            .filter(|known| free.contains(&known.id))
            .cloned()
            .collect(),
        free,
        ..FitOptions::for_model(&setup.preset.model)
    };
    (train, held_out, options)
}

#[cfg(test)]
mod tests {
    use super::super::fit::*;
    use crate::app::files::built_in;

    #[test]
    fn ticked_parameters_are_fitted_unless_they_are_locked() {
        let mut setup = built_in::setup();
        let mut fitting = Fitting::default();
        let usual = fitting.free(&setup);
        assert!(usual.iter().any(|id| id == "Cs") && !usual.iter().any(|id| id == "f1"));
        setup.locked.insert("Cs".to_owned());
        assert!(!fitting.free(&setup).contains(&"Cs".to_owned()));
        fitting.free = Some(["f1".to_owned(), "Cs".to_owned()].into());
        assert_eq!(fitting.free(&setup), ["f1"]);
    }

    #[test]
    fn a_profile_belongs_to_its_parameter_and_is_discarded_with_its_fit() {
        let setup = built_in::setup();
        let context = Context::default();
        let mut fitting = Fitting::default();
        let job = Job::start("profile", &context, |_| Ok(Vec::new()));
        fitting.profile.job = Some(("dp".to_owned(), job));
        // Another choice while it runs.
        fitting.profile.id = Some("gp".to_owned());
        while fitting.profile.job.is_some() {
            fitting.poll(&setup);
        }
        let made = fitting.profile.result.clone().unwrap();
        assert_eq!(made, ("dp".to_owned(), Ok(Vec::new())));
        let job = Job::start("profile", &context, |_| Ok(Vec::new()));
        fitting.profile.job = Some(("dp".to_owned(), job.clone()));
        fitting.start(&setup, &context);
        if let Some(fit) = &fitting.job {
            fit.cancel();
        }
        assert!(fitting.profile.result.is_none() && fitting.profile.job.is_none());
        assert!(job.is_cancelled());
    }
}
