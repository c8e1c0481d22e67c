//! Hypotheses refitted with further shape parameters of their law, or as their lag twin.

use super::refit::{best_start_on_subset, fit_from, parameters_with, refit};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::significance::is_at_lower_bound;
use crate::diagnose::comparison::trial::{CandidateFit, ModelState};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::score_test::forms::{MIN_LAG_SHARE, MIN_TIME_CONSTANT, pace_parameters};
use crate::diagnose::score_test::state_range::state_ranges;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    CONFIRMED_SHAPE_GAINS, LARGE_LAG_GAIN, LEAVES_MUCH_RATIO, SHAPE_FITTED_MIN_GAIN, SHAPE_MIN_GAIN,
};
use crate::model::effects::{ActiveEffect, EffectSpec, own_ids};
use crate::model::with_effect;

/// Initial share of an amplifier's delay due to its slew rate, where it has a time constant as
/// well.
const SLEW_SHARE_OF_DELAY: f64 = 0.75;

/// Iterations of a fit with one more mode, which is slow. What remains after these lies along its
/// coupling and its shape, which are hardly distinguished.
const SECOND_MODE_STEPS: usize = 6;

/// Creep with two time constants starts from values this factor shorter and longer than the single
/// one.
const CREEP_TIME_RATIO: f64 = 3.0;

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
    if let Some(both) = with_both_amplifier_limits(effect, edge) {
        let tau = own_ids(both.spec, &[0])[0].clone();
        whole.bounds.retain(|(id, _)| *id != tau);
        whole
            .bounds
            .push((tau, (MIN_LAG_SHARE * MIN_TIME_CONSTANT, f64::INFINITY)));
        whole.start = both;
    } else if let Some(both) = with_two_creep_times(effect) {
        let ids = own_ids(both.spec, &[0, 1, 2, 3]);
        for (own, further) in ids[..2].iter().zip(&ids[2..]) {
            let bound = whole.bounds.iter().find(|(id, _)| id == own);
            let further = bound.map(|(_, bound)| (further.clone(), *bound));
            whole.bounds.extend(further);
        }
        whole.start = both;
    }
    let start = with_effect(&trial.train.model, whole.start.clone());
    let other = if whole.start.spec.id == "extra_mode" {
        match crate::diagnose::hypotheses::extra_mode::with_second_mode(
            &workspace.train,
            whole,
            &trial.train,
        )? {
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
        "with its shape {:.0}, {:.0} kept out in place of {:.0}, {:.0}",
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
    for plain in effects.iter().filter_map(with_one_creep_time) {
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
        log::debug!("a shape brings {more:.0}, {held_more:?} kept out beside the latest name");
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

/// Creep of two time constants as that of one between them; `None` for other effects.
fn with_one_creep_time(effect: &ActiveEffect) -> Option<ActiveEffect> {
    let [share, tau, further, tau2] = effect.values[..] else {
        return None;
    };
    let all = share + further;
    (effect.spec.id == "piezo_creep" && share * further > 0.0).then(|| ActiveEffect {
        spec: effect.spec,
        values: vec![
            all,
            ((share * tau.ln() + further * tau2.ln()) / all).exp(),
            0.0,
            tau2,
        ],
    })
}

/// An amplifier with a time constant or a slew rate as one with both and the same delay for an
/// edge of `edge()` \[V\]. Where one of them is zero or too small to matter, the gradient does not
/// lead away from there. `None` for other effects.
fn with_both_amplifier_limits(
    effect: &ActiveEffect,
    edge: impl Fn() -> f64,
) -> Option<ActiveEffect> {
    let [tau, pace] = effect.values[..] else {
        return None;
    };
    if effect.spec.id != "amplifier_lag" || tau > 0.0 && pace > 0.0 {
        return None;
    }
    let edge = Some(edge()).filter(|e| *e > 0.0)?;
    let late = tau + 0.5 * pace * edge;
    // Bound by its pace for so long, it is late by r V/2 + tau^2 / (2 r V).
    let pace = 2.0 * SLEW_SHARE_OF_DELAY * late / edge;
    let tau = (2.0 * (1.0 - SLEW_SHARE_OF_DELAY) * late * pace * edge).sqrt();
    Some(ActiveEffect {
        spec: effect.spec,
        values: vec![tau, pace],
    })
}

/// Creep of one time constant as half of it each with a shorter and a longer one; `None` for other
/// effects.
fn with_two_creep_times(effect: &ActiveEffect) -> Option<ActiveEffect> {
    let [share, tau, 0.0, _] = effect.values[..] else {
        return None;
    };
    (effect.spec.id == "piezo_creep").then(|| ActiveEffect {
        spec: effect.spec,
        values: vec![
            0.5 * share,
            tau / CREEP_TIME_RATIO,
            0.5 * share,
            tau * CREEP_TIME_RATIO,
        ],
    })
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
        let two = with_two_creep_times(&one).unwrap();
        assert!(two.values[1] < 12e-3 && two.values[3] > 12e-3, "{two:?}");
        assert!(with_two_creep_times(&two).is_none() && with_one_creep_time(&one).is_none());
        let back = with_one_creep_time(&two).unwrap();
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
            let both = with_both_amplifier_limits(&effect, || 16.0).unwrap();
            assert!(both.values.iter().all(|v| *v > 0.0), "{both:?}");
            let (before, after) = (late(&values, 16.0), late(&both.values, 16.0));
            assert!((after / before - 1.0).abs() < 1e-3, "{before} {after}");
            // No edge, and nothing to share out.
            assert!(with_both_amplifier_limits(&effect, || 0.0).is_none());
            assert!(with_both_amplifier_limits(&both, || 16.0).is_none());
        }
    }
}
