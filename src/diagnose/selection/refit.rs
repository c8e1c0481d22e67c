//! A fit with one more effect, judged against the one without on both sides.

use super::forward::{Stand, Trial};
use crate::diagnose::data::side::Side;
use crate::diagnose::hypotheses::propose::Hypothesis;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Bench;

/// A fit with one more effect against that of `stand`.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn judged(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    train: Fitted,
    control: &DiagnoseControl<'_>,
) -> Result<Trial, DiagnoseError> {
    let held_out = bench.judge(&train.model, (&train, stand.held_out.as_ref()), control)?;
    let mut gain = stand.train.cost - train.cost;
    let mut held_gain = match (&stand.held_out, &held_out) {
        (Some(before), Some(after)) => before.cost - after.cost,
        _ => 0.0,
    };
    // What begins after the fitted recordings is told by one that was kept out, which proves
    // nothing then.
    if let (Some(k), Some(before), Some(after)) = (hypothesis.told_by, &stand.held_out, &held_out) {
        let falls = before.costs()?.into_iter().zip(after.costs()?);
        let falls: Vec<f64> = falls.map(|(before, after)| before - after).collect();
        gain = falls[k];
        held_gain = falls.iter().sum::<f64>() - gain;
    }
    Ok(Trial {
        gain,
        held_gain,
        train,
        held_out,
        hypothesis: hypothesis.clone(),
    })
}

/// A fit with one more effect against that of `stand`, from which it did not begin.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn judged_anew(
    bench: &Bench,
    stand: &Stand,
    hypothesis: Hypothesis,
    train: Fitted,
    control: &DiagnoseControl<'_>,
) -> Result<Trial, DiagnoseError> {
    let held_out = bench.judge(&train.model, (&train, None), control)?;
    let (gain, held_gain) = whole_gains(bench, stand, &train, held_out.as_ref())?;
    Ok(Trial {
        gain,
        held_gain,
        train,
        held_out,
        hypothesis,
    })
}

/// Falls of chi2 against the fit of `stand` on either side, all stretches counted, whatever
/// either sets aside.
fn whole_gains(
    bench: &Bench,
    stand: &Stand,
    train: &Fitted,
    held_out: Option<&Fitted>,
) -> Result<(f64, f64), DiagnoseError> {
    let gain = |side: &Side, before: &Fitted, after: &Fitted| {
        let first = side.segments();
        Ok::<f64, DiagnoseError>(before.whole_cost(first)? - after.whole_cost(first)?)
    };
    let held_gain = match (&bench.held_out, &stand.held_out, held_out) {
        (Some(side), Some(before), Some(after)) => gain(side, before, after)?,
        _ => 0.0,
    };
    Ok((gain(&bench.train, &stand.train, train)?, held_gain))
}
