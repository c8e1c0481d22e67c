//! Motions with a formula, to 1e-9 of their size.

use std::f64::consts::TAU;

use impactscope::model::drive::Waveform;
use impactscope::model::effects::ActiveEffect;
use impactscope::model::preset::Preset;
use impactscope::model::structure::Mode;
use impactscope::model::{Model, effects};
use impactscope::sim::{Options, Trace, simulate};

fn preset(name: &str) -> Model {
    Preset::embedded(name).unwrap().model
}

fn options(rate: f64, tolerance: f64) -> Options {
    Options {
        rate,
        tolerance,
        ..Options::default()
    }
}

/// Largest difference of a channel from a formula, as a share of `size`.
fn worst(trace: &Trace, channel: &[f64], size: f64, formula: impl Fn(f64) -> f64) -> f64 {
    assert_eq!(channel.len(), trace.len());
    assert!(trace.len() > 100, "only {} samples", trace.len());
    let difference = |(i, x): (usize, &f64)| (x - formula(trace.time(i))).abs() / size;
    let errors = channel.iter().enumerate().map(difference);
    errors.fold(0.0, |m, e| {
        assert!(e.is_finite());
        f64::max(m, e)
    })
}

/// Free motion of `x'' + 2 zeta w x' + w^2 x = 0` from `(x0, v0)`: position and velocity.
fn free(omega: f64, zeta: f64, x0: f64, v0: f64, t: f64) -> (f64, f64) {
    let decay = zeta * omega;
    let slope = v0 + decay * x0;
    if zeta < 1.0 {
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let (sin, cos) = (damped * t).sin_cos();
        let e = (-decay * t).exp();
        let x = e * (x0 * cos + slope / damped * sin);
        let v = e * (slope * cos - x0 * damped * sin) - decay * x;
        (x, v)
    } else if zeta == 1.0 {
        let e = (-decay * t).exp();
        (e * (x0 + slope * t), e * (v0 - decay * slope * t))
    } else {
        // Two real rates; the slow one as a quotient, free of cancellation.
        let fast = decay + omega * (zeta * zeta - 1.0).sqrt();
        let slow = omega * omega / fast;
        let a = (v0 + fast * x0) / (fast - slow);
        let b = x0 - a;
        let (ea, eb) = ((-slow * t).exp(), (-fast * t).exp());
        (a * ea + b * eb, -slow * a * ea - fast * b * eb)
    }
}

#[test]
fn oscillator_rings_down() {
    for zeta in [0.0, 0.002, 0.3, 0.999, 1.0, 1.001, 3.0, 20.0] {
        let mut model = preset("oscillator");
        let (x0, v0) = (0.1, -0.7);
        for (id, value) in [("zeta1", zeta), ("x0", x0), ("v0", v0)] {
            model.set(id, value).unwrap();
        }
        let omega = (14.92_f64 / 0.2016).sqrt();
        let options = options(100.0, 1e-14);
        let trace = simulate(&model, &Waveform::Rest, 30.0, &options).unwrap();
        assert_eq!(trace.len(), 3001);
        let size = f64::max(x0, -v0 / omega);
        let x = worst(&trace, &trace.proof_mass, size, |t| {
            free(omega, zeta, x0, v0, t).0
        });
        let v = worst(&trace, &trace.proof_mass_velocity, size * omega, |t| {
            free(omega, zeta, x0, v0, t).1
        });
        println!(
            "ring-down, zeta {zeta}: x {x:.1e}, v {v:.1e}, {} steps",
            trace.steps
        );
        assert!(x < 1e-9 && v < 1e-9, "zeta {zeta}: {x}, {v}");
    }
}

#[test]
fn offset_and_gravity_only_move_the_zero_of_an_oscillator() {
    let mut model = preset("oscillator");
    let gravity = effects::find("gravity").unwrap();
    model.effects.push(ActiveEffect::new(gravity));
    for (id, value) in [
        ("zeta1", 0.01),
        ("x0", 0.0),
        ("offset_p", 0.05),
        ("gravity.g", 9.8),
    ] {
        model.set(id, value).unwrap();
    }
    let omega = (14.92_f64 / 0.2016).sqrt();
    let sag = 9.8 / (omega * omega);
    let trace = simulate(&model, &Waveform::Rest, 20.0, &options(100.0, 1e-14)).unwrap();
    let x = worst(&trace, &trace.proof_mass, sag, |t| {
        0.05 - sag + free(omega, 0.01, sag, 0.0, t).0
    });
    println!("gravity on a spring: {x:.1e}");
    assert!(x < 1e-9, "{x}");
}

/// The paper's device with further modes, ground and film out of reach.
fn far_device(third: Option<Mode>) -> Model {
    let mut model = preset("paper");
    model.set("dp", 1e3).unwrap();
    model.set("gp", 1e6).unwrap();
    model.modes.extend(third);
    model
}

fn third_mode() -> Mode {
    Mode {
        frequency: 19175.0,
        zeta: 0.025,
        phi_c: 63144.79,
        phi_p: 2944.80,
        phi_drive: 63144.79,
    }
}

/// `(omega, zeta, phi_c, phi_p)` of the modes, from the model page.
fn modes(count: usize) -> Vec<(f64, f64, f64, f64)> {
    let all = [
        (TAU * 623.0, 0.0262, 13381.005, 50145.332),
        (TAU * 6424.0, 0.0257, 74486.762, -12923.177),
        (TAU * 19175.0, 0.025, 63144.79, 2944.80),
    ];
    all[..count].to_vec()
}

#[test]
fn constant_force_is_answered_by_all_modes() {
    for (count, third) in [(2, None), (3, Some(third_mode()))] {
        let model = far_device(third);
        // The first half period of a slow square, risen to +8 V at t = 0.
        let drive = Waveform::Square {
            frequency: 5.0,
            amplitude: 8.0,
        };
        let v: f64 = 8.0;
        let gain = 0.0016 * v.powi(3) - 0.0255 * v.powi(2) - 0.7057 * v + 1.4796;
        let force = 3.819e-7 * gain;
        let trace = simulate(&model, &drive, 0.1, &options(50e3, 1e-16)).unwrap();
        let response = |t: f64, proof: bool| -> f64 {
            let mode = |&(omega, zeta, c, p): &(f64, f64, f64, f64)| {
                let rest = c * force / (omega * omega);
                let q = rest + free(omega, zeta, -rest, 0.0, t).0;
                if proof { p * q } else { c * q }
            };
            modes(count).iter().map(mode).sum()
        };
        // Sample 5000 lies on the edge of the drive; motion is continuous there.
        let size = response(0.1, true).abs();
        let xp = worst(&trace, &trace.proof_mass, size, |t| response(t, true));
        let xc = worst(&trace, &trace.cantilever, size, |t| response(t, false));
        println!(
            "step response, {count} modes: xp {xp:.1e}, xc {xc:.1e}, {} steps",
            trace.steps
        );
        assert!(xp < 1e-9 && xc < 1e-9, "{count} modes: {xp}, {xc}");
    }
}

#[test]
fn three_modes_superpose() {
    let mut model = far_device(Some(third_mode()));
    let (x0, v0) = (20e-6, 0.05);
    model.set("x0", x0).unwrap();
    model.set("v0", v0).unwrap();
    let trace = simulate(&model, &Waveform::Rest, 0.02, &options(200e3, 1e-16)).unwrap();
    // Bent as by a force on the proof mass: q ~ phi_p / w^2; struck there: q' ~ phi_p.
    let table = modes(3);
    let compliance: f64 = table.iter().map(|(w, _, _, p)| p * p / (w * w)).sum();
    let mobility: f64 = table.iter().map(|(_, _, _, p)| p * p).sum();
    let motion = |t: f64, proof: bool, velocity: bool| -> f64 {
        let mode = |&(omega, zeta, c, p): &(f64, f64, f64, f64)| {
            let q0 = x0 * p / (omega * omega) / compliance;
            let (q, u) = free(omega, zeta, q0, v0 * p / mobility, t);
            let shape = if proof { p } else { c };
            shape * if velocity { u } else { q }
        };
        table.iter().map(mode).sum()
    };
    assert!((motion(0.0, true, false) - x0).abs() < 1e-18);
    assert!((motion(0.0, true, true) - v0).abs() < 1e-15);
    let speed = x0 * TAU * 623.0;
    for (name, channel, size, proof, velocity) in [
        ("xp", &trace.proof_mass, x0, true, false),
        ("xc", &trace.cantilever, x0, false, false),
        ("xp'", &trace.proof_mass_velocity, speed, true, true),
        ("xc'", &trace.cantilever_velocity, speed, false, true),
    ] {
        let error = worst(&trace, channel, size, |t| motion(t, proof, velocity));
        println!("three modes: {name} {error:.1e}");
        assert!(error < 1e-9, "{name}: {error}");
    }
}

#[test]
fn free_fall() {
    let mut model = preset("faller");
    model.set("v0", 12.0).unwrap();
    let trace = simulate(&model, &Waveform::Rest, 3.0, &options(1e3, 1e-12)).unwrap();
    let x = worst(&trace, &trace.proof_mass, 47.0, |t| {
        47.0 + 12.0 * t - 0.5 * 9.80665 * t * t
    });
    let v = worst(&trace, &trace.proof_mass_velocity, 12.0, |t| {
        12.0 - 9.80665 * t
    });
    println!("free fall: x {x:.1e}, v {v:.1e}");
    assert!(x < 1e-9 && v < 1e-9, "{x}, {v}");
}

#[test]
fn fall_with_quadratic_drag() {
    let (mass, g, terminal) = (0.0566, 9.80665, 9.0);
    let faller = |v0: f64| {
        let mut model = preset("faller");
        let drag = effects::find("quadratic_drag").unwrap();
        model.effects.push(ActiveEffect::new(drag));
        model
            .set("quadratic_drag.cd", mass * g / (terminal * terminal))
            .unwrap();
        model.set("v0", v0).unwrap();
        model
    };
    let length = terminal * terminal / g;
    let trace = simulate(&faller(0.0), &Waveform::Rest, 4.0, &options(1e3, 1e-12)).unwrap();
    let x = worst(&trace, &trace.proof_mass, 47.0, |t| {
        47.0 - length * (g * t / terminal).cosh().ln()
    });
    let v = worst(&trace, &trace.proof_mass_velocity, terminal, |t| {
        -terminal * (g * t / terminal).tanh()
    });
    println!("drag from rest: x {x:.1e}, v {v:.1e}");
    assert!(x < 1e-9 && v < 1e-9, "{x}, {v}");

    // Thrown upwards: a tangent until the top, then the fall from there. The force has
    // a kink in its second derivative at the top.
    let v0 = 15.0;
    let angle = f64::atan(v0 / terminal);
    let top = angle * terminal / g;
    let rise = |t: f64| length * ((angle - g * t / terminal).cos() / angle.cos()).ln();
    let trace = simulate(&faller(v0), &Waveform::Rest, 3.0, &options(1e3, 1e-12)).unwrap();
    let x = worst(&trace, &trace.proof_mass, 47.0, |t| {
        47.0 + if t < top {
            rise(t)
        } else {
            rise(top) - length * (g * (t - top) / terminal).cosh().ln()
        }
    });
    println!("drag, thrown up: x {x:.1e}");
    assert!(x < 1e-9, "{x}");
}
