//! Hypotheses weighed: each of those that promise most is fitted, from the fit there is or,
//! where that has lost its way, from where the re-tuning began, and judged on the recordings
//! kept out.

use super::forward::{Stand, Trial, Weighed};
use super::refit::{judged, judged_anew};
use crate::diagnose::hypotheses::level_step_time;
use crate::diagnose::hypotheses::propose::{FOUND, Hypothesis, PROMISING, promises};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions, simulated};
use crate::diagnose::shooting::coarse_fit::Sketch;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::local_fit::modes;
use crate::diagnose::shooting::workspace::{Bench, Bound, with_effect};
use crate::model::Model;
use crate::model::effects::EffectSpec;

/// Share of the best refit below which a promise is far behind.
const FAR: f64 = 0.3;
/// Most hypotheses refitted in a round.
const MOST: usize = 4;
/// Steps of a fit at most.
const ITERATIONS: usize = 12;
/// A ground that steps leaves the flight as it is.
const STEP: &str = "gap_step";

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
    let asked = |spec: &EffectSpec| is_asked(stand, options, only, spec);
    let mut hypotheses = promises(bench, stand, &asked)?;
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
    let mut afar_asked = false;
    // What the re-tuning has found comes first, whatever it promises where clocks have taken it.
    if let Some(known) = bench.found.as_ref().filter(|_| stand.named.is_empty()) {
        let is_known = |h: &Hypothesis| h.start.spec == known.start.spec;
        hypotheses.sort_by_key(|h| !is_known(h));
        hypotheses.dedup_by(|later, earlier| is_known(later) && is_known(earlier));
    }
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
            // From afar takes as long as the re-tuning did: only for what promises most of all
            // that acts in flight, where that has gone astray.
            let afar = !afar_asked && stand.named.is_empty() && hypothesis.start.spec.id != STEP;
            afar_asked |= afar;
            trial = attempt(bench, stand, &hypothesis, afar, control)?;
            best = trial.as_ref().map_or(best, |t| best.max(t.gain));
        }
        let own = Weighed {
            spec: hypothesis.start.spec,
            promise: hypothesis.promise,
            trial,
            by_itself: None,
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

/// Whether an effect is a candidate, or the `only` one, and not named yet.
pub fn is_asked(
    stand: &Stand,
    options: &DiagnoseOptions,
    only: Option<&str>,
    spec: &EffectSpec,
) -> bool {
    let wanted = match only {
        Some(only) => only == spec.id,
        None => options.has_candidate(spec.id),
    };
    wanted && stand.named.iter().all(|n| n.spec != spec)
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
    if let Some(trial) = found(bench, stand, hypothesis, control)? {
        return Ok(Some(trial));
    }
    // A further mode begins with what a fit has left to it.
    let further = hypothesis.start.spec.id == "extra_mode";
    let astray = afar && !stand.misread && !further && stand.train.is_lost();
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
        likeliest(
            nearby,
            stand,
            hypothesis,
            (&stand.train, ITERATIONS),
            control,
        )?
    } else {
        from_near(nearby, stand, hypothesis, control)?
    };
    let Some(mut near) = near else {
        return Ok(None);
    };
    let better = |near: Trial, other: &Hypothesis| {
        // They look alike to the fitted recordings: the fit of the one is all but the other's.
        let start = with_constants(&near.train.model, other);
        let tried = begun_from(nearby, stand, other, (&start, &near.train), control)?;
        let tried = tried.filter(|tried| tried.worth() > near.worth());
        Ok::<Trial, DiagnoseError>(tried.unwrap_or(near))
    };
    for other in others(hypothesis).filter(|_| !further) {
        near = better(near, &other)?;
    }
    if hypothesis.start.spec.id == STEP
        && hypothesis.told_by.is_none()
        && let Some(finer) = level_step_time::finer(&near)?
    {
        near = better(near, &finer)?;
    }
    if astray
        && hypothesis.full.is_none()
        && near.train.is_lost()
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

/// The fit with what the re-tuning has found without which the baseline is lost; `None` for other
/// hypotheses and elsewhere.
fn found(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let known = bench.found.as_ref().filter(|_| stand.named.is_empty());
    let Some(known) = known.filter(|k| k.start.spec == hypothesis.start.spec) else {
        return Ok(None);
    };
    let own = Hypothesis {
        start: known.start.clone(),
        free: known.free.clone(),
        bounds: known.bounds.clone(),
        full: None,
        shape: known.shape.clone(),
        ..hypothesis.clone()
    };
    judged_anew(bench, stand, own, known.fitted.clone(), control).map(Some)
}

/// `model` with the effect of a hypothesis that it has already, but for what is not fitted.
fn with_constants(model: &Model, hypothesis: &Hypothesis) -> Model {
    let mut with = model.clone();
    let own = &hypothesis.start;
    for effect in with.effects.iter_mut().filter(|e| e.spec == own.spec) {
        let all = own.spec.parameters.iter().zip(&own.values).enumerate();
        for (i, (parameter, value)) in all {
            let id = format!("{}.{}", own.spec.id, parameter.id);
            if !hypothesis.free.contains(&id) {
                effect.values[i] = *value;
            }
        }
    }
    with
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
/// recordings best, begun from the fit `near`, in so many `steps` at most: of a further mode, whose
/// fits take long. `None` if it cannot be simulated.
pub fn likeliest(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    (near, steps): (&Fitted, usize),
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let mut best: Option<(Sketch, Hypothesis)> = None;
    for own in std::iter::once(hypothesis.clone()).chain(others(hypothesis)) {
        let (free, bounds) = with_freedoms(stand, &own);
        let start = with_effect(&near.model, own.start.clone());
        let sketch = bench.sketch(&start, &free, &bounds, near, control);
        let Some(sketch) = simulated(sketch)? else {
            continue;
        };
        log::debug!("{:.1} at {:?}", sketch.cost(), own.start.values);
        if best.as_ref().is_none_or(|b| sketch.cost() < b.0.cost()) {
            best = Some((sketch, own));
        }
    }
    let Some((sketch, own)) = best else {
        return Ok(None);
    };
    let train = simulated(bench.complete(sketch, steps, control))?;
    let judged = train.map(|train| judged(bench, stand, &own, train, control));
    judged.transpose()
}

/// What is fitted with one more effect, and its bounds.
pub fn with_freedoms(stand: &Stand, hypothesis: &Hypothesis) -> (Vec<String>, Vec<Bound>) {
    let (mut free, mut bounds) = freedoms(stand);
    free.extend_from_slice(&hypothesis.free);
    bounds.extend_from_slice(&hypothesis.bounds);
    (free, bounds)
}

/// A fit with one more effect from the fit of `stand`; `None` if it cannot be simulated.
fn from_near(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let start = with_effect(&stand.train.model, hypothesis.start.clone());
    begun_from(bench, stand, hypothesis, (&start, &stand.train), control)
}

/// A fit with one more effect that begins with a model and the states of another fit; `None`
/// if it cannot be simulated.
pub fn begun_from(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    (start, near): (&Model, &Fitted),
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let (free, bounds) = with_freedoms(stand, hypothesis);
    let train = simulated(bench.fit(start, &free, &bounds, near, ITERATIONS, control))?;
    let judged = train.map(|train| judged(bench, stand, hypothesis, train, control));
    judged.transpose()
}

/// `start` with what the effects named in `stand` leave free, fitted from the fit of `near` and
/// judged; `None` if it cannot be simulated, or a part of the stretches shows that it is lost
/// without a mode that `near` has.
///
/// # Errors
/// [`DiagnoseError`] if the recordings cannot be used.
pub fn refitted(
    bench: &Bench,
    start: &Model,
    stand: &Stand,
    near: &Stand,
    control: &DiagnoseControl<'_>,
) -> Result<Option<(Fitted, Option<Fitted>)>, DiagnoseError> {
    let (free, bounds) = freedoms(stand);
    let train = if modes(start) == modes(&near.train.model) {
        bench.fit(start, &free, &bounds, &near.train, ITERATIONS, control)
    } else {
        let sketch = bench.sketch(start, &free, &bounds, &near.train, control);
        if let Ok(sketch) = &sketch
            && sketch.is_lost_beside(&near.train)
        {
            return Ok(None);
        }
        sketch.and_then(|sketch| bench.complete(sketch, ITERATIONS, control))
    };
    let Some(train) = simulated(train)? else {
        return Ok(None);
    };
    let held_out = bench.judge(&train.model, (&train, near.held_out.as_ref()), control)?;
    Ok(Some((train, held_out)))
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
    let train = bench.from_afar(&start, &hypothesis.free, &hypothesis.bounds, control);
    let Some(train) = simulated(train)? else {
        return Ok(None);
    };
    judged_anew(bench, stand, hypothesis, train, control).map(Some)
}

/// Freedoms and bounds of the effects named so far.
fn freedoms(stand: &Stand) -> (Vec<String>, Vec<Bound>) {
    let all = stand.named.iter().map(|n| &n.hypothesis);
    (
        all.clone().flat_map(|h| h.free.clone()).collect(),
        all.flat_map(|h| h.bounds.clone()).collect(),
    )
}
