//! The guided identification: which steps the recordings at hand allow, and what is
//! missing for the others. It calls the steps' own functions, so that both agree.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::adhesion::adhesion;
use super::drive::{fit_drive, fit_drive_to};
use super::film::rings::rings_in;
use super::restitution::restitution;
use super::{StepError, model_distance};
use crate::fit::contact_readings::{ContactReadings, inspect, sample_contacts};
use crate::fit::contact_sample::Sampled;
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::modal::sweeps_clear_of_ground;
use crate::fit::options::{FitOptions, Part, default_free, whole_device};
use crate::fit::recipes::{BREAK_OFF, LOW_SWEEP, SLOW_CYCLES, SLOW_PULLS, TAPS};
use crate::fit::solve::levenberg_marquardt::Control;
use crate::fit::thresholds::MAX_DEVICE_NOISE_RATIO;
use crate::model::Model;
use crate::recording::Recording;
use crate::static_text::{self, StaticText};

/// A step of the paper's identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Step {
    /// The modes of the structure (section 3.1).
    Modal,
    /// The branches of the drive.
    Drive,
    /// The coefficient of restitution.
    Restitution,
    /// The adhesion law.
    Adhesion,
    /// The gas film.
    Film,
    /// The sensitivity to the contact distance.
    Sensitivity,
}

impl Step {
    /// All, in the paper's order.
    pub const ALL: [Step; 6] = [
        Step::Modal,
        Step::Drive,
        Step::Restitution,
        Step::Adhesion,
        Step::Film,
        Step::Sensitivity,
    ];

    /// As typed on the command line.
    pub fn id(self) -> &'static str {
        match self {
            Step::Modal => "modal",
            Step::Drive => "drive",
            Step::Restitution => "restitution",
            Step::Adhesion => "adhesion",
            Step::Film => "film",
            Step::Sensitivity => "sensitivity",
        }
    }

    /// The step of that id.
    pub fn find(id: &str) -> Option<Self> {
        Step::ALL.into_iter().find(|step| step.id() == id)
    }

    /// What it finds.
    pub fn title(self) -> &'static str {
        match self {
            Step::Modal => "modal: frequencies, damping ratios and mode shapes",
            Step::Drive => "drive: the two branches of gc(V)",
            Step::Restitution => "restitution: alpha",
            Step::Adhesion => "adhesion: Ca and Ca0",
            Step::Film => "film: Cs and gp",
            Step::Sensitivity => "sensitivity: all again with dp shifted by 20 um",
        }
    }

    /// Whether it finds values that a device can be given; the sensitivity only compares.
    pub fn finds_values(self) -> bool {
        self != Step::Sensitivity
    }

    /// The recording that it needs.
    pub fn recipe(self) -> &'static str {
        match self {
            Step::Modal => LOW_SWEEP,
            Step::Drive => SLOW_CYCLES,
            Step::Restitution => TAPS,
            Step::Adhesion => SLOW_PULLS,
            Step::Film => BREAK_OFF,
            Step::Sensitivity => "what restitution, adhesion and film need together",
        }
    }
}

/// Whether a step can be taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Allowance {
    /// The step.
    pub step: Step,
    /// Names of the recordings that allow it; or what is missing.
    pub by: Result<Vec<String>, Missing>,
}

/// What a step lacks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Missing {
    /// Why it cannot be taken.
    pub reason: String,
    /// What to record so that it can; `None` where no recording helps, as the device lacks
    /// what the step is about, or the reason already says what to do.
    #[serde(deserialize_with = "static_text::optional")]
    pub record: Option<StaticText>,
    /// Whether bounces or releases were seen that the device, as it is, does not follow: a fit of
    /// the whole device may allow the step with the same recordings.
    pub may_be_the_device: bool,
}

/// What the recordings allow.
#[derive(Debug, Clone)]
pub struct Guidance {
    /// Every step, in the paper's order.
    pub allowances: Vec<Allowance>,
    /// How far the device is from the recordings, if that is too far for what happens at the ground
    /// to be read. Then it must be fitted before any step: see [`next_to_free`].
    pub first: Option<String>,
    /// Bounces and releases as the steps read them, so that these need not again; `None`
    /// where they cannot be read, or were not all read.
    pub readings: Option<ContactReadings>,
    /// In how many segments of long recordings they were read; `None` if in all.
    pub sampled: Option<Sampled>,
}

/// What to free in a fit of the whole device before the steps: what is usually tuned, and where a
/// fit of that (`fitted` are the ids that the device's values come from) did not bring it near
/// enough, its frequencies and shape too. `None` if all that has been fitted: then the device lacks
/// something that the recordings show.
///
/// # Examples
/// ```
/// use impactscope::fit::paper_steps::guide::next_to_free;
/// use impactscope::fit::{default_free, whole_device};
/// use impactscope::model::preset::Preset;
///
/// let paper = Preset::default().model;
/// let first = next_to_free(&paper, &[]);
/// assert_eq!(first, Some(default_free(&paper)));
/// let second = next_to_free(&paper, &default_free(&paper));
/// assert_eq!(second, Some(whole_device(&paper)));
/// assert_eq!(next_to_free(&paper, &whole_device(&paper)), None);
/// ```
#[must_use]
pub fn next_to_free(model: &Model, fitted: &[String]) -> Option<Vec<String>> {
    let mut stages = [default_free(model), whole_device(model)].into_iter();
    stages.find(|ids| ids.iter().any(|id| !fitted.contains(id)))
}

/// Checks what each step needs: bounces and releases are read with `model` unchanged, rings are
/// searched for, and the drive is fitted. Of very many segments an even pick is read. Only the fits
/// of the film and of the sensitivity remain to be done after that.
pub fn guide(
    model: &Model,
    recordings: &[Arc<Recording>],
    options: &FitOptions,
    control: &Control<'_>,
) -> Guidance {
    let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
    let named = |indices: Vec<usize>| -> Vec<String> {
        let all = (0..recordings.len()).filter(|i| indices.contains(i));
        all.map(|i| recordings[i].name.clone()).collect()
    };
    let everything = || named((0..recordings.len()).collect());
    // Each looks at all samples; together they take as long as the longest.
    let (drive, (is_readable, read, film)) = rayon::join(
        || fit_drive_to(model, recordings, |_| Ok(())),
        || {
            let (summaries, readable) = inspect(model, &parts, options);
            let is_readable = readable.is_ok();
            let inspected = || (summaries.clone(), readable.clone());
            let (read, film) = rayon::join(
                || read(model, &parts, options, control, inspected),
                || rings_in(model, &parts, options, inspected).map(|r| r.recordings()),
            );
            (is_readable, read, film)
        },
    );
    // What is readable together is so alone; else the drive says which is not.
    let drive = match is_readable {
        true => drive,
        false => fit_drive(model, recordings),
    }
    .map(|_| everything());
    let sampled = read.as_ref().ok().and_then(|(_, sampled)| *sampled);
    let read = read.map(|(readings, _)| readings);
    let restitution = read.as_ref().map_err(Clone::clone).and_then(|readings| {
        let found = restitution("", readings)?;
        Ok(named(found.bounces.iter().map(|b| b.recording).collect()))
    });
    let adhesion = read.as_ref().map_err(Clone::clone).and_then(|readings| {
        let found = adhesion("", readings)?;
        Ok(named(found.releases.iter().map(|r| r.recording).collect()))
    });
    let off = read
        .as_ref()
        .map(|readings| readings.off)
        .unwrap_or_default();
    let (bounces_unread, releases_unread) = read
        .as_ref()
        .map_or((false, false), |r| (r.unread > 0, r.unread_releases > 0));
    let first = far_from_data(off.eventless).or_else(|| model_distance(off.read));
    let missing: Vec<&str> = [
        (Step::Restitution, restitution.is_err()),
        (Step::Adhesion, adhesion.is_err()),
        (Step::Film, film.is_err()),
    ]
    .into_iter()
    .filter(|(_, fails)| *fails)
    .map(|(step, _)| step.id())
    .collect();
    let sensitivity = if missing.is_empty() {
        Ok(everything())
    } else {
        let lacks_ground = matches!(read, Err(StepError::Device { .. }));
        Err(Missing {
            reason: format!("these steps come first: {}", missing.join(", ")),
            record: (!lacks_ground).then(|| Step::Sensitivity.recipe()),
            may_be_the_device: bounces_unread || releases_unread,
        })
    };
    let asked = |step: Step, by: Result<Vec<String>, StepError>| {
        allowance(step, by, (bounces_unread, releases_unread))
    };
    Guidance {
        allowances: vec![
            asked(Step::Modal, sweeps(model, recordings)),
            asked(Step::Drive, drive),
            asked(Step::Restitution, restitution),
            asked(Step::Adhesion, adhesion),
            asked(Step::Film, film),
            Allowance {
                step: Step::Sensitivity,
                by: sensitivity,
            },
        ],
        first,
        readings: read.ok().filter(|_| sampled.is_none()),
        sampled,
    }
}

/// The recordings that tell modes.
fn sweeps(model: &Model, recordings: &[Arc<Recording>]) -> Result<Vec<String>, StepError> {
    if recordings.is_empty() {
        return Err(FitError::NoRecording.into());
    }
    if model.piezo.is_none() {
        return Err(StepError::Device {
            device: model.name.clone(),
            what: "drive",
            step: "the modes that it excites",
        });
    }
    let found = sweeps_clear_of_ground(model, recordings);
    if found.is_empty() {
        return Err(StepError::Unsuited {
            recording: String::new(),
            reason: "none is a swept sine in which the mass stays clear of the ground".to_owned(),
            remedy: LOW_SWEEP,
        });
    }
    Ok(found)
}

/// What a step may use, or what is missing; `unread` says whether bounces and releases were seen that
/// the device does not follow.
fn allowance(
    step: Step,
    by: Result<Vec<String>, StepError>,
    (bounces_unread, releases_unread): (bool, bool),
) -> Allowance {
    let by = by.map_err(|error| {
        let (reason, record) = match error {
            StepError::Unsuited { reason, .. } => (reason, Some(step.recipe())),
            StepError::Fit(FitError::NoRecording) => {
                ("there is no recording".to_owned(), Some(step.recipe()))
            }
            other => (other.to_string(), None),
        };
        Missing {
            reason,
            record,
            may_be_the_device: match step {
                Step::Restitution => bounces_unread,
                Step::Adhesion => releases_unread,
                Step::Modal | Step::Drive | Step::Film | Step::Sensitivity => false,
            },
        }
    });
    Allowance { step, by }
}

/// That the model is `off` by too many times the noise where the mass hardly
/// touches the ground, if it is.
fn far_from_data(off: f64) -> Option<String> {
    (off > MAX_DEVICE_NOISE_RATIO).then(|| {
        let how = if off.is_finite() {
            format!("is off from these recordings by {off:.0} times the noise,")
        } else {
            "cannot follow these recordings,".to_owned()
        };
        format!("The device {how} even where the mass hardly touches the ground.")
    })
}

/// Bounces and releases, if there is a ground to meet.
fn read(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
    inspected: impl FnOnce() -> (Vec<RecordingSummary>, Result<(), FitError>),
) -> Result<(ContactReadings, Option<Sampled>), StepError> {
    if !model.has_ground {
        return Err(StepError::Device {
            device: model.name.clone(),
            what: "ground",
            step: "what happens there",
        });
    }
    if parts.is_empty() {
        return Err(FitError::NoRecording.into());
    }
    let (summaries, readable) = inspected();
    readable?;
    Ok(sample_contacts(
        model,
        (parts, &summaries),
        options,
        control,
    )?)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::super::guide::*;
    use super::super::tests::{made, recording};
    use crate::model::parameter::ParameterId;
    use crate::model::preset::Preset;

    fn look(recordings: &[Arc<Recording>]) -> Guidance {
        let model = Preset::default().model;
        let cancel = AtomicBool::new(false);
        let control = Control {
            cancel: &cancel,
            progress: &|_| {},
        };
        let options = FitOptions::for_model(&model);
        guide(&model, recordings, &options, &control)
    }

    fn allowed(recordings: &[Arc<Recording>]) -> Vec<&'static str> {
        let allowances = look(recordings).allowances.into_iter();
        allowances
            .filter(|allowance| allowance.by.is_ok())
            .map(|allowance| allowance.step.id())
            .collect()
    }

    #[test]
    fn each_recording_allows_its_step_and_missing_ones_are_named() {
        let taps = recording("square:300Hz:6V", 0.05);
        let ramps = [0.1, 0.2, 0.3].map(|l| recording(&format!("ramped:5Hz:8V:{l}"), 0.4));
        let cycles = [6, 8].map(|v| recording(&format!("sine:5Hz:{v}V"), 0.4));
        assert_eq!(allowed(std::slice::from_ref(&taps)), ["restitution"]);
        assert_eq!(allowed(&ramps), ["adhesion", "film"]);
        let mut all = vec![taps];
        all.extend(ramps);
        all.extend(cycles);
        // At any voltage this device jumps from branch to branch and meets the ground: no sweep of it
        // tells modes.
        let others = Step::ALL.iter().filter(|step| **step != Step::Modal);
        let ids: Vec<&str> = others.map(|step| step.id()).collect();
        assert_eq!(allowed(&all), ids);
        for allowance in look(&[]).allowances {
            assert!(allowance.by.is_err(), "{allowance:?}");
        }
    }

    #[test]
    fn of_a_long_recording_an_even_pick_is_read_and_said() {
        let long = look(&[made("square:15Hz:8V", 6.0, 50e3, 20e-9, &[])]);
        let sampled = long.sampled.expect("a pick");
        assert!(sampled.all > 1000 && sampled.picked <= 60, "{sampled:?}");
        assert!(sampled.to_string().contains("Each step reads all"));
        // The steps do not take the pick for all there is.
        assert!(long.readings.is_none());
        let short = look(&[made("square:15Hz:8V", 0.6, 50e3, 20e-9, &[])]);
        assert_eq!(short.sampled, None);
        assert!(short.readings.is_some());
        let film_and_bounces = [Step::Restitution, Step::Film];
        for (a, b) in long.allowances.iter().zip(&short.allowances) {
            if film_and_bounces.contains(&a.step) {
                assert!(a.by.is_ok() && b.by.is_ok(), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_device_far_from_the_recordings_must_be_fitted_first() {
        let drives = [("square:300Hz:6V", 0.05), ("ramped:5Hz:8V:0.2", 0.4)];
        let right = drives.map(|(drive, span)| recording(drive, span));
        assert_eq!(look(&right).first, None);
        let other = [(ParameterId::Eta, 4.2e-7), (ParameterId::Zeta1, 0.04)];
        let far = drives.map(|(drive, span)| made(drive, span, 50e3, 20e-9, &other));
        let guidance = look(&far);
        println!("{:?}", guidance.first);
        let first = guidance.first.expect("it is far off");
        assert!(first.contains("times the noise") && !first.contains("Fit the whole"));
        let unfollowed = guidance
            .allowances
            .iter()
            .find(|a| a.step == Step::Restitution);
        let missing = unfollowed.and_then(|a| a.by.as_ref().err());
        assert!(missing.is_none_or(|m| m.may_be_the_device), "{missing:?}");
    }

    #[test]
    fn an_allowed_step_has_enough_events() {
        // Impacts are seen here whose ratio the noise hides.
        for (drive, noise) in [
            ("square:15Hz:8V", 20e-9),
            ("square:50Hz:6V", 200e-9),
            ("sine:50Hz:8V", 20e-9),
        ] {
            let found = look(&[made(drive, 0.06, 50e3, noise, &[])]);
            let readings = found.readings.unwrap();
            for allowance in &found.allowances {
                let taken = match allowance.step {
                    Step::Restitution => restitution("", &readings).map(|_| ()),
                    Step::Adhesion => adhesion("", &readings).map(|_| ()),
                    _ => continue,
                };
                println!("{drive} {allowance:?}");
                assert_eq!(taken.is_ok(), allowance.by.is_ok(), "{taken:?}");
            }
        }
    }

    #[test]
    fn a_device_without_ground_and_drive_needs_no_recording() {
        let model = Preset::load("oscillator").unwrap().model;
        let cancel = AtomicBool::new(false);
        let control = Control {
            cancel: &cancel,
            progress: &|_| {},
        };
        let options = FitOptions::for_model(&model);
        let swing = recording("sine:5Hz:8V", 0.1);
        for allowance in guide(&model, &[swing], &options, &control).allowances {
            let missing = allowance.by.unwrap_err();
            assert_eq!(missing.record, None, "{missing:?}");
        }
        for allowance in look(&[]).allowances {
            let missing = allowance.by.unwrap_err();
            assert_eq!(missing.record, Some(allowance.step.recipe()), "{missing:?}");
        }
    }

    #[test]
    fn a_saturated_recording_is_reported() {
        let mut clipped = recording("square:300Hz:6V", 0.05).as_ref().clone();
        let top = clipped.proof_mass.iter().copied().fold(f64::MIN, f64::max);
        for x in &mut clipped.proof_mass {
            *x = x.min(0.3 * top);
        }
        for allowance in look(&[Arc::new(clipped)]).allowances {
            let missing = allowance.by.unwrap_err();
            let rest = matches!(allowance.step, Step::Sensitivity | Step::Modal);
            assert!(rest || missing.reason.contains("saturated"), "{missing:?}");
        }
    }

    #[test]
    fn counts_of_one_are_singular() {
        let one = look(&[recording("square:15Hz:8V", 0.0365)]);
        let texts: Vec<String> = one
            .allowances
            .into_iter()
            .filter_map(|a| a.by.err())
            .map(|missing| missing.reason)
            .collect();
        println!("{texts:?}");
        assert!(
            !texts
                .iter()
                .any(|t| t.contains("1 bounces") || t.contains("1 releases"))
        );
    }
}
