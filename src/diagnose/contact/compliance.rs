//! Time between touch and rebound: a compliant ground against a rigid one.

use super::bounce_readings::{LEVEL_ERROR, misses};
use super::event_readings::Ground;
use super::law_test::{LawOverSpeed, LawTest, compare};
use crate::diagnose::findings::Evidence;
use crate::diagnose::thresholds::{COMPLIANCE_MIN_GAIN, MIN_HELD_OUT_EVENTS, RIGID_DWELL};
use crate::model::effects::{ActiveEffect, ContactLaw, of_contact_law};

/// The reading of a bounce is its distance below the level: the speed times the time spent there.
const DWELL_LAW: LawOverSpeed = LawOverSpeed {
    // The prior of the level is one more reading, of a bounce without speed.
    known: &[(0.0, 0.0, LEVEL_ERROR)],
    start: [1e-10, 1e-7],
    at: |v, p| p[0] - p[1] * v,
    shows: |fit| fit.values[1] > RIGID_DWELL,
};

/// Tests a time between touch and rebound against none. `None` if there are too few bounces.
pub(crate) fn compliance(ground: &Ground) -> Option<LawTest> {
    let spec = of_contact_law(ContactLaw::Compliance)?;
    let held = misses(&ground.held_out.bounces);
    let found = compare(&DWELL_LAW, &ground.train.bounces, &held, &misses)?;
    let dwell = found.law.values[1];
    let error = found.law.errors[1] * found.root;
    let count = found.points.len();
    // A mass on a spring of k d^1.5 turns within 3.2 (m^2 / (k^2 v))^(1/5).
    let speed = found.points.iter().map(|p| p.0).sum::<f64>() / count as f64;
    let mass = ground.mass;
    let stiffness = mass / (dwell / 3.2).max(1e-9).powf(2.5) / speed.max(1e-6).sqrt();
    Some(LawTest {
        id: spec.id,
        gain: found.gain,
        held_gain: found.held_gain,
        // Cross-validation within the fitted recordings adds no evidence to their own gain.
        min_predictive_gain: (held.len() >= MIN_HELD_OUT_EVENTS).then_some(COMPLIANCE_MIN_GAIN),
        held_chi2: found.held_chi2,
        effect: ActiveEffect {
            spec,
            values: vec![stiffness.clamp(1e-9, 1e15), spec.parameters[1].default],
        },
        errors: vec![
            2.5 * stiffness * found.law.errors[1] * found.root / dwell.abs().max(1e-12),
            f64::INFINITY,
        ],
        sets: Vec::new(),
        evidence: Evidence::Dwell {
            count,
            seconds: dwell,
            error,
            proof: found.proof,
        },
    })
}
