//! Significance of a fall of chi2: how much chance alone brings, with free initial states and
//! searches over many places allowed for.

use super::hypothesis::Hypothesis;
use crate::diagnose::thresholds::{
    CONFIRMED_GAINS, HELD_GAIN, INITIAL_STATE_MAX_Z, SEARCHED_GAIN, TRAIN_GAIN, UNPROVED_FACTOR,
    VANISHED_STRENGTH_RATIO,
};
use crate::model::Model;

/// Whether chance explains a `gain` on the fitted recordings, given that of held-out ones. An effect
/// that was searched for over many places needs more, because the best of them is seen.
pub fn is_insignificant(hypothesis: &Hypothesis, gain: f64, held_gain: f64) -> bool {
    let (own, both) = CONFIRMED_GAINS;
    let confirmed = gain > own && held_gain > own && gain + held_gain > both;
    gain < least(hypothesis) && (hypothesis.look_elsewhere || !confirmed)
}

/// Whether the fitted recordings improve by far more than chance would and held-out ones do not: then
/// something is missing, but not this effect. Exceptions: a further mode has a free initial state in
/// each segment, by which chance gains more; an effect that begins after the fitted recordings gains
/// on held-out ones only; and an effect that was searched for fits any single misread event, so that
/// one which worsens held-out recordings by more than it gains is refuted and proves nothing.
pub fn fails_held_out(hypothesis: &Hypothesis, gain: f64, held_gain: f64) -> bool {
    let mode = hypothesis.start.spec.adds_modes();
    let refuted = hypothesis.look_elsewhere && held_gain < -gain;
    let asked = hypothesis.estimated_on_held_out.is_none() && !mode && !refuted;
    asked && gain > unproved_gain(hypothesis) && held_gain < HELD_GAIN
}

/// Gain on the fitted recordings from which a failure on held-out ones speaks for something
/// missing.
fn unproved_gain(hypothesis: &Hypothesis) -> f64 {
    UNPROVED_FACTOR * least(hypothesis)
}

/// Whether free initial states explain a `gain`, `unknowns` of them in all: chi2 falls by one for each
/// on average, which is subtracted already, and scatters about that by sqrt(2 n).
pub fn within_initial_state_dof(unknowns: usize, gain: f64) -> bool {
    gain < INITIAL_STATE_MAX_Z * (2.0 * unknowns as f64).sqrt()
}

/// Whether the fit has made the effect of `hypothesis` in `model` as weak as its bounds allow: its gain
/// is then due to the path of the fit, not to the effect.
pub fn is_at_lower_bound(hypothesis: &Hypothesis, model: &Model) -> bool {
    let bound = |id: &String| hypothesis.bounds.iter().find(|b| b.0 == *id).map(|b| b.1);
    // Constants of a law stay between two bounds, its strength above one.
    let carries = |id: &&String| bound(id).is_none_or(|(_, most)| most.is_infinite());
    let weak = |id: &String| {
        let least = bound(id).map_or(0.0, |(least, _)| least);
        let value = model.get(id);
        value.is_some_and(|value| value.abs() <= VANISHED_STRENGTH_RATIO * least)
    };
    let mut strengths = hypothesis.free.iter().filter(carries).peekable();
    strengths.peek().is_some() && strengths.all(weak)
}

/// Fall of chi2 on the fitted recordings that chance explains.
fn least(hypothesis: &Hypothesis) -> f64 {
    if hypothesis.look_elsewhere {
        SEARCHED_GAIN
    } else {
        TRAIN_GAIN
    }
}

#[cfg(test)]
mod tests {
    use super::super::significance::*;
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::preset::Preset;
    use crate::model::with_effect;

    fn of(id: &str, searched: bool) -> Hypothesis {
        Hypothesis {
            start: ActiveEffect::new(find(id).unwrap()),
            alternative_starts: Vec::new(),
            free: Vec::new(),
            cold_start: None,
            shape: Vec::new(),
            bounds: Vec::new(),
            predicted_gain: 0.0,
            look_elsewhere: searched,
            sequential_time: false,
            estimated_on_held_out: None,
        }
    }

    #[test]
    fn an_effect_at_its_lower_bound_has_vanished() {
        let paper = Preset::embedded("paper").unwrap().model;
        let with = |tau: f64, pace: f64| {
            let spec = find("amplifier_lag").unwrap();
            let values = vec![tau, pace];
            with_effect(&paper, ActiveEffect { spec, values })
        };
        let id = |parameter: &str| format!("amplifier_lag.{parameter}");
        let lag = Hypothesis {
            free: vec![id("tau")],
            bounds: vec![(id("tau"), (3e-7, f64::INFINITY))],
            ..of("amplifier_lag", false)
        };
        assert!(is_at_lower_bound(&lag, &with(3e-7, 0.0)));
        assert!(!is_at_lower_bound(&lag, &with(4e-7, 0.0)));
        // One that slews may settle as quickly as it likes.
        let both = Hypothesis {
            free: vec![id("tau"), id("r")],
            ..lag
        };
        assert!(!is_at_lower_bound(&both, &with(3e-7, 1e-6)));
        assert!(is_at_lower_bound(&both, &with(3e-7, 0.0)));
        assert!(!is_at_lower_bound(&of("gap_step", true), &paper));
    }

    #[test]
    fn free_initial_states_gain_by_chance() {
        // Two unknowns in each of two hundred segments scatter by 28.
        assert!(within_initial_state_dof(400, 63.0));
        assert!(!within_initial_state_dof(400, 120.0));
        assert!(!within_initial_state_dof(0, 1.0));
    }

    #[test]
    fn a_gain_on_fitted_recordings_alone_is_unproved() {
        let drift = of("zero_drift", false);
        assert!(fails_held_out(&drift, 420.0, -30.0));
        assert!(!fails_held_out(&drift, 420.0, 60.0));
        assert!(!fails_held_out(&drift, 140.0, -30.0));
        // Chance finds more where it is searched for.
        let step = of("gap_step", true);
        assert!(fails_held_out(&step, 420.0, 0.0) && !fails_held_out(&step, 210.0, 0.0));
        // One that spoils the others by more than it gains was none.
        assert!(fails_held_out(&step, 420.0, -400.0) && !fails_held_out(&step, 420.0, -450.0));
        assert!(fails_held_out(&drift, 420.0, -450.0));
        let determined_later = Hypothesis {
            estimated_on_held_out: Some(0),
            ..step
        };
        assert!(!fails_held_out(&determined_later, 420.0, 0.0));
        assert!(!fails_held_out(&of("extra_mode", true), 420.0, 0.0));
    }
}
