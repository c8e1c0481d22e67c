//! A diagnosis; where nothing explains the recordings and the mass may hover in some, with those
//! read the other way as well, unless the others are far off by themselves.

use super::data::reading_assumptions::ContactAmbiguity;
use super::diagnosis::{Diagnosis, Verdict};
use super::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use super::pipeline::read;
use super::thresholds::{CONTACT_DOUBT_MAX_CHI2, REREAD_MAX_MORE_ASIDE};
use crate::fit::Part;
use crate::model::Model;
use crate::model::effects::{CATALOGUE, find};
use crate::sim::SimError;

/// Diagnoses `train`, judged on `held_out`, against `model`, which is re-tuned first. Where nothing
/// explains them and the mass may hover over the ground in some, all is done once more with those
/// read the other way, unless the others are far off by themselves; where only the level of the
/// ground makes it doubtful, that counts if nothing is missing then. Deterministic. Cancelled, it
/// says what it has found so far.
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
    let sides = (train, held_out);
    let (mut first, told) = read(
        model,
        sides,
        (options, &ContactAmbiguity::AsFitted),
        control,
    )?;
    log::debug!(
        "chi2 per value beside those in which the mass may hover: {:?}",
        told.beside_doubted
    );
    // What leaves the others far off as well is no matter of how these are read.
    let again = told
        .beside_doubted
        .is_some_and(|beside| beside < CONTACT_DOUBT_MAX_CHI2 || beside.is_nan())
        && first.verdict == Verdict::Unexplained;
    if !again || options.by_hand.is_some() || control.cancelled() {
        return Ok(first);
    }
    log::debug!(
        "whether the mass hovers is read otherwise: {:?}",
        told.otherwise
    );
    let (mut other, otherwise) = match read(model, sides, (options, &told.otherwise), control) {
        Ok(other) => other,
        // The first reading is an answer.
        Err(error) => {
            log::debug!("{error}");
            return Ok(first);
        }
    };
    // Nothing else tells the two ways apart than that one of them is explained, and not by setting
    // aside what speaks against it. A ground that is a little higher in one recording may be so for
    // what is missing: it hovers there only if nothing else is.
    let explained = match other.verdict {
        Verdict::MissingPhysics => told.otherwise == ContactAmbiguity::Opposite,
        Verdict::Adequate => otherwise.aside < told.aside + REREAD_MAX_MORE_ASIDE,
        Verdict::Unexplained => false,
    };
    if explained && !other.cancelled {
        other.remarks.push("whether the mass hovers over the ground in some recording is in doubt: it was decided the way in which all is explained".to_owned());
        return Ok(other);
    }
    first.cancelled = other.cancelled;
    Ok(first)
}
