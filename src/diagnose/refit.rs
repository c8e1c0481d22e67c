//! Hypotheses fitted once more: with the shape of their law, or from where another has come to.

use super::bench::Bench;
use super::explain::{Stand, Trial};
use super::options::{DiagnoseControl, DiagnoseError};
use super::promises::Hypothesis;
use super::weigh::{begun_from, from_near, whole_gains};

/// Fall of chi2 on both sides from which a law has shown up.
const SHOWS: f64 = 40.0;
/// Fall of chi2 from which another shape of a law is better by more than chance.
const SHAPED: f64 = 25.0;
/// Falls on either side and on both from which another shape is better where the recordings
/// kept out confirm it.
const SHAPED_BY_BOTH: (f64, f64) = (5.0, 30.0);

/// `trial` with its law given the shape that suits best, if that brings more than chance on
/// both sides. A shape of one number stays free in later fits; one of more is kept as it is,
/// for they would take too long.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn shaped(
    bench: &Bench,
    stand: &Stand,
    trial: Trial,
    control: &DiagnoseControl<'_>,
) -> Result<Trial, DiagnoseError> {
    let hypothesis = &trial.hypothesis;
    let effects = &trial.train.model.effects;
    let effect = effects.iter().find(|e| e.spec == hypothesis.start.spec);
    let known = trial.worth() > SHOWS && !hypothesis.shape.is_empty();
    let (Some(effect), true) = (effect, known && !control.cancelled()) else {
        return Ok(trial);
    };
    let mut free = hypothesis.free.clone();
    free.extend_from_slice(&hypothesis.shape);
    let whole = Hypothesis {
        start: effect.clone(),
        free,
        ..hypothesis.clone()
    };
    let Some(mut other) = from_near(bench, stand, &whole, control)? else {
        return Ok(trial);
    };
    log::debug!(
        "with its shape {:.0}, {:.0} kept out in place of {:.0}, {:.0}",
        other.gain,
        other.held_gain,
        trial.gain,
        trial.held_gain
    );
    if hypothesis.shape.len() > 1 {
        other.hypothesis.free.clone_from(&hypothesis.free);
    }
    let (more, held_more) = (other.gain - trial.gain, other.held_gain - trial.held_gain);
    let (own, both) = SHAPED_BY_BOTH;
    let confirmed = more.min(held_more) > own && more + held_more > both;
    let told = more > SHAPED && (stand.held_out.is_none() || held_more > 0.0);
    Ok(if told || confirmed { other } else { trial })
}

/// `trial` fitted once more from where the fit with another effect in its place has come to,
/// whichever suits better: a fit may stop halfway.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn from_other(
    bench: &Bench,
    stand: &Stand,
    trial: &Trial,
    other: &Trial,
    control: &DiagnoseControl<'_>,
) -> Result<Trial, DiagnoseError> {
    let of = |t: &Trial| t.hypothesis.start.spec;
    let mut start = other.train.model.clone();
    start.effects.retain(|e| e.spec != of(other));
    let own = trial.train.model.effects.iter();
    start
        .effects
        .extend(own.filter(|e| e.spec == of(trial)).cloned());
    let begun = (&start, &other.train);
    let Some(mut again) = begun_from(bench, stand, &trial.hypothesis, begun, control)? else {
        return Ok(trial.clone());
    };
    let mut trial = trial.clone();
    // What one of them sets aside must not count for it.
    let differs = |t: &Trial| t.train.point.used != stand.train.point.used;
    if differs(&again) || differs(&trial) {
        for t in [&mut again, &mut trial] {
            let (train, held_out) = (&t.train, t.held_out.as_ref());
            (t.gain, t.held_gain) = whole_gains(bench, stand, train, held_out)?;
        }
    }
    log::debug!(
        "{} from where {} has come to: {:.0} in place of {:.0}",
        of(&trial).id,
        of(other).id,
        again.worth(),
        trial.worth()
    );
    Ok(if again.worth() > trial.worth() {
        again
    } else {
        trial
    })
}
