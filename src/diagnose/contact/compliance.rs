//! Time between touch and rebound: a compliant ground against a rigid one.

use super::bounce_readings::{LEVEL_ERROR, misses};
use super::event_readings::Ground;
use super::law_test::{LawTest, cross_validated_gain, needs_both_sides, proof_remark};
use super::robust_curve::{Curve, Reading, cost, curve, scatter};
use crate::diagnose::thresholds::{
    COMPLIANCE_MIN_GAIN, MIN_EVENTS, MIN_HELD_OUT_EVENTS, RIGID_DWELL,
};
use crate::model::effects::{ActiveEffect, ContactLaw, of_contact_law};

/// Tests a time between touch and rebound against none. `None` if there are too few bounces.
pub(crate) fn compliance(ground: &Ground) -> Option<LawTest> {
    let spec = of_contact_law(ContactLaw::Compliance)?;
    let (train, held) = (
        misses(&ground.train.bounces),
        misses(&ground.held_out.bounces),
    );
    let all = [train.as_slice(), held.as_slice()].concat();
    if train.is_empty() || all.len() < MIN_EVENTS {
        return None;
    }
    let law = |v: f64, p: &[f64]| p[0] - p[1] * v;
    // The prior of the level is one more reading, of a bounce without speed.
    let with_level = |points: &[Reading]| [&[(0.0, 0.0, LEVEL_ERROR)], points].concat();
    let rigid = |points: &[Reading]| curve(&with_level(points), &[1e-10], &|_, p| p[0]);
    let soft = |points: &[Reading], level: &Curve| {
        curve(&with_level(points), &[level.values[0], 1e-7], &law)
    };
    let (level, level_all) = (rigid(&train), rigid(&all));
    let (fit, fit_all) = (soft(&train, &level), soft(&all, &level_all));
    let scale = scatter(&all, 2, &|v| law(v, &fit_all.values));
    let root = scale.sqrt();
    let gives = |fit: &Curve| fit.values[1] > RIGID_DWELL;
    let gain = if gives(&fit) {
        (level.cost - fit.cost) / scale
    } else {
        0.0
    };
    let held_gain = if held.len() < MIN_HELD_OUT_EVENTS {
        cross_validated_gain(
            &ground.train.bounces,
            &misses,
            scale,
            &|others, left_out| {
                let level = rigid(others);
                let fit = soft(others, &level);
                let left_out = with_level(left_out);
                cost(&left_out, &|_| level.values[0]) - cost(&left_out, &|v| law(v, &fit.values))
            },
        )
    } else if gives(&fit_all) {
        level.predictive_log_loss(&level_all, scale) - fit.predictive_log_loss(&fit_all, scale)
    } else {
        0.0
    };
    let (best, points) = if needs_both_sides(gain, held_gain, &held) {
        (&fit_all, &all)
    } else {
        (&fit, &train)
    };
    let after = cost(&held, &|v| law(v, &best.values));
    let dwell = best.values[1];
    // A mass on a spring of k d^1.5 turns within 3.2 (m^2 / (k^2 v))^(1/5).
    let speed = points.iter().map(|p| p.0).sum::<f64>() / points.len() as f64;
    let mass = ground.mass;
    let stiffness = mass / (dwell / 3.2).max(1e-9).powf(2.5) / speed.max(1e-6).sqrt();
    Some(LawTest {
        id: spec.id,
        gain,
        held_gain,
        // Cross-validation within the fitted recordings adds no evidence to their own gain.
        min_predictive_gain: (held.len() >= MIN_HELD_OUT_EVENTS).then_some(COMPLIANCE_MIN_GAIN),
        held_chi2: after / held.len().max(1) as f64,
        effect: ActiveEffect {
            spec,
            values: vec![stiffness.clamp(1e-9, 1e15), spec.parameters[1].default],
        },
        errors: vec![
            2.5 * stiffness * best.errors[1] * root / dwell.abs().max(1e-12),
            f64::INFINITY,
        ],
        sets: Vec::new(),
        evidence: format!(
            "{} bounces: the mass stays below the ground's level for {:.2} +- {:.2} us{}",
            points.len(),
            1e6 * dwell,
            1e6 * best.errors[1] * root,
            proof_remark(gain, held_gain, &held)
        ),
    })
}
