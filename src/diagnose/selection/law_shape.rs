//! Hypotheses fitted once more: with the shape of their law, or as what looks like them.

use super::forward::APART;
use super::refit::{begun_from, best_start_on_subset, refitted, with_freedoms};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::significance::is_at_lower_bound;
use crate::diagnose::comparison::trial::{CandidateFit, ModelState};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::score_test::forms::{LEAST_LAG, shape_of};
use crate::diagnose::score_test::state_range::spans;
use crate::diagnose::shooting::fitted::Bound;
use crate::diagnose::shooting::workspace::Workspace;
use crate::model::effects::{ActiveEffect, EffectSpec, RefinedBounds, own_ids};
use crate::model::with_effect;

/// Fall of chi2 on both sides from which a law has shown up.
const SHOWS: f64 = 40.0;
/// Fall of chi2 from which another shape of a law is better by more than chance.
const SHAPED: f64 = 25.0;
/// Falls on either side and on both from which another shape is better where the recordings
/// kept out confirm it.
const SHAPED_BY_BOTH: (f64, f64) = (5.0, 30.0);

/// Fall of chi2 from which a lag is large enough for a part of the stretches to tell it.
const LARGE: f64 = 1e4;

/// Steps of a fit with one more mode beside a further one, which takes long: after these, what is
/// left goes along what hardly tells, how much moves it and how much of it is seen.
const BESIDE: usize = 6;

/// `trial` with its law given the shape that suits best, if that brings more than chance on
/// both sides; that is asked once. The shape of a further mode is one more mode beside it, where
/// a hump of one is left; that of creep is a second time. A shape of one number stays free in
/// later fits; one of more is kept as it is, for they would take too long.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn with_shape_parameters(
    workspace: &Workspace,
    stand: &ModelState,
    trial: CandidateFit,
    control: &DiagnoseControl<'_>,
) -> Result<CandidateFit, DiagnoseError> {
    let mut trial = trial;
    let shape = std::mem::take(&mut trial.hypothesis.shape);
    let hypothesis = &trial.hypothesis;
    let effects = &trial.train.model.effects;
    let effect = effects.iter().find(|e| e.spec == hypothesis.start.spec);
    let known = trial.worth() > SHOWS && !shape.is_empty();
    let (Some(effect), true) = (effect, known && !control.cancelled()) else {
        return Ok(trial);
    };
    let mut free = hypothesis.free.clone();
    free.extend_from_slice(&shape);
    let mut whole = Hypothesis {
        start: effect.clone(),
        free,
        ..hypothesis.clone()
    };
    let edge = || {
        let (_, _, volts) = spans(&trial.train);
        volts.1 - volts.0
    };
    if let Some((refined, bounds)) = refined(effect, edge) {
        whole.bounds = refined_bounds(refined.spec, bounds, whole.bounds);
        whole.start = refined;
    }
    let start = with_effect(&trial.train.model, whole.start.clone());
    let other = if whole.start.spec.adds_modes() {
        match crate::diagnose::hypotheses::extra_mode::one_more(
            &workspace.train,
            whole,
            &trial.train,
        )? {
            Some(both) => {
                best_start_on_subset(workspace, stand, &both, (&trial.train, BESIDE), control)?
            }
            None => None,
        }
    } else {
        begun_from(workspace, stand, &whole, (&start, &trial.train), control)?
    };
    let Some(mut other) = other else {
        return Ok(trial);
    };
    log::debug!(
        "with its shape {:.0}, {:.0} kept out in place of {:.0}, {:.0}",
        other.gain,
        other.held_gain,
        trial.gain,
        trial.held_gain
    );
    if shape.len() > 1 {
        other.hypothesis.free.clone_from(&hypothesis.free);
    }
    let held_more = stand.held_out.as_ref();
    let held_more = held_more.map(|_| other.held_gain - trial.held_gain);
    // What has left its own strength to its shape is no better told by it.
    let better = tells(other.gain - trial.gain, held_more)
        && !is_at_lower_bound(&other.hypothesis, &other.train.model);
    Ok(if better { other } else { trial })
}

/// Whether a shape that brings so much on the fitted recordings, and on those kept out if there
/// are any, is a better one by more than chance.
fn tells(more: f64, held_more: Option<f64>) -> bool {
    let (own, both) = SHAPED_BY_BOTH;
    let held = held_more.unwrap_or(0.0);
    let confirmed = more.min(held) > own && more + held > both;
    more > SHAPED && held_more.is_none_or(|held| held > 0.0) || confirmed
}

/// Takes back that creep named before the latest effect has two times, where that tells nothing
/// beside the latest: what it told was the latest one's.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn drop_second_time_constant(
    workspace: &Workspace,
    stand: &mut ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    let latest = stand.named.last().map(|n| n.spec);
    let mut effects = stand.train.model.effects.clone();
    effects.retain(|e| Some(e.spec) != latest && stand.named.iter().any(|n| n.spec == e.spec));
    for plain in effects.iter().filter_map(simplified) {
        if control.cancelled() {
            break;
        }
        let spec = plain.spec;
        let start = with_effect(&stand.train.model, plain);
        let Some((train, held_out)) = refitted(workspace, &start, stand, stand, control)? else {
            continue;
        };
        let held = held_out.as_ref().zip(stand.held_out.as_ref());
        let held_more = held.map(|(plain, shaped)| plain.cost - shaped.cost);
        let more = train.cost - stand.train.cost;
        log::debug!("a shape brings {more:.0}, {held_more:?} kept out beside the latest name");
        if !tells(more, held_more) {
            for own in stand.named.iter_mut().filter(|n| n.spec == spec) {
                own.gain.0 -= more;
                own.gain.1 -= held_more.unwrap_or(0.0);
            }
            stand.train = train;
            stand.held_out = held_out;
        }
    }
    Ok(())
}

/// `effect` without the shape of its law, as near as possible to it; `None` without a shape.
fn simplified(effect: &ActiveEffect) -> Option<ActiveEffect> {
    let spec = effect.spec;
    let values = (spec.search.refinement?.simplified)(&effect.values)?;
    Some(ActiveEffect { spec, values })
}

/// `effect` as it begins a fit with the shape of its law, for edges of `edge()` \[V\], and the
/// bounds in that; `None` if it is a good start already.
fn refined(effect: &ActiveEffect, edge: impl Fn() -> f64) -> Option<(ActiveEffect, RefinedBounds)> {
    let spec = effect.spec;
    let refinement = spec.search.refinement?;
    let values = (refinement.start)(&effect.values, &edge)?;
    Some((ActiveEffect { spec, values }, refinement.bounds))
}

/// `bounds` of a fit without the shape of the law of `spec`, for a fit with it.
fn refined_bounds(spec: &EffectSpec, refined: RefinedBounds, bounds: Vec<Bound>) -> Vec<Bound> {
    let mut bounds = bounds;
    let id = |i: usize| own_ids(spec, &[i])[0].clone();
    match refined {
        RefinedBounds::ShortestLag(i, shortest) => {
            let tau = id(i);
            bounds.retain(|(id, _)| *id != tau);
            bounds.push((tau, (LEAST_LAG * shortest, f64::INFINITY)));
        }
        RefinedBounds::Alike(pairs) => {
            for (own, shape) in pairs {
                let own = id(*own);
                let bound = bounds.iter().find(|(id, _)| *id == own);
                let shape = bound.map(|(_, bound)| (id(*shape), *bound));
                bounds.extend(shape);
            }
        }
    }
    bounds
}

/// A lag of `spec`, which looks like that of `trial` in flight, as long as that is and begun
/// from its fit; `None` if that has no time constant or it cannot be simulated.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn as_lag_twin(
    workspace: &Workspace,
    stand: &ModelState,
    trial: &CandidateFit,
    spec: &'static EffectSpec,
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let of = trial.hypothesis.start.spec;
    let mut start = trial.train.model.clone();
    let lag = start
        .get(&format!("{}.tau", of.id))
        .filter(|tau| *tau > 0.0);
    let Some(lag) = lag else {
        return Ok(None);
    };
    start.effects.retain(|e| e.spec != of);
    let mut effect = ActiveEffect::new(spec);
    effect.values.iter_mut().for_each(|v| *v = 0.0);
    effect.values[0] = lag;
    let free = own_ids(spec, &[0]);
    let hypothesis = Hypothesis {
        start: effect.clone(),
        alternative_starts: Vec::new(),
        bounds: vec![(free[0].clone(), (LEAST_LAG * lag, f64::INFINITY))],
        free,
        cold_start: None,
        shape: shape_of(spec),
        predicted_gain: 0.0,
        look_elsewhere: false,
        sequential_time: trial.hypothesis.sequential_time,
        estimated_on_held_out: None,
    };
    let start = with_effect(&start, effect);
    if trial.worth() > LARGE && trial.leaves_nothing() {
        // A part of the stretches tells where the two are far apart.
        let (free, bounds) = with_freedoms(stand, &hypothesis);
        let sketch = workspace.sketch(&start, &free, &bounds, &trial.train, control);
        if sketch.is_ok_and(|s| s.per_value() > APART * trial.train.per_value()) {
            return Ok(None);
        }
    }
    begun_from(
        workspace,
        stand,
        &hypothesis,
        (&start, &trial.train),
        control,
    )
}

#[cfg(test)]
mod tests {
    use super::super::law_shape::*;
    use crate::model::effects::find;

    /// Mean time by which an edge of `edge` \[V\] is late, by small steps.
    fn late(values: &[f64], edge: f64) -> f64 {
        const STEP: f64 = 1e-9;
        let (mut voltage, mut area) = (0.0, 0.0);
        while edge - voltage > 1e-9 * edge {
            area += (edge - voltage) * STEP;
            let settles = if values[0] > 0.0 {
                (edge - voltage) / values[0]
            } else {
                f64::INFINITY
            };
            let most = if values[1] > 0.0 {
                1.0 / values[1]
            } else {
                f64::INFINITY
            };
            voltage = (voltage + settles.min(most) * STEP).min(edge);
        }
        area / edge
    }

    #[test]
    fn creep_of_two_times_is_as_large_and_as_slow_as_that_of_one() {
        let spec = find("piezo_creep").unwrap();
        let values = vec![0.05, 12e-3, 0.0, 0.2];
        let one = ActiveEffect { spec, values };
        let edge = || 16.0;
        let (two, _) = refined(&one, edge).unwrap();
        assert!(two.values[1] < 12e-3 && two.values[3] > 12e-3, "{two:?}");
        assert!(refined(&two, edge).is_none() && simplified(&one).is_none());
        let back = simplified(&two).unwrap();
        for (back, one) in back.values[..3].iter().zip(&one.values) {
            assert!((back - one).abs() < 1e-12, "{back} {one}");
        }
    }

    #[test]
    fn an_amplifier_with_both_is_as_late_as_with_one() {
        let spec = find("amplifier_lag").unwrap();
        for values in [[20e-6, 0.0], [0.0, 2e-6]] {
            let effect = ActiveEffect {
                spec,
                values: values.to_vec(),
            };
            let (both, _) = refined(&effect, || 16.0).unwrap();
            assert!(both.values.iter().all(|v| *v > 0.0), "{both:?}");
            let (before, after) = (late(&values, 16.0), late(&both.values, 16.0));
            assert!((after / before - 1.0).abs() < 1e-3, "{before} {after}");
            // No edge, and nothing to share out.
            assert!(refined(&effect, || 0.0).is_none());
            assert!(refined(&both, || 16.0).is_none());
        }
    }
}
