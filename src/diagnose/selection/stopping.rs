//! When the selection stops: a gain that errors in the form of named laws could explain.

use crate::diagnose::comparison::significance::is_insignificant;
use crate::diagnose::comparison::trial::{CandidateFit, ModelState};
use crate::diagnose::discrepancy::law_form;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::thresholds::{FORM_OUTWEIGHS_RATIO, HELD_GAIN};

/// Whether the gain of `trial` is within what the effects named before would bring if their laws
/// had a slightly different form.
pub(crate) fn is_form_error(
    state: &ModelState,
    trial: &CandidateFit,
) -> Result<bool, DiagnoseError> {
    let named = state.specs();
    if named.is_empty() {
        return Ok(false);
    }
    let (before, after) = (
        law_form::form_error_gain(&state.train, &named)?,
        law_form::form_error_gain(&trial.train, &named)?,
    );
    let own = 1.0 - (before - after).max(0.0) / trial.gain;
    log::debug!(
        "{}: other forms of the named laws bring {before:.0} without it and {after:.0} with it, of {:.0}",
        trial.hypothesis.start.spec.id,
        trial.gain
    );
    let (gain, held_gain) = (own * trial.gain, own * trial.held_gain);
    let held = trial.held_out.is_some() && held_gain < HELD_GAIN;
    let outweighed = before > FORM_OUTWEIGHS_RATIO * trial.gain;
    Ok(outweighed || is_insignificant(&trial.hypothesis, gain, held_gain) || held)
}
