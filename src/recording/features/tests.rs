use std::f64::consts::TAU;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::model::sensor::gaussian;
use crate::recording::features::*;

const RATE: f64 = 50e3;
const LEVEL: f64 = -58e-6;
const AXIS: TimeAxis = TimeAxis::Uniform {
    t0: 0.0,
    dt: 1.0 / RATE,
};

/// A periodic motion in closed form, shaped like the device under a 50 Hz square of
/// 8 V: the mass falls at the rise, bounces twice, rests until 0.6 ms after the fall
/// of the voltage, then springs up, rings and settles at 77 um.
struct Device {
    v: Vec<f64>,
    x: Vec<f64>,
    contact: f64,
    peak: f64,
}

const G: f64 = 1000.0;
const RELEASE: f64 = 0.0106;

fn device(periods: usize, restitution: f64) -> Device {
    let fall = (2.0f64 * 135e-6 / G).sqrt();
    let speed = G * fall;
    let hop_1 = 2.0 * restitution * speed / G;
    let hop_2 = 2.0 * restitution.powi(2) * speed / G;
    let rest = fall + hop_1 + hop_2;
    let up = |s: f64| LEVEL + 135e-6 * (1.0 - (-s / 2.5e-3).exp() * (TAU * 300.0 * s).cos());
    let at = |s: f64| {
        let hop = |s: f64, length: f64| LEVEL + 0.5 * G * s * (length - s);
        if s < fall {
            77e-6 - 0.5 * G * s * s
        } else if s < fall + hop_1 {
            hop(s - fall, hop_1)
        } else if s < rest {
            hop(s - fall - hop_1, hop_2)
        } else if s < RELEASE {
            LEVEL
        } else {
            up(s - RELEASE)
        }
    };
    let n = (0.02 * RATE) as usize * periods + 1;
    let phase = |i: usize| (i as f64 / RATE / 0.02 + 1e-9).fract() * 0.02;
    let v = (0..n)
        .map(|i| if phase(i) < 0.01 - 1e-9 { 8.0 } else { -8.0 })
        .collect();
    let x: Vec<f64> = (0..n).map(|i| at(phase(i))).collect();
    let peak = (0..10_000)
        .map(|i| up(f64::from(i) * 1e-6))
        .fold(f64::NEG_INFINITY, f64::max)
        - LEVEL;
    Device {
        v,
        x,
        contact: RELEASE - rest,
        peak,
    }
}

fn check(d: &Device, found: &Features) {
    let steady = found
        .steady
        .as_ref()
        .unwrap_or_else(|e| panic!("{e}: {found:?}"));
    assert!(
        (found.contact_level.clone().unwrap() - LEVEL).abs() < 1e-7,
        "{:?}",
        found.contact_level
    );
    assert!((found.period.clone().unwrap() - 0.02).abs() < 1e-5);
    assert_eq!(steady.bounces.unwrap().mean, 2.0);
    let contact = steady.contact_duration.unwrap().mean;
    assert!(
        (contact - d.contact).abs() < 6e-5,
        "{contact} {}",
        d.contact
    );
    let peak = steady.peak_amplitude.unwrap().mean;
    assert!((peak / d.peak - 1.0).abs() < 0.005, "{peak} {}", d.peak);
}

#[test]
fn features_of_a_known_motion() {
    let d = device(8, 0.5);
    let given = FeatureOptions {
        contact_level: Some(LEVEL),
        ..FeatureOptions::default()
    };
    check(&d, &features(AXIS, Some(&d.v), &d.x, &given));
    check(
        &d,
        &features(AXIS, Some(&d.v), &d.x, &FeatureOptions::default()),
    );
}

#[test]
fn noise_gaps_and_uneven_sampling_change_little() {
    for (seed, sigma) in [(1, 5e-9), (2, 20e-9), (3, 200e-9)] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut d = device(10, 0.5);
        d.x.iter_mut()
            .for_each(|x| *x += sigma * gaussian(&mut rng));
        d.v.iter_mut().for_each(|v| *v += 0.01 * gaussian(&mut rng));
        d.x[4321] = f64::NAN;
        check(
            &d,
            &features(AXIS, Some(&d.v), &d.x, &FeatureOptions::default()),
        );
    }
    let d = device(10, 0.5);
    let keep = |i: &usize| !i.is_multiple_of(7) && !(5200..5300).contains(i);
    let pick = |values: &[f64]| -> Vec<f64> {
        (0..values.len()).filter(keep).map(|i| values[i]).collect()
    };
    let time: Vec<f64> = (0..d.x.len())
        .filter(keep)
        .map(|i| i as f64 / RATE)
        .collect();
    let (v, x) = (pick(&d.v), pick(&d.x));
    check(
        &d,
        &features(
            TimeAxis::Samples(&time),
            Some(&v),
            &x,
            &FeatureOptions::default(),
        ),
    );
}

#[test]
fn impacts_are_listed_with_their_speeds() {
    let d = device(4, 0.5);
    let found = features(AXIS, Some(&d.v), &d.x, &FeatureOptions::default());
    let speed = (2.0f64 * 135e-6 * G).sqrt();
    let first: Vec<f64> = found
        .events
        .impacts
        .iter()
        .map(|i| i.v_before / speed)
        .collect();
    assert!(first.len() >= 12, "{first:?}");
    for (k, expected) in [-1.0, -0.5, -0.5 * 0.5].into_iter().enumerate() {
        assert!((first[k] - expected).abs() < 0.03, "{first:?}");
    }
}

#[test]
fn the_start_up_does_not_count_in_the_mean() {
    let mut d = device(8, 0.5);
    // The first two periods swing less.
    d.x[..2000]
        .iter_mut()
        .filter(|x| **x > LEVEL)
        .for_each(|x| *x = LEVEL + 0.7 * (*x - LEVEL));
    let found = features(AXIS, Some(&d.v), &d.x, &FeatureOptions::default());
    assert_eq!(found.steady.as_ref().unwrap().first, 2);
    check(&d, &found);
}

#[test]
fn without_contact_the_level_is_not_invented() {
    // A settled ring that touches nothing, and a slow turning point.
    let n = 8000;
    let v: Vec<f64> = (0..n)
        .map(|i| if (i / 500) % 2 == 0 { 6.0 } else { -6.0 })
        .collect();
    let ring: Vec<f64> = (0..n)
        .map(|i| {
            let s = (i % 500) as f64 / RATE;
            let sign = if (i / 500) % 2 == 0 { 1.0 } else { -1.0 };
            50e-6 * sign * (2.0 * (-s / 1e-3).exp() * (TAU * 623.0 * s).cos() - 1.0)
        })
        .collect();
    let found = features(AXIS, Some(&v), &ring, &FeatureOptions::default());
    assert!(
        matches!(found.contact_level, Err(Missing::NotAFloor { .. })),
        "{:?}",
        found.contact_level
    );
    let steady = found.steady.unwrap();
    assert!(
        steady.peak_amplitude.is_some()
            && steady.contact_duration.is_none()
            && steady.bounces.is_none()
    );

    let slow: Vec<f64> = (0..n)
        .map(|i| 60e-6 * (TAU * 20.0 * i as f64 / RATE).sin())
        .collect();
    let drive: Vec<f64> = slow.iter().map(|x| -1e5 * x).collect();
    let found = features(AXIS, Some(&drive), &slow, &FeatureOptions::default());
    assert_eq!(found.contact_level, Err(Missing::NoRest));

    // An overdamped settling has no sudden stop.
    let settle: Vec<f64> = (0..n)
        .map(|i| {
            let s = (i % 500) as f64 / RATE;
            let e = (-s / 0.8e-3).exp();
            55e-6
                * if (i / 500) % 2 == 0 {
                    2.0 * e - 1.0
                } else {
                    1.0 - 2.0 * e
                }
        })
        .collect();
    let found = features(AXIS, Some(&v), &settle, &FeatureOptions::default());
    assert!(
        matches!(
            found.contact_level,
            Err(Missing::NoArrival { .. } | Missing::NoRest)
        ),
        "{:?}",
        found.contact_level
    );

    // With the level given, no contact is zero time and no bounces.
    let given = FeatureOptions {
        contact_level: Some(-200e-6),
        ..FeatureOptions::default()
    };
    let steady = features(AXIS, Some(&v), &ring, &given).steady.unwrap();
    assert_eq!(
        (
            steady.contact_duration.unwrap().mean,
            steady.bounces.unwrap().mean
        ),
        (0.0, 0.0)
    );
}

#[test]
fn a_slow_sine_that_rests_on_the_ground_is_seen() {
    let n = 50_000;
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let v: Vec<f64> = (0..n)
        .map(|i| 8.0 * (TAU * 5.0 * i as f64 / RATE).sin())
        .collect();
    let x: Vec<f64> = v
        .iter()
        .map(|v| (-10e-6 * v).max(LEVEL) + 20e-9 * gaussian(&mut rng))
        .collect();
    let found = features(AXIS, Some(&v), &x, &FeatureOptions::default());
    assert!(
        (found.contact_level.clone().unwrap() - LEVEL).abs() < 1e-7,
        "{:?}",
        found.contact_level
    );
    let steady = found.steady.unwrap();
    // |v| > 5.8 V: pi - 2 asin(0.725) of the cycle.
    let expected = (std::f64::consts::PI - 2.0 * 0.725f64.asin()) / TAU / 5.0;
    assert!(
        (steady.contact_duration.unwrap().mean / expected - 1.0).abs() < 0.01,
        "{steady:?}"
    );
    assert_eq!(steady.bounces.unwrap().mean, 0.0);
    assert!((steady.peak_amplitude.unwrap().mean / 138e-6 - 1.0).abs() < 0.005);
}

#[test]
fn reasons_are_honest() {
    let d = device(4, 0.5);
    let none = features(AXIS, None, &d.x, &FeatureOptions::default());
    assert_eq!(none.steady, Err(Missing::NoVoltage));
    assert!(
        none.contact_level.is_ok(),
        "the kinks show the ground without a voltage"
    );
    let clocked = FeatureOptions {
        period: Some(0.02),
        ..FeatureOptions::default()
    };
    let steady = features(AXIS, None, &d.x, &clocked).steady.unwrap();
    assert!((steady.contact_duration.unwrap().mean - d.contact).abs() < 6e-5);

    let n = d.x.len();
    let chirp: Vec<f64> = (0..n)
        .map(|i| (TAU * (50.0 + 5000.0 * i as f64 / RATE) * i as f64 / RATE).sin())
        .collect();
    let found = features(AXIS, Some(&chirp), &d.x, &FeatureOptions::default());
    assert!(
        matches!(found.period, Err(Missing::NotPeriodic { .. })),
        "{:?}",
        found.period
    );
    let found = features(AXIS, Some(&vec![8.0; n]), &d.x, &FeatureOptions::default());
    assert_eq!(found.period, Err(Missing::ConstantVoltage));
    let found = features(
        AXIS,
        Some(&d.v[..1500]),
        &d.x[..1500],
        &FeatureOptions::default(),
    );
    assert!(
        matches!(found.steady, Err(Missing::TooFewPeriods { .. })),
        "{:?}",
        found.steady
    );
    let found = features(AXIS, Some(&[1.0]), &d.x, &FeatureOptions::default());
    assert_eq!(found.steady, Err(Missing::BadInput));
    let found = features(AXIS, None, &[f64::NAN; 200], &FeatureOptions::default());
    assert!(matches!(found.contact_level, Err(Missing::TooShort { .. })));
    let found = features(AXIS, None, &[], &FeatureOptions::default());
    assert!(found.periods.is_empty() && found.steady.is_err());
}

proptest::proptest! {
    #[test]
    fn never_panics(
        rows in proptest::collection::vec((1e-6..1e-4f64, proptest::num::f64::ANY, -1e-4..1e-4f64), 0..200),
        level in proptest::num::f64::ANY, period in proptest::num::f64::ANY,
    ) {
        let mut t = 0.0;
        let time: Vec<f64> = rows.iter().map(|r| { t += r.0; t }).collect();
        let v: Vec<f64> = rows.iter().map(|r| r.1).collect();
        let x: Vec<f64> = rows.iter().map(|r| r.2).collect();
        let axis = TimeAxis::Samples(&time);
        let options = FeatureOptions { contact_level: Some(level), period: Some(period), ..FeatureOptions::default() };
        let _ = features(axis, Some(&v), &x, &options);
        let _ = features(axis, None, &x, &options);
        let _ = features(axis, Some(&x), &v, &FeatureOptions::default());
        let at_ground = FeatureOptions { contact_level: Some(-5e-5), ..FeatureOptions::default() };
        let _ = features(axis, Some(&v), &x, &at_ground);
        let _ = features(axis, Some(&v), &v, &at_ground);
    }
}
