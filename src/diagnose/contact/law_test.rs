//! The test of one contact law: the events fitted with and without it, on both sides.

use super::robust_curve::Reading;
use crate::diagnose::thresholds::{CONTACT_TRAIN_GAIN, MIN_HELD_OUT_EVENTS};
use crate::fit::contact_readings::Bounce;
use crate::model::effects::{ActiveEffect, ContactLaw};
use crate::model::parameter::ParameterId;

/// Said of a law if held-out recordings have too few bounces.
pub(crate) const CROSS_VALIDATED: &str = ", confirmed by leaving out each recording in turn";
/// Said of a law that the fitted recordings do not determine by themselves.
pub(crate) const ONLY_WITH_HELD_OUT: &str = ", but only together with the held-out recordings";

/// A contact law, fitted to the events with and without an effect.
#[derive(Debug, Clone)]
pub struct LawTest {
    /// Id of the effect.
    pub id: &'static str,
    /// Fall of chi2 on the fitted recordings, in units of the scatter that is left.
    pub gain: f64,
    /// Fall on held-out recordings.
    pub held_gain: f64,
    /// If the held-out gain is a predictive one (averaged over what the fitted recordings leave open):
    /// the gain of both sides from which the law counts even if the fitted recordings do not
    /// determine it by themselves.
    pub min_predictive_gain: Option<f64>,
    /// Chi2 per event on held-out recordings, with the effect.
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

impl LawTest {
    /// The contact law that the effect changes.
    pub fn law(&self) -> Option<ContactLaw> {
        self.effect.spec.contact_law()
    }
}

/// Whether a law is determined only by fitted and held-out recordings together: a few bounces
/// determine little by themselves.
pub(crate) fn needs_both_sides(gain: f64, held_gain: f64, held: &[Reading]) -> bool {
    held.len() >= MIN_HELD_OUT_EVENTS && gain <= CONTACT_TRAIN_GAIN && held_gain > 0.0
}

/// Which recordings prove a law, to be added to its evidence.
pub(crate) fn proof_remark(gain: f64, held_gain: f64, held: &[Reading]) -> &'static str {
    if needs_both_sides(gain, held_gain, held) {
        ONLY_WITH_HELD_OUT
    } else if held.len() < MIN_HELD_OUT_EVENTS {
        CROSS_VALIDATED
    } else {
        ""
    }
}

/// Cross-validation, if held-out recordings have too few bounces: fall of chi2 over the fitted
/// recordings, each left out in turn. `gain` is that of the points left out for a law fitted to the
/// others.
pub(crate) fn cross_validated_gain(
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
