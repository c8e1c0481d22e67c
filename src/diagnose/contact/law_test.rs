//! TODO-doc

use super::restitution::{ALSO_HELD_OUT, IN_TURN};
use super::robust_curve::Reading;
use crate::diagnose::thresholds::{CONTACT_TRAIN_GAIN, MIN_HELD_OUT_EVENTS};
use crate::fit::contact_readings::Bounce;
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;

/// A law of the ground, fitted with and without an effect.
#[derive(Debug, Clone)]
pub struct LawTest {
    /// Id of the effect.
    pub id: &'static str,
    /// Fall of chi2 on the fitted recordings, in units of the scatter that is left.
    pub gain: f64,
    /// Fall on those kept out.
    pub held_gain: f64,
    /// Where that is of what the fitted ones foresee, all that they leave open averaged
    /// over, it counts even if these by themselves tell nothing: from this fall on both
    /// sides together.
    pub foreseen: Option<f64>,
    /// Chi2 per event on those kept out, with the effect.
    pub held_chi2: f64,
    /// The effect as fitted.
    pub effect: ActiveEffect,
    /// Standard errors of its parameters, in the order of the catalogue; infinite where not
    /// fitted.
    pub errors: Vec<f64>,
    /// Values of the baseline's own parameters that go with it.
    pub sets: Vec<(ParameterId, f64)>,
    /// Why, in one sentence.
    pub evidence: String,
}

/// Whether the fitted recordings tell a law only together with those kept out: a few bounces
/// tell little by themselves.
pub(crate) fn together(gain: f64, held_gain: f64, held: &[Reading]) -> bool {
    held.len() >= MIN_HELD_OUT_EVENTS && gain <= CONTACT_TRAIN_GAIN && held_gain > 0.0
}

/// By which recordings a law was proved, to be added to its evidence.
pub(crate) fn proved(gain: f64, held_gain: f64, held: &[Reading]) -> &'static str {
    if together(gain, held_gain, held) {
        ALSO_HELD_OUT
    } else if held.len() < MIN_HELD_OUT_EVENTS {
        IN_TURN
    } else {
        ""
    }
}

/// Where those kept out have too few bounces: fall of chi2 over the fitted recordings, each
/// left out in turn. `gain` is that of points left out for a law fitted to others.
pub(crate) fn in_turn(
    bounces: &[Bounce],
    points: &dyn Fn(&[Bounce]) -> Vec<Reading>,
    scale: f64,
    gain: &dyn Fn(&[Reading], &[Reading]) -> f64,
) -> f64 {
    let count = bounces.iter().map(|b| b.recording + 1).max().unwrap_or(0);
    let part = |own: bool, k: usize| -> Vec<Reading> {
        let all = bounces.iter().copied();
        let some: Vec<Bounce> = all.filter(|b| (b.recording == k) == own).collect();
        points(&some)
    };
    let one = |k: usize| {
        let (others, left_out) = (part(false, k), part(true, k));
        if others.len() < MIN_HELD_OUT_EVENTS {
            0.0
        } else {
            gain(&others, &left_out)
        }
    };
    (0..count).map(one).sum::<f64>() / scale
}
