//! The force balance of recordings of known devices.

use std::sync::Arc;

use super::{ForceBalance, force_balance, forces_without, guide};
use crate::diagnose::diagnosis::{Absorbed, BalanceCurve, ForceCurve, Quantity};
use crate::diagnose::options::DiagnoseOptions;
use crate::diagnose::report::ground::law_through;
use crate::diagnose::test_support::{QUIET, parts_of, workspace, workspace_of};
use crate::fit::Part;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, find};
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::model::{Model, with_effect};
use crate::recording::Recording;
use crate::sim::{Options, simulate};

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

/// The oscillator preset with a damping of 0.006 that hardens by `k3` \[N/m^3\].
fn hardening(k3: f64) -> Model {
    use crate::model::parameter::ParameterId as P;
    let mut model = Preset::load("oscillator").unwrap().model;
    model.parameters.set(P::Zeta1, 0.006);
    if k3 != 0.0 {
        let mut effect = ActiveEffect::new(find("cubic_stiffness").unwrap());
        effect.values[0] = k3;
        model = with_effect(&model, effect);
    }
    model
}

/// The balance of two free decays of `truth`, one held out, for the device without `k3`.
fn balance_of_decays(truth: &Model) -> ForceBalance {
    use crate::model::parameter::ParameterId as P;
    let part = |amplitude| {
        let mut model = truth.clone();
        model.parameters.set(P::X0, amplitude);
        let options = Options {
            rate: 100.0,
            ..Options::default()
        };
        let rest = Waveform::parse("rest", 30.0).unwrap();
        let mut trace = simulate(&model, &rest, 30.0, &options).unwrap();
        let sensor = Sensor {
            noise: 3e-4,
            ..Sensor::default()
        };
        sensor.add_noise(&mut trace.proof_mass, (1e3 * amplitude) as u64);
        let time = trace.times();
        let made = Recording::new("decay", time, None, trace.proof_mass, None);
        Part::whole(Arc::new(made.unwrap()))
    };
    let train = [part(0.1), part(0.08)];
    let options = DiagnoseOptions::default();
    force_balance(&hardening(0.0), (&train, &[part(0.09)]), &options, &QUIET)
        .unwrap()
        .unwrap()
}

#[test]
fn a_cubic_force_is_the_curve_over_displacement_less_its_line() {
    let k3 = 60.0;
    let found = balance_of_decays(&hardening(k3));
    let strongest = found.forces.strongest().unwrap();
    assert_eq!(strongest.quantity, Quantity::Displacement);
    assert!(strongest.is_significant, "{:?}", strongest.gain);
    assert!(strongest.absorbed.constant && strongest.absorbed.slope);
    let curve = &strongest.curve;
    let closed = ForceCurve {
        law: curve.at.iter().map(|x| -k3 * x.powi(3)).collect(),
        ..curve.clone()
    };
    let closed = law_through(&closed);
    let far = |law: &[f64], within: f64| {
        let both = curve.force.iter().zip(&curve.std_error).zip(law);
        both.filter(|((f, e), law)| (*f - **law).abs() > within * **e)
            .count()
    };
    let count = curve.at.len();
    assert!(count >= 9, "{count} knots");
    assert!(far(&closed, 3.0) <= 1, "{curve:?}\n{closed:?}");
    // The band neither misses the force nor hides it.
    assert!(far(&closed, 1.0) <= count / 2 + 1);
    assert!(far(&vec![0.0; count], 4.0) >= count / 2, "{curve:?}");
    assert!(far(&curve.law, 3.0) <= 1, "{curve:?}");
    let left = found.forces.after_over(Quantity::Displacement).unwrap();
    assert!(!left.is_significant && left.gain.0 < 0.05 * strongest.gain.0);
}

#[test]
fn nothing_left_out_gives_curves_of_chance() {
    let found = balance_of_decays(&hardening(0.0)).forces;
    assert_eq!(found.before.len(), 2);
    assert!(found.after.is_empty());
    for c in &found.before {
        // Three standard deviations of a chi2 beyond its mean.
        let chance = c.by_chance as f64;
        let most = chance + 3.0 * (2.0 * chance).sqrt();
        assert!(c.gain.0 < most && !c.is_significant, "{c:?}");
        assert!(c.curve.law.is_empty());
        let beyond = c.curve.force.iter().zip(&c.curve.std_error);
        assert!(
            beyond.filter(|(f, e)| f.abs() > 3.0 * **e).count() <= 1,
            "{c:?}"
        );
    }
}

#[test]
fn the_named_effects_of_a_diagnosis_are_the_law_and_leave_nothing() {
    let truth = with("quadratic_drag", &[1e-7]);
    let workspace = workspace_of(&truth, &FITTED, 50e3, 20e-9);
    let named = [truth.effects.last().unwrap().spec];
    let begun = std::time::Instant::now();
    let found = forces_without(&named, &truth, &workspace).unwrap().unwrap();
    println!("{:.2} s", begun.elapsed().as_secs_f64());
    let strongest = found.strongest().unwrap();
    assert_eq!(strongest.quantity, Quantity::Velocity);
    assert!(strongest.is_significant);
    let ForceCurve { force, law, .. } = &strongest.curve;
    let largest = force.iter().fold(0.0f64, |a, f| a.max(f.abs()));
    for (f, law) in force.iter().zip(law) {
        assert!((f - law).abs() < 0.05 * largest, "{:?}", strongest.curve);
    }
    for c in &found.after {
        assert!(c.gain.0 < 0.01 * strongest.gain.0, "{c:?}");
    }
    // The device is driven: there are curves over the voltage and over time, too.
    assert_eq!(found.before.len(), Quantity::ALL.len());
}

#[test]
fn a_free_mass_shows_the_whole_drag() {
    let mut faller = Preset::load("faller").unwrap().model;
    let drag = 0.005;
    let mut effect = ActiveEffect::new(find("quadratic_drag").unwrap());
    effect.values[0] = drag;
    let truth = with_effect(&faller, effect);
    let part = |seed: u64| {
        let options = Options {
            rate: 240.0,
            ..Options::default()
        };
        let rest = Waveform::parse("rest", 1.0).unwrap();
        let mut trace = simulate(&truth, &rest, 1.0, &options).unwrap();
        let sensor = Sensor {
            noise: 1e-3,
            ..Sensor::default()
        };
        sensor.add_noise(&mut trace.proof_mass, seed);
        let time = trace.times();
        let made = Recording::new("fall", time, None, trace.proof_mass, None);
        Part::whole(Arc::new(made.unwrap()))
    };
    faller.effects.retain(|e| e.spec.id != "quadratic_drag");
    let (train, held_out) = ([part(1), part(2)], [part(3)]);
    let options = DiagnoseOptions::default();
    let found = force_balance(&faller, (&train, &held_out), &options, &QUIET);
    let found = found.unwrap().unwrap().forces;
    let over_velocity = |c: &&BalanceCurve| c.quantity == Quantity::Velocity;
    let c = found.before.iter().find(over_velocity).unwrap();
    assert_eq!(c.absorbed, Absorbed::default());
    let points = c.curve.at.iter().zip(&c.curve.force);
    let far = points.zip(&c.curve.std_error);
    let far = far.filter(|((v, f), e)| (*f + drag * *v * v.abs()).abs() > 3.0 * **e);
    assert!(far.count() <= 1, "{c:?}");
}

/// Samples of a hop within a flight.
const HOP_SAMPLES: usize = 12;

#[test]
fn a_hop_that_was_overlooked_does_not_pass_for_a_force() {
    let paper = Preset::embedded("paper").unwrap().model;
    let parts = parts_of(&paper, &FITTED, 50e3, 20e-9);
    let whole = guide(&workspace(&parts), &paper, &|_| true, 2.0).unwrap();
    assert!(whole.rivals.is_empty());
    // A hop of a quarter of a millisecond, at a tenth of a metre per second.
    let kicked = parts.iter().enumerate().map(|(k, part)| {
        let r = &part.recording;
        let mut xp = r.proof_mass.clone();
        if k == 0 {
            let from = xp.len() / 3;
            let interval = r.interval();
            for (i, x) in xp.iter_mut().enumerate().skip(from).take(HOP_SAMPLES) {
                let t = (i - from) as f64 * interval;
                *x += 1e-1 * t * (1.0 - t / (HOP_SAMPLES as f64 * interval));
            }
        }
        let made = Recording::new(
            r.name.clone(),
            r.time.clone(),
            r.voltage.clone(),
            xp,
            r.cantilever.clone(),
        );
        Part::whole(Arc::new(made.unwrap()))
    });
    let kicked: Vec<Part> = kicked.collect();
    let found = guide(&workspace(&kicked), &paper, &|_| true, 2.0).unwrap();
    assert!(found.rivals.is_empty() && !found.scales_differ, "{found:?}");
}
