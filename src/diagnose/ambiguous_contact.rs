//! The diagnosis, with a second reading of the recordings if contact is uncertain in some.
//!
//! A mass that comes to rest just above the ground looks as if it touched it. If nothing explains
//! the recordings and the mass may rest above the ground in some of them, these are read the other
//! way, unless the other recordings are far off by themselves.

use std::sync::atomic::AtomicBool;

use super::answer::conditions;
use super::data::reading_assumptions::ContactAmbiguity;
use super::diagnosis::{Diagnosis, Verdict};
use super::findings::Remark;
use super::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use super::pipeline::diagnose_as_read;
use super::thresholds::{CONTACT_DOUBT_MAX_CHI2, REREAD_MAX_MORE_ASIDE};
use crate::fit::Part;
use crate::fit::solve::budget::{Ending, within_budget};
use crate::model::Model;
use crate::model::effects::{CATALOGUE, find};
use crate::sim::SimError;

/// Share of the time that is allowed after which the search ends: with what was found the missing
/// force and the proof are still to be computed.
const SEARCH_TIME_SHARE: f64 = 0.8;

/// Diagnoses `train`, judged on `held_out`, against `model`, which is re-tuned first. If nothing
/// explains them and contact is uncertain in some, everything is done once more with the other
/// reading of these. Deterministic. If it is cancelled, the answer is what was found so far.
///
/// # Errors
/// [`DiagnoseError`] if a recording or the model cannot be used.
pub fn diagnose(
    model: &Model,
    train: &[Part],
    held_out: &[Part],
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    for id in options
        .candidates
        .iter()
        .chain(options.by_hand.iter().flatten())
    {
        if find(id).is_none() {
            let known: Vec<&str> = CATALOGUE.iter().map(|e| e.id).collect();
            return Err(DiagnoseError::UnknownEffect {
                id: id.clone(),
                known: known.join(", "),
            });
        }
    }
    model
        .check()
        .map_err(|e| DiagnoseError::Sim(SimError::from(e)))?;
    let options = DiagnoseOptions {
        choices: options.choices.of(model)?,
        ..options.clone()
    };
    let model = options.choices.start(model)?;
    let work = |stop: &AtomicBool| {
        let watched = DiagnoseControl {
            cancel: stop,
            progress: control.progress,
        };
        read_both_ways(&model, (train, held_out), &options, &watched)
    };
    let time = options.budget.map(|all| all.mul_f64(SEARCH_TIME_SHARE));
    let (answer, ending) = within_budget(time, control.cancel, work);
    let mut answer = answer?;
    let used_up = options.budget.filter(|_| ending == Ending::OutOfTime);
    conditions::mark_unfinished(&mut answer, used_up);
    Ok(answer)
}

/// [`diagnose`] without a limit on its time.
///
/// # Errors
/// Those of [`diagnose`].
fn read_both_ways(
    model: &Model,
    sides: (&[Part], &[Part]),
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    let (mut first, first_reading) = diagnose_as_read(
        model,
        sides,
        (options, &ContactAmbiguity::AsFitted),
        control,
    )?;
    log::debug!(
        "chi2 per value without the recordings in which the mass may hover: {:?}",
        first_reading.chi2_of_certain
    );
    // If the other recordings are far off as well, the reading of these is not the cause.
    let again = first_reading
        .chi2_of_certain
        .is_some_and(|chi2| chi2 < CONTACT_DOUBT_MAX_CHI2 || chi2.is_nan())
        && first.verdict == Verdict::Unexplained;
    if !again || options.by_hand.is_some() || control.cancelled() {
        return Ok(first);
    }
    log::debug!("second reading: {:?}", first_reading.alternative);
    let (mut other, other_reading) =
        match diagnose_as_read(model, sides, (options, &first_reading.alternative), control) {
            Ok(other) => other,
            // The first reading is an answer.
            Err(error) => {
                log::debug!("{error}");
                return Ok(first);
            }
        };
    // The second reading counts if it explains the recordings, and not by setting aside what speaks
    // against it. If only the level of the ground made contact uncertain, a missing effect may have
    // raised that level: then it counts only if nothing is missing.
    let explained = match other.verdict {
        Verdict::MissingPhysics | Verdict::PartlyExplained => {
            first_reading.alternative == ContactAmbiguity::Opposite
        }
        Verdict::Adequate => {
            other_reading.set_aside < first_reading.set_aside + REREAD_MAX_MORE_ASIDE
        }
        Verdict::Unexplained => false,
    };
    if explained && !other.cancelled {
        other.remarks.push(Remark::ContactAmbiguous);
        return Ok(other);
    }
    first.cancelled = other.cancelled;
    Ok(first)
}
