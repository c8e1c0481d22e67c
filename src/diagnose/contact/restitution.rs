//! Laws of the ground fitted to the events as read: restitution against speed, pull-off
//! force against contact time, time between touch and rebound.

use super::bounce_readings::{ratios, usual};
use super::event_readings::Ground;
use super::law_test::{LawTest, in_turn, proved, together};
use super::robust_curve::{Curve, Reading, cost, curve, scatter};
use crate::diagnose::thresholds::{
    MIN_EVENTS, MIN_HELD_OUT_EVENTS, MIN_SPEED_POWER, POWER_RANGE_MAX_Z, RESTITUTION_MIN_GAIN,
};
use crate::fit::contact_readings::Bounce;
use crate::model::effects::{ActiveEffect, find};
use crate::model::parameter::ParameterId;

/// What is said where the recordings kept out have too few bounces.
pub(crate) const IN_TURN: &str = ", as each of the recordings shows when it is left out in turn";
/// What is said where the fitted recordings by themselves tell nothing.
pub(crate) const ALSO_HELD_OUT: &str = ", as only those of the recordings kept out tell";

/// Restitution that falls or grows with speed, against a constant one.
pub(crate) fn restitution(ground: &Ground) -> Option<LawTest> {
    let sides = [&ground.train.bounces[..], &ground.held_out.bounces];
    let usual = usual(sides);
    let telling = |bounces: &[Bounce]| ratios(bounces, usual);
    let [train, held] = sides.map(telling);
    let spec = find("velocity_restitution")?;
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
        in_turn(
            &ground.train.bounces,
            &telling,
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
    let (told, points) = if together(gain, held_gain, &held) {
        (&fit_all, &all)
    } else {
        (&fit, &train)
    };
    let after = cost(&held, &|v| law(v, &told.values));
    let evidence = format!(
        "{} bounces: restitution goes as speed to the power {:.3} +- {:.3}{}",
        points.len(),
        -told.values[1],
        told.errors[1] * root,
        proved(gain, held_gain, &held)
    );
    let (size, error) = (told.values[1].abs(), told.errors[1] * root);
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
        // Recordings left out in turn are no evidence beside the same recordings.
        foreseen: (held.len() >= MIN_HELD_OUT_EVENTS).then_some(RESTITUTION_MIN_GAIN),
        held_chi2: after / held.len().max(1) as f64,
        effect: ActiveEffect {
            spec,
            values: vec![told.values[1], v0],
        },
        errors: vec![told.errors[1] * root, f64::INFINITY],
        sets: vec![(ParameterId::Alpha, told.values[0].clamp(0.0, 1.0))],
        evidence,
    })
}

#[cfg(test)]
#[path = "law_tests.rs"]
mod laws_tests;
