//! What the person has asked of a fit, and what came of it. A fit changes nothing by
//! itself: its values are applied when that is asked for.

use std::collections::BTreeSet;
use std::sync::Arc;

use eframe::egui::Context;

use super::job::Job;
use crate::app::setup::overlay::{Overlay, Role};
use crate::app::setup::setup::Setup;
use crate::fit::{
    Control, FitOptions, FitResult, Part, ProfilePoint, Progress, default_free, fit, profile_of,
};
use crate::model::Model;
use crate::recording::{Channel, Recording};

/// The fit panel's state.
#[derive(Debug, Clone, Default)]
pub struct Fitting {
    /// Whether its window is open.
    pub open: bool,
    /// Parameters ticked; `None` as by default.
    pub free: Option<BTreeSet<String>>,
    /// The fit in work.
    pub job: Option<Job<Progress, FitResult>>,
    /// Ids of the parameters that it moves, and the model it began with.
    pub moved: (Vec<String>, Option<Arc<Model>>),
    /// Parts that it is fitted to, and how.
    asked: Option<Arc<(Vec<Part>, FitOptions)>>,
    /// What came of the last.
    pub result: Option<Arc<FitResult>>,
    /// Why there is none.
    pub error: Option<String>,
    /// The profile of one parameter.
    pub profile: Profile,
    /// Whether the curves show the fit while it runs and until it is applied or dropped.
    pub shown: bool,
}

/// A profile likelihood on request.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    /// The parameter that is chosen.
    pub id: Option<String>,
    /// The profile in work, with its parameter.
    pub job: Option<(String, Job<Progress, Vec<ProfilePoint>>)>,
    /// The last one, with its parameter.
    pub result: Option<(String, Result<Vec<ProfilePoint>, String>)>,
}

/// Shifts of a profile in standard errors of the parameter.
const SHIFTS: [f64; 9] = [-3.0, -2.0, -1.2, -0.5, 0.0, 0.5, 1.2, 2.0, 3.0];

impl Profile {
    /// Ends the one in work and forgets the last: they are of a result that is no more.
    fn clear(&mut self) {
        if let Some((_, job)) = self.job.take() {
            job.cancel();
        }
        self.result = None;
    }
}

impl Fitting {
    /// Ids of the parameters to move: those ticked, less the locked.
    pub fn free(&self, setup: &Setup) -> Vec<String> {
        let model = &setup.preset.model;
        let ticked = |id: &String| match &self.free {
            Some(free) => free.contains(id),
            None => default_free(model).contains(id),
        };
        candidates(model)
            .into_iter()
            .filter(|id| ticked(id) && !setup.locked.contains(id))
            .collect()
    }

    /// What a recording is used for: fitted to, if nothing else was chosen.
    pub fn role(&self, overlay: &Overlay) -> Role {
        let usual = if overlay.visible {
            Role::Train
        } else {
            Role::Unused
        };
        overlay.role.unwrap_or(usual)
    }

    /// Starts a fit of the device as it is now.
    pub fn start(&mut self, setup: &Setup, context: &Context) {
        self.error = None;
        self.result = None;
        self.profile.clear();
        let model = setup.preset.model.clone();
        let options = FitOptions {
            free: self.free(setup),
            ..FitOptions::for_model(&model)
        };
        let of = |role: Role| -> Vec<Arc<Recording>> {
            let overlays = setup.overlays.iter();
            overlays
                .filter(|overlay| self.role(overlay) == role)
                .map(aligned)
                .collect()
        };
        let (train, held_out) = parts(of(Role::Train), of(Role::HeldOut));
        self.asked = Some(Arc::new((train.clone(), options.clone())));
        self.moved = (options.free.clone(), Some(Arc::new(model.clone())));
        self.shown = true;
        self.job = Some(Job::start("fit", context, move |desk| {
            let report = |progress: &Progress| desk.report(progress.clone());
            let control = Control {
                cancel: desk.cancel(),
                progress: &report,
            };
            fit(&model, &train, &held_out, &options, &control).map_err(|e| e.to_string())
        }));
    }

    /// Takes the result of a fit that has ended. Once a slider has moved since the fit
    /// began, the curves are the sliders' again.
    pub fn poll(&mut self, setup: &Setup) {
        let (_, start) = &self.moved;
        if start.as_deref() != Some(&setup.preset.model) {
            self.shown = false;
        }
        if let Some((id, job)) = &self.profile.job
            && let Some(points) = job.take()
        {
            self.profile.result = Some((id.clone(), points));
            self.profile.job = None;
        }
        let Some(result) = self.job.as_ref().and_then(Job::take) else {
            return;
        };
        self.job = None;
        match result {
            Ok(result) => self.result = Some(Arc::new(result)),
            Err(error) => {
                self.error = Some(error);
                self.shown = false;
            }
        }
    }

    /// The model whose curves are to be seen instead of the device's own, if any.
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

    /// Starts the profile of the chosen parameter around the last result, on what that was
    /// fitted to.
    pub fn start_profile(&mut self, context: &Context) {
        let (Some(result), Some(asked)) = (self.result.clone(), self.asked.clone()) else {
            return;
        };
        let Some(id) = self.profile.id.clone() else {
            return;
        };
        self.profile.result = None;
        let of = id.clone();
        let job = Job::start("profile", context, move |desk| {
            let (train, options) = &*asked;
            let report = |progress: &Progress| desk.report(progress.clone());
            let control = Control {
                cancel: desk.cancel(),
                progress: &report,
            };
            let points = profile_of(&result, train, &of, &SHIFTS, options, &control);
            points.map_err(|e| e.to_string())
        });
        self.profile.job = Some((id, job));
    }

    /// Forgets the result and its profile.
    pub fn forget(&mut self) {
        self.result = None;
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

    /// Gives the device the fitted values.
    pub fn apply(&mut self, setup: &mut Setup) {
        if let Some(result) = &self.result {
            for parameter in &result.parameters {
                // Ids of the device that was fitted; another device may lack one.
                let _ = setup.preset.model.set(&parameter.id, parameter.value);
            }
            self.shown = false;
        }
    }
}

/// Ids that can be fitted: of the device and of its effects.
pub fn candidates(model: &Model) -> Vec<String> {
    let own = model.parameters.iter().map(|(id, _)| id);
    let mut ids: Vec<String> = own
        .filter(|id| model.uses(*id) && is_physical(*id))
        .map(|id| id.spec().id.to_owned())
        .collect();
    ids.extend(model.effect_ids());
    ids
}

/// Whether a parameter is of the device, not of the run or the sensor: those are found
/// for each recording anyway.
fn is_physical(id: crate::model::parameter::ParameterId) -> bool {
    use crate::model::parameter::ParameterId as P;
    !matches!(id, P::X0 | P::V0 | P::OffsetP | P::OffsetC | P::Noise)
}

/// Recordings as parts; without any kept out, the last third of each.
pub(crate) fn parts(
    train: Vec<Arc<Recording>>,
    held_out: Vec<Arc<Recording>>,
) -> (Vec<Part>, Vec<Part>) {
    if held_out.is_empty() {
        train.into_iter().map(Part::split).unzip()
    } else {
        (
            train.into_iter().map(Part::whole).collect(),
            held_out.into_iter().map(Part::whole).collect(),
        )
    }
}

/// The recording as it is drawn: shifted and scaled.
pub(crate) fn aligned(overlay: &Overlay) -> Arc<Recording> {
    let alignment = &overlay.alignment;
    if *alignment == Default::default() {
        return Arc::clone(&overlay.recording);
    }
    let mut recording = overlay.recording.as_ref().clone();
    for t in &mut recording.time {
        *t = alignment.time(*t);
    }
    let scale = |values: &mut [f64], channel| {
        for x in values {
            *x = alignment.value(channel, *x);
        }
    };
    scale(&mut recording.proof_mass, Channel::ProofMass);
    if let Some(values) = &mut recording.cantilever {
        scale(values, Channel::Cantilever);
    }
    Arc::new(recording)
}

#[cfg(test)]
mod tests {
    use super::super::fit::*;
    use crate::app::files::built_in;

    #[test]
    fn what_is_fitted_is_what_is_ticked_and_not_locked() {
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
    fn a_profile_is_of_the_parameter_it_was_begun_for_and_goes_with_its_fit() {
        let setup = built_in::setup();
        let context = Context::default();
        let mut fitting = Fitting::default();
        let job = Job::start("profile", &context, |_| Ok(Vec::new()));
        fitting.profile.job = Some(("dp".to_owned(), job));
        // Another choice while it works.
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

    #[test]
    fn a_shift_and_a_scale_reach_the_fit() {
        let mut setup = built_in::setup();
        let overlay = &mut setup.overlays[0];
        assert!(Arc::ptr_eq(&aligned(overlay), &overlay.recording));
        overlay.alignment.time_shift = 1e-3;
        overlay.alignment.xp_offset = 2e-6;
        let moved = aligned(overlay);
        assert_eq!(moved.time[5], overlay.recording.time[5] + 1e-3);
        let apart = moved.proof_mass[5] - overlay.recording.proof_mass[5];
        assert!((apart - 2e-6).abs() < 1e-15);
    }
}
