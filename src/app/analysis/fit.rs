//! Running a fit, and its result. A fit changes nothing by itself: the person applies its
//! values.

use std::collections::BTreeSet;
use std::sync::Arc;

use eframe::egui::Context;

use super::job::Job;
use super::recording_roles::with_role;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::{Estimates, Overlay, Role};
use crate::app::setup::own_drive::OwnDrive;
use crate::app::simulation::recorded_drive::RecordedDriveCache;
use crate::fit::{
    Control, FitOptions, FitResult, Part, ProfilePoint, Progress, default_free, fit, profile_of,
};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::recording::align::Alignment;
use crate::recording::experiment_setup::DriveSource;
use crate::recording::{Channel, Recording};

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
    /// The parts of recordings used, and the options.
    asked: Option<Arc<(Vec<Part>, FitOptions)>>,
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
            None => default_free(model).contains(id),
        };
        candidates(model)
            .into_iter()
            .filter(|id| ticked(id) && !setup.locked.contains(id))
            .collect()
    }

    /// Starts a fit of the present device.
    pub fn start(&mut self, setup: &Setup, context: &Context) {
        self.error = None;
        self.result = None;
        self.profile.clear();
        let model = setup.preset.model.clone();
        let (train, held_out, options) = inputs(setup, self.free(setup));
        self.asked = Some(Arc::new((train.clone(), options.clone())));
        self.moved = (options.free.clone(), Some(Arc::new(model.clone())));
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
    pub fn start_profile(&mut self, context: &Context) {
        let (Some(result), Some(asked)) = (self.result.clone(), self.asked.clone()) else {
            return;
        };
        let Some(id) = self.profile.id.clone() else {
            return;
        };
        self.profile.result = None;
        let of = id.clone();
        let job = Job::start("profile", context, move |control| {
            let (train, options) = &*asked;
            let report = |progress: &Progress| control.report(progress.clone());
            let control = Control {
                cancel: control.cancel(),
                progress: &report,
            };
            let points = profile_of(&result, train, &of, &PROFILE_SHIFTS, options, &control);
            points.map_err(|e| e.to_string())
        });
        self.profile.job = Some((id, job));
    }

    /// Discards the result and its profile.
    pub fn discard(&mut self) {
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

/// The drive of the simulation, if it can be used.
pub(crate) fn shared_drive(setup: &Setup) -> Option<Waveform> {
    RecordedDriveCache::default().resolve(setup).ok()
}

/// The recordings of a role as the person has set them up.
pub(crate) fn recordings(setup: &Setup, role: Role) -> Vec<Arc<Recording>> {
    let shared = shared_drive(setup);
    with_role(setup, role)
        .map(|overlay| as_set_up(overlay, shared.as_ref()))
        .collect()
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

/// What a fit in the window is given: parts to fit, parts held out, and the options, for the
/// parameters `free`. The command line gives the same for the same recordings.
pub(crate) fn inputs(setup: &Setup, free: Vec<String>) -> (Vec<Part>, Vec<Part>, FitOptions) {
    let (train, held_out) = (recordings(setup, Role::Train), recordings(setup, Role::HeldOut));
    let (train, held_out) = Part::sides(train, held_out);
    let options = FitOptions {
        free,
        ..FitOptions::for_model(&setup.preset.model)
    };
    (train, held_out, options)
}

/// A recording as the person has set it up: its readings scaled and shifted, its drive, and what of
/// its instrument is unknown. `shared` is the drive of the simulation; without one, a recording under
/// it keeps its measured voltage.
pub(crate) fn as_set_up(overlay: &Overlay, shared: Option<&Waveform>) -> Arc<Recording> {
    let alignment = &overlay.alignment;
    let drive = source(overlay, shared);
    let is_as_read = *alignment == Alignment::default()
        && drive == DriveSource::default()
        && overlay.estimates == Estimates::default();
    if is_as_read {
        return Arc::clone(&overlay.recording);
    }
    let mut recording = overlay.recording.as_ref().clone();
    let scale = |values: &mut [f64], channel| {
        for x in values {
            *x = alignment.value(channel, *x);
        }
    };
    scale(&mut recording.proof_mass, Channel::ProofMass);
    if let Some(values) = &mut recording.cantilever {
        scale(values, Channel::Cantilever);
    }
    // A shift is that of the readings against the voltage. Without one it is that of all.
    let mut lag = 0.0;
    if let DriveSource::Waveform { waveform, start } = &drive {
        let volts = recording.time.iter().map(|t| waveform.voltage(t - start));
        recording.voltage = Some(volts.collect());
        lag = -alignment.time_shift;
    } else if recording.voltage.is_some() {
        lag = -alignment.time_shift;
    } else {
        for t in &mut recording.time {
            *t = alignment.time(*t);
        }
    }
    recording.drive_source = drive;
    recording.instrument = Some(overlay.estimates.unknowns(lag));
    Arc::new(recording)
}

/// What drives a recording.
fn source(overlay: &Overlay, shared: Option<&Waveform>) -> DriveSource {
    let (first, _) = overlay.recording.span();
    match &overlay.drive {
        OwnDrive::Measured(reading) => DriveSource::Measured(*reading),
        OwnDrive::Chosen(waveform) => DriveSource::Waveform {
            waveform: waveform.clone(),
            start: first,
        },
        // The simulation's t = 0 is that of the recording's times.
        OwnDrive::Shared => {
            shared.map_or_else(DriveSource::default, |waveform| DriveSource::Waveform {
                waveform: waveform.clone(),
                start: 0.0,
            })
        }
    }
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

    #[test]
    fn a_shift_and_a_scale_reach_the_fit() {
        let mut setup = built_in::setup();
        let overlay = &mut setup.overlays[0];
        assert!(Arc::ptr_eq(&as_set_up(overlay, None), &overlay.recording));
        overlay.alignment.time_shift = 1e-3;
        overlay.alignment.xp_offset = 2e-6;
        overlay.estimates.scales = true;
        let moved = as_set_up(overlay, None);
        // The shift is that of the readings against the voltage, which keeps its times.
        assert_eq!(moved.time[5], overlay.recording.time[5]);
        let unknown = moved.instrument.unwrap();
        assert_eq!((unknown.lag, unknown.zeros), (-1e-3, true));
        assert!(unknown.scale.is_some() && unknown.clock.is_some());
        let apart = moved.proof_mass[5] - overlay.recording.proof_mass[5];
        assert!((apart - 2e-6).abs() < 1e-15);
    }

    #[test]
    fn a_drive_chosen_for_a_recording_is_that_of_the_fit() {
        let mut setup = built_in::setup();
        let overlay = &mut setup.overlays[0];
        let waveform = Waveform::parse("square:15Hz:6V", 1.0).unwrap();
        overlay.drive = OwnDrive::Chosen(waveform.clone());
        let used = as_set_up(overlay, None);
        let drive = used.own_drive().unwrap().unwrap();
        assert_eq!(drive.text, waveform.to_string());
        assert_eq!(used.voltage.as_ref().unwrap()[0], 6.0);
        overlay.drive = OwnDrive::Shared;
        let shared = as_set_up(overlay, Some(&waveform));
        assert_eq!(
            shared.own_drive().unwrap().unwrap().text,
            waveform.to_string()
        );
    }
}
