//! Laws of the ground fitted to the events as read: restitution against speed, pull-off
//! force against contact time, time between touch and rebound.

use super::adhesion::{self, line, long_pulls};
use super::bounce_readings::{LEVEL, misses, ratios, usual};
use super::event_readings::Ground;
use super::robust_curve::{Curve, Reading, cost, curve, scatter};
use crate::fit::contact_readings::{Bounce, Readings};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, find};
use crate::model::parameter::ParameterId;

/// Fall of chi2 on the fitted recordings from which they tell a law by themselves.
pub(crate) const TOLD: f64 = 30.0;
/// Fall of chi2 on both sides together from which a ground gives way, which is one law of
/// one number.
const FORESEEN_DWELL: f64 = 50.0;
/// Fewest events for a law.
pub(crate) const LEAST: usize = 6;
/// Time for which the mass may seem to stay below a hard ground's level, as instants are read
/// with a film and a clock that are nearly right \[s\].
const HARD: f64 = 0.6e-6;
/// Fall of chi2 on both sides together from which restitution goes with speed: one law of
/// one number.
const FORESEEN_SPEED: f64 = 50.0;

/// Power of the speed that is none: it changes restitution by less than three hundredths over a
/// decade of speeds, as does a film of slightly other form.
const LEAST_POWER: f64 = 0.013;

/// Standard errors beyond the catalogue's range from which a power is none of a law: events were
/// misread.
const BEYOND: f64 = 3.0;

/// Fewer bounces than this prove nothing.
const FEW: usize = 3;
/// What is said where the recordings kept out have too few bounces.
const IN_TURN: &str = ", as each of the recordings shows when it is left out in turn";
/// What is said where the fitted recordings by themselves tell nothing.
pub(crate) const ALSO_HELD_OUT: &str = ", as only those of the recordings kept out tell";

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

/// Restitution and adhesion as the events tell them, for the baseline: `alpha`, `Ca`,
/// `Ca0`, each where told.
pub fn baseline(model: &Model, readings: &Readings) -> Model {
    let mut model = model.clone();
    let bounces = ratios(&readings.bounces, usual([&readings.bounces, &[]]));
    if bounces.len() >= LEAST {
        let fit = curve(&bounces, &[0.4], &|_, p| p[0]);
        let p = &mut model.parameters;
        p.set(ParameterId::Alpha, fit.values[0].clamp(0.0, 1.0));
    }
    let pulls = long_pulls(&readings.releases);
    if pulls.len() >= LEAST {
        let fit = line(&pulls);
        let p = &mut model.parameters;
        p.set(ParameterId::Ca0, fit.values[0].max(0.0));
        p.set(ParameterId::Ca, fit.values[1].max(0.0));
    }
    model
}

/// All laws of the ground that the model may lack.
pub fn tests(ground: &Ground) -> Vec<LawTest> {
    let all = [
        restitution(ground),
        adhesion::test(ground),
        compliance(ground),
    ];
    let all: Vec<LawTest> = all.into_iter().flatten().collect();
    for t in &all {
        log::debug!(
            "{} gains {:.1}, {:.1} kept out: {}",
            t.id,
            t.gain,
            t.held_gain,
            t.evidence
        );
    }
    all
}

/// Restitution that falls or grows with speed, against a constant one.
fn restitution(ground: &Ground) -> Option<LawTest> {
    let sides = [&ground.train.bounces[..], &ground.held_out.bounces];
    let usual = usual(sides);
    let telling = |bounces: &[Bounce]| ratios(bounces, usual);
    let [train, held] = sides.map(telling);
    let spec = find("velocity_restitution")?;
    let all = [train.as_slice(), held.as_slice()].concat();
    if train.is_empty() || all.len() < LEAST {
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
    let held_gain = if held.len() < FEW {
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
        level.foresees(&level_all, scale) - fit.foresees(&fit_all, scale)
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
    let is_law = size >= LEAST_POWER && size - BEYOND * error <= most;
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
        foreseen: (held.len() >= FEW).then_some(FORESEEN_SPEED),
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

/// Whether the fitted recordings tell a law only together with those kept out: a few bounces
/// tell little by themselves.
fn together(gain: f64, held_gain: f64, held: &[Reading]) -> bool {
    held.len() >= FEW && gain <= TOLD && held_gain > 0.0
}

/// By which recordings a law was proved, to be added to its evidence.
fn proved(gain: f64, held_gain: f64, held: &[Reading]) -> &'static str {
    if together(gain, held_gain, held) {
        ALSO_HELD_OUT
    } else if held.len() < FEW {
        IN_TURN
    } else {
        ""
    }
}

/// Where those kept out have too few bounces: fall of chi2 over the fitted recordings, each
/// left out in turn. `gain` is that of points left out for a law fitted to others.
fn in_turn(
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
        if others.len() < FEW {
            0.0
        } else {
            gain(&others, &left_out)
        }
    };
    (0..count).map(one).sum::<f64>() / scale
}

/// Time between touch and rebound, against none.
fn compliance(ground: &Ground) -> Option<LawTest> {
    let spec = find("compliant_ground")?;
    let (train, held) = (
        misses(&ground.train.bounces),
        misses(&ground.held_out.bounces),
    );
    let all = [train.as_slice(), held.as_slice()].concat();
    if train.is_empty() || all.len() < LEAST {
        return None;
    }
    let law = |v: f64, p: &[f64]| p[0] - p[1] * v;
    // What is known of the level beforehand is one more reading, of a bounce without speed.
    let with_level = |points: &[Reading]| [&[(0.0, 0.0, LEVEL)], points].concat();
    let rigid = |points: &[Reading]| curve(&with_level(points), &[1e-10], &|_, p| p[0]);
    let soft = |points: &[Reading], level: &Curve| {
        curve(&with_level(points), &[level.values[0], 1e-7], &law)
    };
    let (level, level_all) = (rigid(&train), rigid(&all));
    let (fit, fit_all) = (soft(&train, &level), soft(&all, &level_all));
    let scale = scatter(&all, 2, &|v| law(v, &fit_all.values));
    let root = scale.sqrt();
    let gives = |fit: &Curve| fit.values[1] > HARD;
    let gain = if gives(&fit) {
        (level.cost - fit.cost) / scale
    } else {
        0.0
    };
    let held_gain = if held.len() < FEW {
        in_turn(
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
        level.foresees(&level_all, scale) - fit.foresees(&fit_all, scale)
    } else {
        0.0
    };
    let (told, points) = if together(gain, held_gain, &held) {
        (&fit_all, &all)
    } else {
        (&fit, &train)
    };
    let after = cost(&held, &|v| law(v, &told.values));
    let dwell = told.values[1];
    // A mass on a spring of k d^1.5 turns within 3.2 (m^2 / (k^2 v))^(1/5).
    let speed = points.iter().map(|p| p.0).sum::<f64>() / points.len() as f64;
    let mass = ground.mass;
    let stiffness = mass / (dwell / 3.2).max(1e-9).powf(2.5) / speed.max(1e-6).sqrt();
    Some(LawTest {
        id: spec.id,
        gain,
        held_gain,
        // Recordings left out in turn are no evidence beside the same recordings.
        foreseen: (held.len() >= FEW).then_some(FORESEEN_DWELL),
        held_chi2: after / held.len().max(1) as f64,
        effect: ActiveEffect {
            spec,
            values: vec![stiffness.clamp(1e-9, 1e15), spec.parameters[1].default],
        },
        errors: vec![
            2.5 * stiffness * told.errors[1] * root / dwell.abs().max(1e-12),
            f64::INFINITY,
        ],
        sets: Vec::new(),
        evidence: format!(
            "{} bounces: the mass stays below the ground's level for {:.2} +- {:.2} us{}",
            points.len(),
            1e6 * dwell,
            1e6 * told.errors[1] * root,
            proved(gain, held_gain, &held)
        ),
    })
}

/// Where the events say that a named law of the ground is missed.
pub fn mismatches(
    named: &[LawTest],
    ground: &Ground,
    baseline: &crate::diagnose::selection::forward::Stand,
) -> Vec<crate::diagnose::diagnosis::Mismatch> {
    use crate::diagnose::diagnosis::{Mismatch, Regime};
    /// An event's surroundings \[s\].
    const AROUND: f64 = 1e-4;
    let data = &baseline.train.problem.data;
    let mut out = Vec::new();
    for test in named {
        let at: Vec<(usize, f64, Regime)> = if test.id == "adhesion_saturation" {
            let releases = ground.train.releases.iter();
            releases
                .map(|r| (r.recording, r.time, Regime::Release))
                .collect()
        } else {
            let bounces = ground.train.bounces.iter();
            bounces
                .map(|b| (b.recording, b.time, Regime::Impact))
                .collect()
        };
        let share = 1.0 / at.len().max(1) as f64;
        for (recording, time, regime) in at.into_iter().take(20) {
            out.push(Mismatch {
                recording: data[recording].recording.name.clone(),
                start: time - AROUND,
                end: time + AROUND,
                channel: "xp",
                regime,
                share,
            });
        }
    }
    out
}

#[cfg(test)]
#[path = "law_tests.rs"]
mod laws_tests;
