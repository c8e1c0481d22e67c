//! Hypotheses fitted once more: with the shape of their law, or as what looks like them.

use super::bench::{Bench, with_effect};
use super::candidates::{LEAST_LAG, SHORTEST_LAG, own_ids, shape_of};
use super::evidence::spans;
use super::explain::{APART, Stand, Trial};
use super::further;
use super::options::{DiagnoseControl, DiagnoseError};
use super::promises::Hypothesis;
use super::weigh::{begun_from, likeliest, with_freedoms};
use crate::model::effects::{ActiveEffect, EffectSpec};

/// Fall of chi2 on both sides from which a law has shown up.
const SHOWS: f64 = 40.0;
/// Fall of chi2 from which another shape of a law is better by more than chance.
const SHAPED: f64 = 25.0;
/// Falls on either side and on both from which another shape is better where the recordings
/// kept out confirm it.
const SHAPED_BY_BOTH: (f64, f64) = (5.0, 30.0);

/// Fall of chi2 from which a lag is large enough for a part of the stretches to tell it.
const LARGE: f64 = 1e4;

/// Share of its delay that an amplifier owes to its pace to begin with, where it has a time
/// constant as well.
const BY_PACE: f64 = 0.75;

/// Creep of two times begins with them so many times shorter and longer than one of them all.
const APART_BY: f64 = 3.0;

/// `trial` with its law given the shape that suits best, if that brings more than chance on
/// both sides; that is asked once. The shape of a further mode is one more mode beside it, where
/// a hump of one is left. A shape of one number stays free in later fits; one of more is
/// kept as it is, for they would take too long.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn shaped(
    bench: &Bench,
    stand: &Stand,
    trial: Trial,
    control: &DiagnoseControl<'_>,
) -> Result<Trial, DiagnoseError> {
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
    let mut start = trial.train.model.clone();
    let edge = || {
        let (_, _, volts) = spans(&trial.train);
        volts.1 - volts.0
    };
    if let Some(both) = settling(effect, edge) {
        let tau = own_ids(both.spec, &[0])[0].clone();
        whole.bounds.retain(|(id, _)| *id != tau);
        whole
            .bounds
            .push((tau, (LEAST_LAG * SHORTEST_LAG, f64::INFINITY)));
        whole.start = both;
    } else if let Some(both) = creeping(effect) {
        let ids = own_ids(both.spec, &[0, 1, 2, 3]);
        for (own, further) in ids[..2].iter().zip(&ids[2..]) {
            let bound = whole.bounds.iter().find(|(id, _)| id == own);
            let further = bound.map(|(_, bound)| (further.clone(), *bound));
            whole.bounds.extend(further);
        }
        whole.start = both;
    }
    start = with_effect(&start, whole.start.clone());
    let other = if whole.start.spec.id == "extra_mode" {
        match further::one_more(&bench.train, whole, &trial.train)? {
            Some(both) => likeliest(bench, stand, &both, &trial.train, control)?,
            None => None,
        }
    } else {
        begun_from(bench, stand, &whole, (&start, &trial.train), control)?
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
    let (more, held_more) = (other.gain - trial.gain, other.held_gain - trial.held_gain);
    let (own, both) = SHAPED_BY_BOTH;
    let confirmed = more.min(held_more) > own && more + held_more > both;
    let told = more > SHAPED && (stand.held_out.is_none() || held_more > 0.0);
    Ok(if told || confirmed { other } else { trial })
}

/// An amplifier that has a time constant or a bounded pace with both, as late as before for an
/// edge of `edge()` \[V\]: where one of them is nothing, or too small for the other to matter, no
/// slope leads away from there. `None` for other effects.
fn settling(effect: &ActiveEffect, edge: impl Fn() -> f64) -> Option<ActiveEffect> {
    let [tau, pace] = effect.values[..] else {
        return None;
    };
    if effect.spec.id != "amplifier_lag" || tau > 0.0 && pace > 0.0 {
        return None;
    }
    let edge = Some(edge()).filter(|e| *e > 0.0)?;
    let late = tau + 0.5 * pace * edge;
    // Bound by its pace for so long, it is late by r V/2 + tau^2 / (2 r V).
    let pace = 2.0 * BY_PACE * late / edge;
    let tau = (2.0 * (1.0 - BY_PACE) * late * pace * edge).sqrt();
    Some(ActiveEffect {
        spec: effect.spec,
        values: vec![tau, pace],
    })
}

/// Creep of one time as half of it each of a shorter and of a longer one; `None` for other
/// effects.
fn creeping(effect: &ActiveEffect) -> Option<ActiveEffect> {
    let [share, tau, 0.0, _] = effect.values[..] else {
        return None;
    };
    (effect.spec.id == "piezo_creep").then(|| ActiveEffect {
        spec: effect.spec,
        values: vec![0.5 * share, tau / APART_BY, 0.5 * share, tau * APART_BY],
    })
}

/// A lag of `spec`, which looks like that of `trial` in flight, as long as that is and begun
/// from its fit; `None` if that has no time constant or it cannot be simulated.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn mirrored(
    bench: &Bench,
    stand: &Stand,
    trial: &Trial,
    spec: &'static EffectSpec,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
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
        others: Vec::new(),
        bounds: vec![(free[0].clone(), (LEAST_LAG * lag, f64::INFINITY))],
        free,
        full: None,
        shape: shape_of(spec),
        promise: 0.0,
        searched: false,
        series: trial.hypothesis.series,
        told_by: None,
    };
    let start = with_effect(&start, effect);
    if trial.worth() > LARGE && trial.leaves_nothing() {
        // A part of the stretches tells where the two are far apart.
        let (free, bounds) = with_freedoms(stand, &hypothesis);
        let sketch = bench.sketch(&start, &free, &bounds, &trial.train, control);
        if sketch.is_ok_and(|s| s.per_value() > APART * trial.train.per_value()) {
            return Ok(None);
        }
    }
    begun_from(bench, stand, &hypothesis, (&start, &trial.train), control)
}

#[cfg(test)]
mod tests {
    use super::*;
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
    fn an_amplifier_with_both_is_as_late_as_with_one() {
        let spec = find("amplifier_lag").unwrap();
        for values in [[20e-6, 0.0], [0.0, 2e-6]] {
            let effect = ActiveEffect {
                spec,
                values: values.to_vec(),
            };
            let both = settling(&effect, || 16.0).unwrap();
            assert!(both.values.iter().all(|v| *v > 0.0), "{both:?}");
            let (before, after) = (late(&values, 16.0), late(&both.values, 16.0));
            assert!((after / before - 1.0).abs() < 1e-3, "{before} {after}");
            // No edge, and nothing to share out.
            assert!(settling(&effect, || 0.0).is_none());
            assert!(settling(&both, || 16.0).is_none());
        }
    }
}
