//! Restitution against the speed of approach: a power law against a constant.

use super::bounce_readings::{ratios, usual};
use super::event_readings::Ground;
use super::law_test::{LawOverSpeed, LawTest, compare};
use crate::diagnose::findings::Evidence;
use crate::diagnose::thresholds::{
    MIN_HELD_OUT_EVENTS, MIN_SPEED_POWER, POWER_RANGE_MAX_Z, RESTITUTION_MIN_GAIN,
};
use crate::fit::contact_readings::Bounce;
use crate::model::effects::{ActiveEffect, ContactLaw, of_contact_law};
use crate::model::parameter::ParameterId;

/// Speed at which restitution has its first number \[m/s\].
const REFERENCE_SPEED: f64 = 0.1;

/// Restitution by a power of the speed.
const POWER_LAW: LawOverSpeed = LawOverSpeed {
    known: &[],
    start: [0.4, 0.05],
    at: |v, p| (p[0] * (v / REFERENCE_SPEED).powf(-p[1])).min(1.0),
    shows: |_| true,
};

/// Tests a restitution that falls or grows with speed against a constant one. `None` if there are
/// too few bounces.
pub(crate) fn restitution(ground: &Ground) -> Option<LawTest> {
    let usual = usual([&ground.train.bounces, &ground.held_out.bounces]);
    let usable = |bounces: &[Bounce]| ratios(bounces, usual);
    let spec = of_contact_law(ContactLaw::Restitution)?;
    let held = usable(&ground.held_out.bounces);
    let found = compare(&POWER_LAW, &ground.train.bounces, &held, &usable)?;
    let (at_reference, power) = (found.law.values[0], found.law.values[1]);
    let error = found.law.errors[1] * found.root;
    let (_, most) = spec.parameters[0].range;
    let size = power.abs();
    let is_law = size >= MIN_SPEED_POWER && size - POWER_RANGE_MAX_Z * error <= most;
    let (gain, held_gain) = if is_law {
        (found.gain, found.held_gain)
    } else {
        (found.gain.min(0.0), found.held_gain.min(0.0))
    };
    Some(LawTest {
        id: spec.id,
        gain,
        held_gain,
        // Cross-validation within the fitted recordings adds no evidence to their own gain.
        min_predictive_gain: (held.len() >= MIN_HELD_OUT_EVENTS).then_some(RESTITUTION_MIN_GAIN),
        held_chi2: found.held_chi2,
        effect: ActiveEffect {
            spec,
            values: vec![power, REFERENCE_SPEED],
        },
        errors: vec![error, f64::INFINITY],
        sets: vec![(ParameterId::Alpha, at_reference.clamp(0.0, 1.0))],
        evidence: Evidence::Restitution {
            count: found.points.len(),
            power: -power,
            error,
            proof: found.proof,
        },
    })
}

#[cfg(test)]
#[path = "law_tests.rs"]
mod law_tests;
