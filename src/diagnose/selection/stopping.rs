//! When the selection stops: a gain that errors in the form of named laws could explain, or
//! residuals so large that no further effects could suffice.

use crate::diagnose::comparison::significance::is_insignificant;
use crate::diagnose::comparison::trial::{CandidateFit, ModelState};
use crate::diagnose::discrepancy::law_form;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::excess_chi2;
use crate::diagnose::thresholds::{
    FAR_OFF_CHI2, FORM_OUTWEIGHS_RATIO, HELD_GAIN, MIN_CARRIED_SHARE,
};

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

/// Whether the named effects leave the fitted recordings so far off that `more` effects, each as
/// good as the best of them, would not explain what is missing, nor would form errors of their
/// laws.
///
/// # Errors
/// [`DiagnoseError`] if the model makes no sense.
pub fn cannot_reach_target(state: &ModelState, more: usize) -> Result<bool, DiagnoseError> {
    let gains: Vec<f64> = state.named.iter().map(|n| n.gain.0).collect();
    let rest = excess_chi2(&state.train);
    let far = !state.misread && state.train.per_value() > FAR_OFF_CHI2;
    if !far || !falls_short(&gains, more, rest, 0.0) {
        return Ok(false);
    }
    let formal = law_form::form_error_gain(&state.train, &state.specs())?;
    log::debug!(
        "the named effects carry {gains:.0?}, other forms of their laws {formal:.0}, and leave {rest:.0}"
    );
    Ok(falls_short(&gains, more, rest, formal))
}

/// Whether effects with these `gains`, and `more` like the best of them, explain too little where
/// `rest` remains, of which `formal` is explained by form errors.
pub(crate) fn falls_short(gains: &[f64], more: usize, rest: f64, formal: f64) -> bool {
    let best = gains.iter().copied().fold(0.0, f64::max);
    let carried: f64 = gains.iter().sum();
    let most = carried + more as f64 * best + formal;
    best > 0.0 && most < MIN_CARRIED_SHARE * (carried + rest)
}
