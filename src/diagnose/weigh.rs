//! Hypotheses weighed: each of those that promise most is fitted, from the fit there is or,
//! where that has lost its way, from where the re-tuning began, and judged on the recordings
//! kept out.

use super::bench::{Bench, Bound, Fitted, Side, Sketch, with_effect};
use super::explain::{Stand, Trial, Weighed};
use super::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use super::promises::{FOUND, Hypothesis, PROMISING, promises};
use crate::model::Model;
use crate::model::effects::EffectSpec;

/// Share of the best refit below which a promise is far behind.
const FAR: f64 = 0.3;
/// Most hypotheses refitted in a round.
const MOST: usize = 4;
/// Steps of a fit at most.
const ITERATIONS: usize = 12;
/// Fall of chi2 on both sides from which a law has shown up.
const SHOWS: f64 = 40.0;
/// Fall of chi2 from which another shape of a law is better by more than chance.
const SHAPED: f64 = 25.0;
/// Falls on either side and on both from which it is where those kept out confirm it.
const CONFIRMED: (f64, f64) = (5.0, 30.0);
/// Chi2 per value from which a fit has lost its way: what is missing has drawn all else
/// along.
const LOST: f64 = 4.0;

/// Weighs all hypotheses that `stand` does not have yet, or `only` one effect whatever it
/// promises.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn weigh(
    bench: &Bench,
    stand: &Stand,
    options: &DiagnoseOptions,
    only: Option<&str>,
    control: &DiagnoseControl<'_>,
    about: &dyn Fn(&str, f64),
) -> Result<Vec<Weighed>, DiagnoseError> {
    about("scan of the catalogue", 0.0);
    let mut hypotheses = promises(bench, stand)?;
    let wanted = |id: &str| match only {
        Some(only) => only == id,
        None => options.candidates.is_empty() || options.candidates.iter().any(|c| c == id),
    };
    let has = |spec: &EffectSpec| stand.named.iter().any(|n| n.spec == spec);
    hypotheses.retain(|h| wanted(h.start.spec.id) && !has(h.start.spec));
    hypotheses.sort_by(|a, b| b.promise.total_cmp(&a.promise));
    for h in &hypotheses {
        let start = &h.start;
        log::debug!(
            "{} promises {:.1} at {:?}",
            start.spec.id,
            h.promise,
            start.values
        );
    }
    let mut out: Vec<Weighed> = Vec::new();
    let mut best = 0.0f64;
    let count = hypotheses.len().clamp(1, MOST);
    for hypothesis in hypotheses {
        let same = |w: &Weighed| w.spec == hypothesis.start.spec;
        let known = out.iter().position(same);
        let k = known.unwrap_or(out.len());
        // Where the promise is far below what a refit has reached, a refit is in vain:
        // promises are right where the baseline is near the data.
        let least = if hypothesis.searched {
            FOUND
        } else {
            PROMISING
        };
        let worth = hypothesis.promise > least && hypothesis.promise > FAR * best;
        let worth = worth || only.is_some();
        let mut trial = None;
        if k < MOST && worth && !control.cancelled() {
            about(
                hypothesis.start.spec.name,
                (k + 1) as f64 / (count + 1) as f64,
            );
            // From afar takes as long as the re-tuning did: only for what promises most.
            let afar = k == 0 && stand.named.is_empty();
            trial = attempt(bench, stand, &hypothesis, afar, control)?;
            best = trial.as_ref().map_or(best, |t| best.max(t.gain));
        }
        let own = Weighed {
            spec: hypothesis.start.spec,
            promise: hypothesis.promise,
            trial,
        };
        let worth = |w: &Weighed| w.trial.as_ref().map_or(f64::NEG_INFINITY, Trial::worth);
        match known {
            Some(known) if worth(&out[known]) >= worth(&own) => {}
            Some(known) => out[known] = own,
            None => out.push(own),
        }
    }
    Ok(out)
}

/// A fit with one more effect, or `None` if it cannot be simulated; also from `afar` if the
/// fit there is has lost its way.
fn attempt(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    afar: bool,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let lost = |f: &Fitted| f.per_value() > LOST;
    // A further mode begins with what a fit has left to it.
    let further = hypothesis.start.spec.id == "extra_mode";
    let astray = afar && !stand.misread && !further && lost(&stand.train);
    if astray
        && hypothesis.full.is_some()
        && let Some(trial) = from_afar(bench, stand, hypothesis, control)?
        && trial.worth() > 0.0
    {
        return Ok(Some(trial));
    }
    let series = hypothesis.series.then(|| bench.in_series());
    let nearby = series.as_ref().unwrap_or(bench);
    let near = if further {
        likeliest(nearby, stand, hypothesis, control)?
    } else {
        from_near(nearby, stand, hypothesis, control)?
    };
    let Some(mut near) = near else {
        return Ok(None);
    };
    for other in others(hypothesis).filter(|_| !further) {
        if let Some(trial) = from_near(nearby, stand, &other, control)?
            && trial.worth() > near.worth()
        {
            near = trial;
        }
    }
    if astray
        && hypothesis.full.is_none()
        && lost(&near.train)
        && let Some(other) = from_afar(bench, stand, hypothesis, control)?
    {
        log::debug!(
            "from afar {:.0} in place of {:.0}",
            other.worth(),
            near.worth()
        );
        if other.worth() > near.worth() {
            return Ok(Some(other));
        }
    }
    Ok(Some(near))
}

/// `trial` with its law given the shape that suits best, if that brings more than chance on
/// both sides. Later fits keep that shape: of more than one number they would take too long
/// to ask for it again.
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
    let (own, both) = CONFIRMED;
    let confirmed = more.min(held_more) > own && more + held_more > both;
    let told = more > SHAPED && (stand.held_out.is_none() || held_more > 0.0);
    Ok(if told || confirmed { other } else { trial })
}

/// The hypotheses that look like `hypothesis`.
fn others(hypothesis: &Hypothesis) -> impl Iterator<Item = Hypothesis> + '_ {
    hypothesis.others.iter().map(|(start, bounds)| Hypothesis {
        start: start.clone(),
        bounds: bounds.clone(),
        ..hypothesis.clone()
    })
}

/// A fit with that of a hypothesis and those which look like it that suits a part of the fitted
/// recordings best: of a further mode, whose fits take long. `None` if it cannot be simulated.
fn likeliest(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let mut best: Option<(Sketch, Hypothesis)> = None;
    for own in std::iter::once(hypothesis.clone()).chain(others(hypothesis)) {
        let (start, free, bounds) = with_freedoms(stand, &own);
        let sketch = match bench.sketch(&start, &free, &bounds, &stand.train, control) {
            Ok(sketch) => sketch,
            Err(DiagnoseError::Sim(_)) => continue,
            Err(error) => return Err(error),
        };
        log::debug!("{:.1} at {:?}", sketch.cost(), own.start.values);
        if best.as_ref().is_none_or(|b| sketch.cost() < b.0.cost()) {
            best = Some((sketch, own));
        }
    }
    let Some((sketch, own)) = best else {
        return Ok(None);
    };
    match bench.complete(sketch, ITERATIONS, control) {
        Ok(train) => judged(bench, stand, &own, train, control).map(Some),
        Err(DiagnoseError::Sim(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The model of `stand` with a hypothesis to begin with, what is fitted and its bounds.
fn with_freedoms(stand: &Stand, hypothesis: &Hypothesis) -> (Model, Vec<String>, Vec<Bound>) {
    let start = with_effect(&stand.train.model, hypothesis.start.clone());
    let (mut free, mut bounds) = freedoms(stand);
    free.extend_from_slice(&hypothesis.free);
    bounds.extend_from_slice(&hypothesis.bounds);
    (start, free, bounds)
}

/// A fit with one more effect from the fit of `stand`; `None` if it cannot be simulated.
fn from_near(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let (start, free, bounds) = with_freedoms(stand, hypothesis);
    match bench.fit(&start, &free, &bounds, &stand.train, ITERATIONS, control) {
        Ok(train) => judged(bench, stand, hypothesis, train, control).map(Some),
        Err(DiagnoseError::Sim(_)) => Ok(None),
        Err(error) => Err(error),
    }
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
    let (_, free, bounds) = with_freedoms(stand, &trial.hypothesis);
    let train = match bench.fit(&start, &free, &bounds, &other.train, ITERATIONS, control) {
        Ok(train) => train,
        Err(DiagnoseError::Sim(_)) => return Ok(trial.clone()),
        Err(error) => return Err(error),
    };
    let again = judged(bench, stand, &trial.hypothesis, train, control)?;
    log::debug!(
        "{} from where {} has come to: {:.0} in place of {:.0}",
        of(trial).id,
        of(other).id,
        again.worth(),
        trial.worth()
    );
    Ok(if again.worth() > trial.worth() {
        again
    } else {
        trial.clone()
    })
}

/// A fit with one more effect against that of `stand`.
fn judged(
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

/// A fit with the first effect from where the re-tuning began, for `stand` has been drawn
/// along by what it lacks; `None` if it cannot be simulated.
fn from_afar(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let mut hypothesis = hypothesis.clone();
    if let Some((start, free)) = hypothesis.full.take() {
        hypothesis.start = start;
        hypothesis.free = free;
        hypothesis.bounds.clear();
    }
    let start = with_effect(&bench.outset, hypothesis.start.clone());
    let train = match bench.from_afar(&start, &hypothesis.free, &hypothesis.bounds, control) {
        Ok(fitted) => fitted,
        Err(DiagnoseError::Sim(_)) => return Ok(None),
        Err(error) => return Err(error),
    };
    let held_out = bench.judge(&train.model, (&train, None), control)?;
    let gain = |side: &Side, before: &Fitted, after: &Fitted| {
        let first = side.segments();
        Ok::<f64, DiagnoseError>(before.whole_cost(first)? - after.whole_cost(first)?)
    };
    let held_gain = match (&bench.held_out, &stand.held_out, &held_out) {
        (Some(side), Some(before), Some(after)) => gain(side, before, after)?,
        _ => 0.0,
    };
    Ok(Some(Trial {
        gain: gain(&bench.train, &stand.train, &train)?,
        held_gain,
        train,
        held_out,
        hypothesis,
    }))
}

/// Freedoms and bounds of the effects named so far.
pub fn freedoms(stand: &Stand) -> (Vec<String>, Vec<Bound>) {
    let all = stand.named.iter().map(|n| &n.hypothesis);
    (
        all.clone().flat_map(|h| h.free.clone()).collect(),
        all.flat_map(|h| h.bounds.clone()).collect(),
    )
}
