//! Contact laws from synthetic readings.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::diagnose::contact::decide::tests;
use crate::diagnose::contact::restitution::*;
use crate::diagnose::findings::LawProof;
use crate::fit::contact_readings::ContactReadings;

/// Standard error of the ratios.
const ERROR: f64 = 4e-3;

/// Bounces at speeds of 0.02 to 0.6 m/s that rebound by `law`, and some landings that read as
/// bounces which hardly leave the ground, very well known as it seems.
fn bounces(seed: u64, count: usize, landings: usize, law: &dyn Fn(f64) -> f64) -> ContactReadings {
    let mut dice = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { (0..12).map(|_| dice.random_range(-0.5..0.5)).sum() };
    let mut out = ContactReadings::default();
    for i in 0..count + landings {
        let share = (i % count) as f64 / (count - 1) as f64;
        let approach = 0.02 * 30f64.powf(share);
        let (ratio, error) = if i < count {
            (law(approach) + ERROR * normal(), ERROR)
        } else {
            (1e-3 + 1e-3 * normal().abs(), 3e-3)
        };
        out.bounces.push(Bounce {
            recording: i % 3,
            time: 0.01 * i as f64,
            approach,
            departure: ratio * approach,
            ratio,
            error,
            miss: 0.0,
            miss_error: 1e-7,
            shared: 0.0,
            flight: 50.0,
        });
    }
    out
}

fn restitution_of(train: ContactReadings, held_out: ContactReadings) -> LawTest {
    let ground = Ground {
        train,
        held_out,
        mass: 3.5e-7,
        ..Ground::default()
    };
    let all = tests(&ground);
    let found = all.into_iter().find(|t| t.id == "velocity_restitution");
    found.expect("enough bounces")
}

fn is_proved(test: &LawTest, by: LawProof) -> bool {
    matches!(test.evidence, Evidence::Restitution { proof, .. } if proof == by)
}

#[test]
fn an_implausible_power_is_rejected() {
    let grows = |v: f64| 0.4 * (v / 0.6).powf(0.9);
    let test = restitution_of(bounces(1, 20, 0, &grows), bounces(2, 12, 0, &grows));
    assert!(test.effect.values[0] < -0.8, "{:?}", test.effect);
    assert!(test.gain <= 0.0 && test.held_gain <= 0.0, "{test:?}");
    let law = |v: f64| 0.4 * (v / 0.6).powf(0.45);
    let test = restitution_of(bounces(1, 20, 0, &law), bounces(2, 12, 0, &law));
    assert!(test.gain > 300.0, "{}", test.gain);
}

#[test]
fn restitution_that_depends_on_speed_is_found_despite_landings_and_noise() {
    let falls = |v: f64| 0.4 * (v / 0.1).powf(-0.1);
    let test = restitution_of(bounces(1, 20, 8, &falls), bounces(2, 12, 8, &falls));
    assert!(
        test.gain > 300.0 && test.held_gain > 100.0,
        "{} {}",
        test.gain,
        test.held_gain
    );
    assert!((test.effect.values[0] - 0.1).abs() < 4.0 * test.errors[0]);
}

#[test]
fn constant_restitution_is_accepted_whatever_the_landings() {
    for seed in 10..30 {
        let test = restitution_of(
            bounces(seed, 14, 6, &|_| 0.35),
            bounces(seed + 100, 10, 6, &|_| 0.35),
        );
        let both = test.gain + test.held_gain;
        assert!(both < 12.0, "seed {seed}: {} {}", test.gain, test.held_gain);
    }
}

#[test]
fn landings_are_not_bounces_even_if_they_are_the_majority() {
    // As short stays of slow masses read: they seem to leave the ground by four errors.
    let with = |seed: u64, count: usize, landings: usize, law: &dyn Fn(f64) -> f64| {
        let mut all = bounces(seed, count, landings, law);
        for b in &mut all.bounces[count..] {
            b.approach = 0.02 + 0.1 * b.approach;
            (b.ratio, b.error) = (b.ratio + 0.032, 4e-3);
        }
        all
    };
    let quick = |seed: u64, count: usize, landings: usize| {
        let mut all = with(seed, count, landings, &|_| 0.35);
        for b in &mut all.bounces[..count] {
            b.approach = b.approach.max(0.15);
        }
        all
    };
    let [train, held_out] = [quick(3, 6, 14), quick(4, 5, 6)];
    let used = ratios(&train.bounces, usual([&train.bounces, &held_out.bounces]));
    assert!(
        used.len() == 6 && used.iter().all(|b| b.1 > 0.3),
        "{used:?}"
    );
    let test = restitution_of(train, held_out);
    assert!(test.gain + test.held_gain < 12.0, "{test:?}");
    // Nor are slow bounces landings, which are fewer and less well known than quick ones.
    let falls = |v: f64| 0.3 * (v / 0.6).powf(-0.3);
    let mut both = [with(5, 20, 24, &falls), with(6, 12, 20, &falls)];
    for b in both.iter_mut().flat_map(|r| &mut r.bounces) {
        b.error = b.error.max(5e-4 / b.approach);
    }
    let slowest = both[0].bounces[..20].iter().map(|b| b.approach);
    let slowest = slowest.fold(f64::INFINITY, f64::min);
    let [train, held_out] = both;
    let used = ratios(&train.bounces, usual([&train.bounces, &held_out.bounces]));
    assert!(used.iter().any(|b| b.0 == slowest), "{used:?}");
    let test = restitution_of(train, held_out);
    assert!(
        (test.effect.values[0] - 0.3).abs() < 4.0 * test.errors[0],
        "{test:?}"
    );
}

#[test]
fn misread_bounces_are_not_used() {
    let misread = |how: &dyn Fn(&mut Bounce)| {
        let mut both = [bounces(5, 16, 0, &|_| 0.35), bounces(6, 12, 0, &|_| 0.35)];
        for b in both.iter_mut().flat_map(|r| &mut r.bounces) {
            if b.approach < 0.1 {
                b.ratio = 0.15;
                how(b);
            }
        }
        let [train, held_out] = both;
        restitution_of(train, held_out)
    };
    // The same ratios would be a law, were they read well.
    assert!(misread(&|_| ()).gain > 100.0);
    for test in [
        misread(&|b| b.flight = 3.0),
        misread(&|b| b.miss = 1e-6),
        misread(&|b| b.miss = -1e-6),
    ] {
        assert!(test.gain + test.held_gain < 12.0, "{test:?}");
    }
}

#[test]
fn a_few_bounces_count_together_with_held_out_ones() {
    let falls = |v: f64| 0.4 * (v / 0.1).powf(-0.15);
    let mut train = bounces(5, 20, 0, &falls);
    // Two of nearly one speed.
    train.bounces = train.bounces[9..11].to_vec();
    let test = restitution_of(train, bounces(6, 24, 4, &falls));
    assert!(test.gain < 30.0 && test.held_gain > 100.0, "{test:?}");
    assert!(test.min_predictive_gain.is_some());
    assert!(is_proved(&test, LawProof::WithHeldOut), "{test:?}");
}

#[test]
fn without_held_out_bounces_the_recordings_are_cross_validated() {
    let falls = |v: f64| 0.4 * (v / 0.1).powf(-0.1);
    let test = restitution_of(bounces(7, 20, 4, &falls), ContactReadings::default());
    assert!(test.gain > 300.0 && test.held_gain > 100.0, "{test:?}");
    assert!(is_proved(&test, LawProof::CrossValidated), "{test:?}");
    for seed in 40..60 {
        let none = restitution_of(bounces(seed, 20, 4, &|_| 0.3), ContactReadings::default());
        // Of one number, by chance, in one of a thousand.
        assert!(none.gain < 11.0, "seed {seed}: {none:?}");
        assert!(
            none.min_predictive_gain.is_none(),
            "not to be counted twice"
        );
    }
}
