//! Tests of oscillators and their propagators against closed forms.

use super::super::linear::*;

fn check(oscillator: Oscillator, h: f64) {
    // A force t^3 has the exact answer of a fine composition of small steps.
    let force = |t: f64| 1.0 + t / h + 5.0 * (t / h).powi(3);
    let whole = Propagator::new(oscillator, h);
    let pieces = 64;
    let small = Propagator::new(oscillator, h / pieces as f64);
    let (mut x, mut v) = (0.3, -0.2 / h);
    let start = (x, v);
    for i in 0..pieces {
        let f = NODES.map(|c| force((i as f64 + c) * h / pieces as f64));
        let e = small.state[S - 2];
        let dot = |w: &[f64; S]| -> f64 { w.iter().zip(&f).map(|(a, b)| a * b).sum() };
        (x, v) = (
            e[0] * x + e[1] * v + dot(&small.displacement[S - 2]),
            e[2] * x + e[3] * v + dot(&small.velocity[S - 2]),
        );
    }
    let f = NODES.map(|c| force(c * h));
    let dot = |w: &[f64; S]| -> f64 { w.iter().zip(&f).map(|(a, b)| a * b).sum() };
    let e = whole.state[S - 2];
    let x1 = e[0] * start.0 + e[1] * start.1 + dot(&whole.displacement[S - 2]);
    let v1 = e[2] * start.0 + e[3] * start.1 + dot(&whole.velocity[S - 2]);
    assert!(
        (x1 - x).abs() < 1e-11 * (1.0 + x.abs()),
        "{oscillator:?}: {x1} {x}"
    );
    assert!(
        (v1 - v).abs() * h < 1e-11 * (1.0 + v.abs() * h),
        "{oscillator:?}: {v1} {v}"
    );
}

#[test]
fn one_step_equals_many() {
    for (omega2, damping) in [
        (1.0, 0.0),
        (9.0, 0.3),
        (3600.0, 0.3),
        (4.0, 4.0),
        (4.0, 4.0 + 1e-9),
        (0.1, 3.0),
        (0.0, 2.0),
        (0.0, 0.0),
        (1e-12, 1.0),
    ] {
        check(Oscillator { omega2, damping }, 1.0);
    }
}

#[test]
fn a_swing_is_exact_within_the_step() {
    // A quartic force on a vibration of three radians, against many small steps.
    let oscillator = Oscillator {
        omega2: 9.0,
        damping: 0.4,
    };
    let force = |t: f64| 1.0 - 2.0 * t + 4.0 * t.powi(4);
    let swing = Swing::new(oscillator, 1.0, 0.3, -0.2, &NODES.map(force));
    assert!(swing.fast);
    let whole = Propagator::new(oscillator, 1.0).swing(0.3, -0.2, &NODES.map(force));
    for (a, b) in whole.particular.iter().zip(swing.particular) {
        assert!((a - b).abs() < 1e-13, "{a} {b}");
    }
    assert!((whole.start.0 - swing.start.0).abs() < 1e-13);
    assert!((whole.start.1 - swing.start.1).abs() < 1e-13);
    let pieces = 64;
    let h = 1.0 / f64::from(pieces);
    let small = Propagator::new(oscillator, h);
    let (mut x, mut v) = (0.3, -0.2);
    for i in 0..pieces {
        let t = f64::from(i) * h;
        let mut dense = super::super::nodes::Dense::default();
        dense.add(1.0, &swing.particular);
        let (free_x, free_v) = swing.free(t);
        let (px, pv) = dense.value_and_slope(t, 1.0);
        assert!((px + free_x - x).abs() < 1e-13, "{t}");
        assert!((pv + free_v - v).abs() < 1e-12, "{t}");
        let f = NODES.map(|c| force(t + c * h));
        let dot = |w: &[f64; S]| -> f64 { w.iter().zip(&f).map(|(a, b)| a * b).sum() };
        let (fx, fv) = apply(&small.state[S - 2], (x, v));
        x = fx + dot(&small.displacement[S - 2]);
        v = fv + dot(&small.velocity[S - 2]);
    }
}

#[test]
fn the_lag_of_free_motion_tends_to_its_closed_form() {
    let oscillator = Oscillator {
        omega2: 9.0,
        damping: 0.4,
    };
    let (rate, start, h) = (2.5, (0.3, -0.7), 1e-3);
    let (per_x, per_v) = oscillator.lagged(rate).unwrap();
    let answer = |t: f64| {
        let (x, v) = apply(&oscillator.free_motion(t), start);
        (x, per_x * x + per_v * v)
    };
    for t in [0.0, 0.4, 2.0] {
        let slope = (answer(t + h).1 - answer(t - h).1) / (2.0 * h);
        let (x, y) = answer(t);
        assert!((slope - rate * (x - y)).abs() < 1e-5, "{t}: {slope}");
    }
    let creeps = Oscillator {
        omega2: 1.0,
        damping: 3.0,
    };
    assert!(creeps.lagged(rate).is_none());
}

#[test]
fn closed_forms() {
    let (x, _) = Oscillator {
        omega2: 0.0,
        damping: 0.0,
    }
    .impulse_response(2.0);
    assert_eq!(x, 2.0);
    let (x, v) = Oscillator {
        omega2: 9.0,
        damping: 0.0,
    }
    .impulse_response(0.7);
    assert!((x - 2.1f64.sin() / 3.0).abs() < 1e-15 && (v - 2.1f64.cos()).abs() < 1e-15);
    let (x, v) = Oscillator {
        omega2: 1.0,
        damping: 2.0,
    }
    .impulse_response(1.5);
    let e = (-1.5f64).exp();
    assert!((x - 1.5 * e).abs() < 1e-15 && (v + 0.5 * e).abs() < 1e-15);
}

#[test]
fn decays_of_any_speed_are_exact() {
    for rate in [0.0, 1e-3, 1.0, 30.0, 1e4, 1e9, 1e300] {
        let p = DecayPropagator::new(rate, 1.0);
        // Constant input 1: z = (1 - exp(-rate)) / rate.
        let sum: f64 = p.input[S - 2].iter().sum();
        let exact = if rate == 0.0 {
            1.0
        } else {
            -(-rate).exp_m1() / rate
        };
        assert!((sum / exact - 1.0).abs() < 1e-12, "{rate}: {sum} {exact}");
    }
    let p = DecayPropagator::new(f64::INFINITY, 1.0);
    assert_eq!((p.input, p.state), ([[0.0; S]; S - 1], [0.0; S - 1]));
}
