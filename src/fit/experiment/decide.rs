//! All that the readings decide of an experiment: how it begins, and what its voltage leaves open.

use std::sync::Arc;

use super::drive_freedom::improve_drive;
use super::start_state::{estimate_start, improve_start};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::fit::thresholds::{FREE_START_REMAINING_SHARE, MAX_FREE_START_REMAINDER};
use crate::model::Model;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::measured_drive::MeasuredDrive;

/// What is asked of the readings.
#[derive(Debug, Clone, Copy)]
pub struct Questions<'a> {
    /// The measured drive, where its freedoms are open, with their present values: as many as it
    /// has, or none for zeros.
    pub drive: Option<(&'a MeasuredDrive, &'a [f64])>,
    /// Whether the recording may begin otherwise than the device does.
    pub start: bool,
}

/// An experiment as the readings decided.
#[derive(Debug, Clone)]
pub struct Decision {
    /// Values of the measured drive's freedoms.
    pub drive: Vec<f64>,
    /// The experiment; its start is that found.
    pub experiment: Experiment,
    /// Its comparison.
    pub result: ExperimentResult,
}

/// Lets the readings decide. `None` if `go_on` said no.
///
/// # Errors
/// [`ExperimentError`] if the device cannot be simulated or nothing can be compared.
pub fn decide(
    experiment: &Experiment,
    questions: Questions<'_>,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Decision>, ExperimentError> {
    let mut experiment = Experiment {
        start: None,
        ..experiment.clone()
    };
    let mut result = None;
    if questions.start
        // A recording whose start cannot be told is taken as one that begins like the device.
        && let Ok(Some(found)) = estimate_start(&experiment, model)
        && (found.is_certain || found.remaining < MAX_FREE_START_REMAINDER)
    {
        let Some(improved) = improve_start(&experiment, &found.start, model, go_on)? else {
            return Ok(None);
        };
        let Some(usual) = experiment.run(model, go_on)? else {
            return Ok(None);
        };
        let share = if found.is_certain {
            1.0
        } else {
            FREE_START_REMAINING_SHARE
        };
        let counts = improved.result.proof_mass.rms < share * usual.proof_mass.rms;
        result = Some(usual);
        if counts {
            experiment = improved.experiment;
            result = Some(improved.result);
        }
    }
    let mut drive = Vec::new();
    if let Some((measured, values)) = questions.drive {
        let Some(improved) = improve_drive(&experiment, measured, model, values, go_on)? else {
            return Ok(None);
        };
        drive = improved.values;
        experiment = improved.experiment;
        result = Some(improved.result);
    }
    let result = match result {
        Some(result) => result,
        None => match experiment.run(model, go_on)? {
            Some(result) => result,
            None => return Ok(None),
        },
    };
    Ok(Some(Decision {
        drive,
        experiment,
        result,
    }))
}

/// A whole recording compared with its own run of `model`: under its own drive, from its own start,
/// with what belongs to its instrument estimated. `None` for a recording without a drive of its own
/// where the device needs one.
///
/// # Errors
/// [`ExperimentError`] if the device cannot be simulated or nothing can be compared.
///
/// # Examples
/// ```no_run
/// use std::sync::Arc;
///
/// use impactscope::fit::experiment::whole_run;
/// use impactscope::model::preset::Preset;
/// use impactscope::recording::csv::import_auto;
///
/// let model = Preset::default().model;
/// let recording = Arc::new(import_auto("recording.csv".as_ref(), None)?);
/// if let Some(run) = whole_run(&recording, &model)? {
///     println!("{:?} x noise", run.result.misfit(&run.experiment));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn whole_run(
    recording: &Arc<Recording>,
    model: &Model,
) -> Result<Option<Decision>, ExperimentError> {
    let measured = match recording.own_drive() {
        Some(drive) => Some(drive.map_err(crate::sim::SimError::from)?),
        None if model.piezo.is_some() => return Ok(None),
        None => None,
    };
    let (first, _) = recording.span();
    let drive = match &measured {
        Some(measured) => measured.waveform(&recording.name, -first),
        None => crate::model::drive::Waveform::Rest,
    };
    let mut experiment = Experiment::new(Arc::clone(recording), drive, Alignment::default());
    let reach = measured.as_ref().map_or(0.0, |m| m.reach());
    if let Some(priors) = &mut experiment.priors {
        if let Some(own) = recording.instrument {
            experiment.alignment.time_shift = -own.lag;
            priors.zeros = own.zeros;
            priors.scale = own.scale;
            priors.clock = own.clock;
        }
        priors.drive_reach = if priors.clock.is_some() { reach } else { 0.0 };
    }
    let open = measured.filter(|m| !m.freedoms.is_empty());
    let questions = Questions {
        drive: open.as_deref().map(|m| (m, &[][..])),
        start: true,
    };
    decide(&experiment, questions, model, &|| true)
}
