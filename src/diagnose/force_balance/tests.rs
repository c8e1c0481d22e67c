//! The force balance of recordings of known devices.

use std::sync::Arc;

use super::{ForceBalance, force_balance};
use crate::diagnose::options::DiagnoseOptions;
use crate::diagnose::test_support::{QUIET, parts_of};
use crate::fit::Part;
use crate::model::effects::{ActiveEffect, find};
use crate::model::preset::Preset;
use crate::model::{Model, with_effect};
use crate::recording::Recording;

const FITTED: [(&str, f64); 4] = [
    ("square:15Hz:8V", 0.15),
    ("sine:30Hz:7V", 0.15),
    ("ramped:12Hz:8V:0.25", 0.15),
    ("triangle:40Hz:6V", 0.15),
];
const HELD_OUT: [(&str, f64); 2] = [("sine:55Hz:8V", 0.15), ("square:23Hz:6V", 0.15)];

fn paper() -> Model {
    Preset::embedded("paper").unwrap().model
}

/// The balance for the paper's device where `truth` was recorded at `rate` \[1/s\].
fn balance_of(truth: &Model, rate: f64) -> ForceBalance {
    let train = parts_of(truth, &FITTED, rate, 20e-9);
    let held_out = parts_of(truth, &HELD_OUT, rate, 20e-9);
    let options = DiagnoseOptions::default();
    force_balance(&paper(), (&train, &held_out), &options, &QUIET)
        .unwrap()
        .unwrap()
}

fn with(id: &str, values: &[f64]) -> Model {
    let mut effect = ActiveEffect::new(find(id).unwrap());
    effect.values[..values.len()].copy_from_slice(values);
    with_effect(&paper(), effect)
}

#[test]
fn nothing_is_named_where_nothing_is_missing_whatever_the_rate() {
    use crate::model::parameter::ParameterId as P;
    let mut truth = paper();
    let p = &mut truth.parameters;
    for (id, factor) in [(P::Eta, 1.15), (P::F1, 0.98), (P::Zeta1, 1.3), (P::Cs, 0.7)] {
        p.set(id, factor * p[id]);
    }
    for rate in [25e3, 50e3] {
        let found = balance_of(&truth, rate);
        assert!(found.effects.is_empty(), "{rate}: {:?}", found.effects);
        let chi2 = (
            found.before.train_per_row(),
            found.before.held_out_per_row(),
        );
        assert!((0.85..1.15).contains(&chi2.0), "{rate}: {chi2:?}");
        assert!((0.85..1.15).contains(&chi2.1), "{rate}: {chi2:?}");
        let f1 = found.mode.stiffness.sqrt() / std::f64::consts::TAU;
        assert!((f1 / (0.98 * 623.0) - 1.0).abs() < 2e-3, "{rate}: {f1} Hz");
    }
}

#[test]
fn strong_effects_are_found_with_their_parameters() {
    for (id, values, tolerance) in [
        ("quadratic_drag", &[1e-7][..], 0.02),
        ("cubic_stiffness", &[-800.0], 0.05),
        ("piezo_creep", &[0.02, 0.02], 0.1),
    ] {
        let found = balance_of(&with(id, values), 50e3);
        let first = found.effects.first().expect(id);
        assert_eq!(first.effect.spec.id, id, "{:?}", found.effects);
        println!("{id}: {:?}", first.effect.values);
        for (value, truth) in first.effect.values.iter().zip(values) {
            assert!(
                (value / truth - 1.0).abs() < tolerance,
                "{id}: {value} for {truth}"
            );
        }
        assert!(found.after.held_out_per_row() < 0.05 * found.before.held_out_per_row());
    }
}

/// A mass on a spring that dies out in air, `length` times as far and `time` times as slow as 0.1 m at
/// 1.4 Hz, read 100 times a second: linear and quadratic damping, by small steps of its equation.
fn spring(amplitude: f64, (length, time): (f64, f64)) -> Recording {
    let (omega, zeta, drag) = (8.8, 0.002, 0.35);
    let (mut x, mut v, h) = (amplitude, 0.0, 1e-4);
    let (mut times, mut readings) = (Vec::new(), Vec::new());
    let accelerate =
        |x: f64, v: f64| -omega * omega * x - 2.0 * zeta * omega * v - drag * v * f64::abs(v);
    for i in 0..300_000u32 {
        if i.is_multiple_of(100) {
            let k = f64::from(i / 100);
            // A deterministic stand-in for noise of 0.3 mm.
            let noise = 3e-4 * std::f64::consts::SQRT_2 * (1.7 * k * k).sin();
            times.push(time * h * f64::from(i));
            readings.push(length * (x + noise));
        }
        let (a, half) = (accelerate(x, v), 0.5 * h);
        let (xm, vm) = (x + half * v, v + half * a);
        let b = accelerate(xm, vm);
        (x, v) = (x + h * vm, v + h * b);
    }
    Recording::new("spring", times, None, readings, None).unwrap()
}

#[test]
fn drag_on_a_spring_is_found_and_the_same_in_other_units() {
    let found = |units: (f64, f64)| {
        let mut model = Preset::load("oscillator").unwrap().model;
        use crate::model::parameter::ParameterId as P;
        model.parameters.set(P::F1, 1.35 / units.1);
        model.parameters.set(P::Zeta1, 0.003);
        let part = |amplitude| Part::whole(Arc::new(spring(amplitude, units)));
        let options = DiagnoseOptions::default();
        force_balance(&model, (&[part(0.1)], &[part(0.07)]), &options, &QUIET)
            .unwrap()
            .unwrap()
    };
    let (metres, micrometres) = (found((1.0, 1.0)), found((1e-3, 1e-2)));
    for balance in [&metres, &micrometres] {
        let ids: Vec<_> = balance.effects.iter().map(|e| e.effect.spec.id).collect();
        assert_eq!(ids, ["quadratic_drag"]);
    }
    let (a, b) = (metres.after, micrometres.after);
    assert!(
        (a.held_out_per_row() / b.held_out_per_row() - 1.0).abs() < 1e-3,
        "{a:?} {b:?}"
    );
}
