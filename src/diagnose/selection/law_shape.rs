//! Hypotheses refitted with further shape parameters of their law, or as their lag twin.

use super::refit::{best_start_on_subset, fit_from, parameters_with, refit};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::significance::is_at_lower_bound;
use crate::diagnose::comparison::trial::{CandidateFit, ModelState};
use crate::diagnose::hypotheses::second_mode::with_second_mode;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::score_test::forms::{MIN_LAG_SHARE, pace_parameters};
use crate::diagnose::score_test::state_range::state_ranges;
use crate::diagnose::shooting::fitted::Bound;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    CONFIRMED_SHAPE_GAINS, LARGE_LAG_GAIN, LEAVES_MUCH_RATIO, SHAPE_FITTED_MIN_GAIN, SHAPE_MIN_GAIN,
};
use crate::model::effects::{ActiveEffect, EffectSpec, RefinedBounds, own_ids};
use crate::model::with_effect;

/// Iterations of a fit with one more mode, which is slow. What remains after these lies along its
/// coupling and its shape, which are hardly distinguished.
const SECOND_MODE_STEPS: usize = 6;

/// `trial` with the shape parameters of its law, if these improve both splits significantly; this
/// is tried once. The shape of a further mode is one more mode where a peak remains; that of creep
/// is a second time constant. A single shape parameter stays free in later fits; several are then
/// fixed, because the fits would take too long.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn with_shape_parameters(
    workspace: &Workspace,
    state: &ModelState,
    trial: CandidateFit,
    control: &DiagnoseControl<'_>,
) -> Result<CandidateFit, DiagnoseError> {
    let mut trial = trial;
    let shape = std::mem::take(&mut trial.hypothesis.shape);
    let hypothesis = &trial.hypothesis;
    let effects = &trial.train.model.effects;
    let effect = effects.iter().find(|e| e.spec == hypothesis.start.spec);
    let known = trial.worth() > SHAPE_FITTED_MIN_GAIN && !shape.is_empty();
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
        let (_, _, volts) = state_ranges(&trial.train);
        volts.1 - volts.0
    };
    if let Some((refined, bounds)) = refined(effect, edge) {
        whole.bounds = refined_bounds(refined.spec, bounds, whole.bounds);
        whole.start = refined;
    }
    let start = with_effect(&trial.train.model, whole.start.clone());
    let other = if whole.start.spec.adds_modes() {
        match with_second_mode(&workspace.train, whole, &trial.train)? {
            Some(both) => best_start_on_subset(
                workspace,
                state,
                &both,
                (&trial.train, SECOND_MODE_STEPS),
                control,
            )?,
            None => None,
        }
    } else {
        fit_from(workspace, state, &whole, (&start, &trial.train), control)?
    };
    let Some(mut other) = other else {
        return Ok(trial);
    };
    log::debug!(
        "with its shape {:.0}, held-out {:.0}, in place of {:.0}, held-out {:.0}",
        other.gain,
        other.held_gain,
        trial.gain,
        trial.held_gain
    );
    if shape.len() > 1 {
        other.hypothesis.free.clone_from(&hypothesis.free);
    }
    let held_more = state.held_out.as_ref();
    let held_more = held_more.map(|_| other.held_gain - trial.held_gain);
    // A shape that has taken over the effect's strength is no improvement.
    let better = shape_is_significant(other.gain - trial.gain, held_more)
        && !is_at_lower_bound(&other.hypothesis, &other.train.model);
    Ok(if better { other } else { trial })
}

/// Whether a shape with these gains on the fitted recordings and on the held-out ones, if there
/// are any, is better by more than chance.
fn shape_is_significant(more: f64, held_more: Option<f64>) -> bool {
    let (own, both) = CONFIRMED_SHAPE_GAINS;
    let held = held_more.unwrap_or(0.0);
    let confirmed = more.min(held) > own && more + held > both;
    more > SHAPE_MIN_GAIN && held_more.is_none_or(|held| held > 0.0) || confirmed
}

/// Takes back the second time constant of creep named before the latest effect, where it is no
/// longer significant together with the latest: what it described was the latest effect's.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn drop_second_time_constant(
    workspace: &Workspace,
    state: &mut ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    let latest = state.named.last().map(|n| n.spec);
    let mut effects = state.train.model.effects.clone();
    effects.retain(|e| Some(e.spec) != latest && state.named.iter().any(|n| n.spec == e.spec));
    for plain in effects.iter().filter_map(simplified) {
        if control.cancelled() {
            break;
        }
        let spec = plain.spec;
        let start = with_effect(&state.train.model, plain);
        let Some((train, held_out)) = refit(workspace, &start, state, state, control)? else {
            continue;
        };
        let held = held_out.as_ref().zip(state.held_out.as_ref());
        let held_more = held.map(|(plain, shaped)| plain.cost - shaped.cost);
        let more = train.cost - state.train.cost;
        log::debug!("a shape brings {more:.0}, held-out {held_more:?}, with the latest name");
        if !shape_is_significant(more, held_more) {
            for own in state.named.iter_mut().filter(|n| n.spec == spec) {
                own.gain.0 -= more;
                own.gain.1 -= held_more.unwrap_or(0.0);
            }
            state.train = train;
            state.held_out = held_out;
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
            bounds.push((tau, (MIN_LAG_SHARE * shortest, f64::INFINITY)));
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

/// The lag of `spec`, which looks like that of `trial` in flight, with the same time constant and
/// started from its fit; `None` if it has no time constant or cannot be simulated.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn as_lag_twin(
    workspace: &Workspace,
    state: &ModelState,
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
        bounds: vec![(free[0].clone(), (MIN_LAG_SHARE * lag, f64::INFINITY))],
        free,
        cold_start: None,
        shape: pace_parameters(spec),
        predicted_gain: 0.0,
        look_elsewhere: false,
        sequential_time: trial.hypothesis.sequential_time,
        estimated_on_held_out: None,
    };
    let start = with_effect(&start, effect);
    if trial.worth() > LARGE_LAG_GAIN && trial.leaves_nothing() {
        // A subset of the segments shows whether the two are far apart.
        let (free, bounds) = parameters_with(state, &hypothesis);
        let sketch = workspace.fit_subset(&start, &free, &bounds, &trial.train, control);
        if sketch.is_ok_and(|s| s.per_value() > LEAVES_MUCH_RATIO * trial.train.per_value()) {
            return Ok(None);
        }
    }
    fit_from(
        workspace,
        state,
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
        const TIME_STEP: f64 = 1e-9;
        let (mut voltage, mut area) = (0.0, 0.0);
        while edge - voltage > 1e-9 * edge {
            area += (edge - voltage) * TIME_STEP;
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
            voltage = (voltage + settles.min(most) * TIME_STEP).min(edge);
        }
        area / edge
    }

    #[test]
    fn creep_with_two_time_constants_has_the_size_and_mean_time_of_one() {
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
    fn an_amplifier_with_both_limits_has_the_same_delay() {
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
