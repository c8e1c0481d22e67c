//! All that the readings decide of an experiment: how it begins, and what its voltage leaves open.

use std::sync::Arc;

use super::drive_freedom::improve_drive;
use super::start_state::{FoundStart, estimate_start, improve_start};
use super::{Experiment, ExperimentError, ExperimentResult};
use crate::fit::thresholds::{
    DOUBTED_START_REMAINING_SHARE, FREE_START_REMAINING_SHARE, MAX_DOUBTED_START_REMAINDER,
    MAX_FREE_START_REMAINDER,
};
use crate::model::Model;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::measured_drive::MeasuredDrive;

/// Most rounds in which start and drive are decided in turn.
const MAX_ROUNDS: usize = 2;
/// Misfit \[noise\] after which they are decided again: less is the noise, and of more the device is the
/// cause.
const DECIDED_AGAIN: std::ops::Range<f64> = 1.05..30.0;

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
    let from_rest = Experiment {
        start: None,
        ..experiment.clone()
    };
    let mut now = Decision {
        drive: questions
            .drive
            .map_or_else(Vec::new, |(_, values)| values.to_vec()),
        experiment: from_rest.clone(),
        result: match from_rest.run(model, go_on)? {
            Some(result) => result,
            None => return Ok(None),
        },
    };
    for _ in 0..MAX_ROUNDS {
        if questions.start {
            now = match with_start(now, model, go_on)? {
                Some(next) => next,
                None => return Ok(None),
            };
        }
        if let Some((measured, _)) = questions.drive {
            let improved = improve_drive(&now.experiment, measured, model, &now.drive, go_on)?;
            let Some(improved) = improved else {
                return Ok(None);
            };
            now = Decision {
                drive: improved.values,
                experiment: improved.experiment,
                result: improved.result,
            };
        }
        // A start under a drive that was not known well, and the other way round.
        let left = now.result.misfit(&now.experiment).unwrap_or(f64::INFINITY);
        if !(questions.start && questions.drive.is_some() && DECIDED_AGAIN.contains(&left)) {
            break;
        }
    }
    Ok(Some(now))
}

/// The same from the start that the first readings suggest, if that counts.
fn with_start(
    now: Decision,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Decision>, ExperimentError> {
    let found = match &now.experiment.start {
        Some(start) => FoundStart {
            start: start.clone(),
            is_certain: true,
            remaining: 1.0,
        },
        // A recording whose start cannot be told is taken as one that begins like the device.
        None => match estimate_start(&now.experiment, model) {
            Ok(Some(found)) => found,
            _ => return Ok(Some(now)),
        },
    };
    let share = if found.is_certain {
        1.0
    } else if found.remaining < MAX_FREE_START_REMAINDER {
        FREE_START_REMAINING_SHARE
    } else if found.remaining < MAX_DOUBTED_START_REMAINDER {
        DOUBTED_START_REMAINING_SHARE
    } else {
        return Ok(Some(now));
    };
    let Some(improved) = improve_start(&now.experiment, &found.start, model, go_on)? else {
        return Ok(None);
    };
    let counts = improved.result.proof_mass.rms < share * now.result.proof_mass.rms;
    Ok(Some(if counts {
        Decision {
            drive: now.drive,
            experiment: improved.experiment,
            result: improved.result,
        }
    } else {
        now
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
