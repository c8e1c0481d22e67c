//! The test of one contact law: the events fitted with and without it, on both sides.

use super::robust_curve::{Curve, Reading, cost, curve, scatter};
use crate::diagnose::findings::{Evidence, LawProof};
use crate::diagnose::thresholds::{
    CONFIRMING_HELD_GAIN, CONTACT_TRAIN_GAIN, MIN_EVENTS, MIN_HELD_OUT_EVENTS,
};
use crate::fit::contact_readings::Bounce;
use crate::model::effects::{ActiveEffect, ContactLaw};
use crate::model::parameter::ParameterId;

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
    /// Why.
    pub evidence: Evidence,
}

impl LawTest {
    /// The contact law that the effect changes.
    pub fn law(&self) -> Option<ContactLaw> {
        self.effect.spec.contact_law()
    }
}

/// A law of the speed of approach with two numbers, the first of which is the value that it has where
/// speed does not matter.
pub(crate) struct LawOverSpeed {
    /// Readings that are known besides those of the bounces.
    pub known: &'static [Reading],
    /// First values of both numbers.
    pub start: [f64; 2],
    /// Its value at a speed for both numbers.
    pub at: fn(f64, &[f64]) -> f64,
    /// Whether a fit of it is more than the rest of a constant one.
    pub shows: fn(&Curve) -> bool,
}

impl LawOverSpeed {
    fn with_known(&self, points: &[Reading]) -> Vec<Reading> {
        [self.known, points].concat()
    }

    /// The constant through some points.
    fn constant(&self, points: &[Reading]) -> Curve {
        curve(&self.with_known(points), &self.start[..1], &|_, p| p[0])
    }

    /// The law through them, from that constant.
    fn fit(&self, points: &[Reading], constant: &Curve) -> Curve {
        let start = [constant.values[0], self.start[1]];
        curve(&self.with_known(points), &start, &self.at)
    }
}

/// A law of the speed against a constant.
pub(crate) struct Comparison {
    /// Fall of chi2 on the fitted recordings, in units of the scatter that is left.
    pub gain: f64,
    /// Fall on held-out recordings.
    pub held_gain: f64,
    /// Chi2 per event on held-out recordings, with the law.
    pub held_chi2: f64,
    /// The law as fitted.
    pub law: Curve,
    /// Scatter that is left, in units of the errors.
    pub root: f64,
    /// The points that it was fitted to.
    pub points: Vec<Reading>,
    /// Which recordings prove it.
    pub proof: LawProof,
}

/// Compares a law with a constant on the `points` of fitted `bounces` and those of `held` out ones.
/// `None` if there are too few.
pub(crate) fn compare(
    law: &LawOverSpeed,
    bounces: &[Bounce],
    held: &[Reading],
    points: &dyn Fn(&[Bounce]) -> Vec<Reading>,
) -> Option<Comparison> {
    let train = points(bounces);
    let all = [train.as_slice(), held].concat();
    if train.is_empty() || all.len() < MIN_EVENTS {
        return None;
    }
    let (constant, constant_all) = (law.constant(&train), law.constant(&all));
    let (fit, fit_all) = (law.fit(&train, &constant), law.fit(&all, &constant_all));
    let scale = scatter(&all, 2, &|v| (law.at)(v, &fit_all.values));
    let gain = if (law.shows)(&fit) {
        (constant.cost - fit.cost) / scale
    } else {
        0.0
    };
    let held_gain = if held.len() < MIN_HELD_OUT_EVENTS {
        cross_validated_gain(bounces, points, scale, &|others, left_out| {
            let constant = law.constant(others);
            let fit = law.fit(others, &constant);
            let left_out = law.with_known(left_out);
            cost(&left_out, &|_| constant.values[0])
                - cost(&left_out, &|v| (law.at)(v, &fit.values))
        })
    } else if (law.shows)(&fit_all) {
        constant.predictive_log_loss(&constant_all, scale)
            - fit.predictive_log_loss(&fit_all, scale)
    } else {
        0.0
    };
    let (best, points) = if needs_both_sides(gain, held_gain, held) {
        (fit_all, all)
    } else {
        (fit, train)
    };
    let after = cost(held, &|v| (law.at)(v, &best.values));
    Some(Comparison {
        gain,
        held_gain,
        held_chi2: after / held.len().max(1) as f64,
        law: best,
        root: scale.sqrt(),
        points,
        proof: proof(gain, held_gain, held),
    })
}

/// Whether a law is determined only by fitted and held-out recordings together: a few bounces
/// determine little by themselves.
fn needs_both_sides(gain: f64, held_gain: f64, held: &[Reading]) -> bool {
    held.len() >= MIN_HELD_OUT_EVENTS && gain <= CONTACT_TRAIN_GAIN && held_gain > 0.0
}

/// Which recordings prove a law.
fn proof(gain: f64, held_gain: f64, held: &[Reading]) -> LawProof {
    if needs_both_sides(gain, held_gain, held) {
        LawProof::WithHeldOut
    } else if held.len() >= MIN_HELD_OUT_EVENTS {
        LawProof::Alone
    } else if held_gain > CONFIRMING_HELD_GAIN {
        LawProof::CrossValidated
    } else {
        LawProof::NotCrossValidated
    }
}

/// Cross-validation, if held-out recordings have too few bounces: fall of chi2 over the fitted
/// recordings, each left out in turn. `gain` is that of the points left out for a law fitted to the
/// others.
fn cross_validated_gain(
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
