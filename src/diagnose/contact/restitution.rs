//! Restitution against the speed of approach: a power law against a constant.

use super::bounce_readings::{ratios, usual};
use super::event_readings::Ground;
use super::law_test::{LawTest, cross_validated_gain, needs_both_sides, proof_remark};
use super::robust_curve::{Curve, Reading, cost, curve, scatter};
use crate::diagnose::thresholds::{
    MIN_EVENTS, MIN_HELD_OUT_EVENTS, MIN_SPEED_POWER, POWER_RANGE_MAX_Z, RESTITUTION_MIN_GAIN,
};
use crate::fit::contact_readings::Bounce;
use crate::model::effects::{ActiveEffect, ContactLaw, of_contact_law};
use crate::model::parameter::ParameterId;

/// Tests a restitution that falls or grows with speed against a constant one. `None` if there are
/// too few bounces.
pub(crate) fn restitution(ground: &Ground) -> Option<LawTest> {
    let sides = [&ground.train.bounces[..], &ground.held_out.bounces];
    let usual = usual(sides);
    let usable = |bounces: &[Bounce]| ratios(bounces, usual);
    let [train, held] = sides.map(usable);
    let spec = of_contact_law(ContactLaw::Restitution)?;
    let all = [train.as_slice(), held.as_slice()].concat();
    if train.is_empty() || all.len() < MIN_EVENTS {
        return None;
    }
    let v0 = 0.1;
    let law = |v: f64, p: &[f64]| (p[0] * (v / v0).powf(-p[1])).min(1.0);
    let constant = |points: &[Reading]| curve(points, &[0.4], &|_, p| p[0]);
    let power = |points: &[Reading], level: &Curve| curve(points, &[level.values[0], 0.05], &law);
    let (level, level_all) = (constant(&train), constant(&all));
    let (fit, fit_all) = (power(&train, &level), power(&all, &level_all));
    let scale = scatter(&all, 2, &|v| law(v, &fit_all.values));
    let root = scale.sqrt();
    let gain = (level.cost - fit.cost) / scale;
    let held_gain = if held.len() < MIN_HELD_OUT_EVENTS {
        cross_validated_gain(
            &ground.train.bounces,
            &usable,
            scale,
            &|others, left_out| {
                let level = constant(others);
                let fit = power(others, &level);
                cost(left_out, &|_| level.values[0]) - cost(left_out, &|v| law(v, &fit.values))
            },
        )
    } else {
        level.predictive_log_loss(&level_all, scale) - fit.predictive_log_loss(&fit_all, scale)
    };
    let (best, points) = if needs_both_sides(gain, held_gain, &held) {
        (&fit_all, &all)
    } else {
        (&fit, &train)
    };
    let after = cost(&held, &|v| law(v, &best.values));
    let evidence = format!(
        "{} bounces: restitution varies as the speed to the power {:.3} +- {:.3}{}",
        points.len(),
        -best.values[1],
        best.errors[1] * root,
        proof_remark(gain, held_gain, &held)
    );
    let (size, error) = (best.values[1].abs(), best.errors[1] * root);
    let (_, most) = spec.parameters[0].range;
    let is_law = size >= MIN_SPEED_POWER && size - POWER_RANGE_MAX_Z * error <= most;
    let (gain, held_gain) = if !is_law {
        (gain.min(0.0), held_gain.min(0.0))
    } else {
        (gain, held_gain)
    };
    Some(LawTest {
        id: spec.id,
        gain,
        held_gain,
        // Cross-validation within the fitted recordings adds no evidence to their own gain.
        min_predictive_gain: (held.len() >= MIN_HELD_OUT_EVENTS).then_some(RESTITUTION_MIN_GAIN),
        held_chi2: after / held.len().max(1) as f64,
        effect: ActiveEffect {
            spec,
            values: vec![best.values[1], v0],
        },
        errors: vec![best.errors[1] * root, f64::INFINITY],
        sets: vec![(ParameterId::Alpha, best.values[0].clamp(0.0, 1.0))],
        evidence,
    })
}

#[cfg(test)]
#[path = "law_tests.rs"]
mod laws_tests;
