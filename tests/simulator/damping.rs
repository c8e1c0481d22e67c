//! Several dampings together, and frictions that depend on the deflection, against formulas and an
//! integrator of their own.

use std::f64::consts::{PI, TAU};

use impactscope::model::drive::Waveform;
use impactscope::model::effects::{self, ActiveEffect};
use impactscope::model::preset::Preset;
use impactscope::model::{Model, with_effect};
use impactscope::sim::{Options, Trace, simulate};

const MASS: f64 = 0.2016;
const STIFFNESS: f64 = 14.92;
const START: f64 = 0.1;
const RATE: f64 = 2e3;

fn oscillator(zeta: f64, laws: &[(&str, &[(&str, f64)])]) -> Model {
    let mut model = Preset::embedded("oscillator").unwrap().model;
    model.set("zeta1", zeta).unwrap();
    for (id, values) in laws {
        let mut effect = ActiveEffect::new(effects::find(id).unwrap());
        for (parameter, value) in *values {
            assert!(effect.set(parameter, *value), "{id}.{parameter}");
        }
        model = with_effect(&model, effect);
    }
    model
}

fn run(model: &Model, duration: f64) -> Trace {
    let options = Options {
        rate: RATE,
        tolerance: 1e-12,
        ..Options::default()
    };
    simulate(model, &Waveform::Rest, duration, &options).unwrap()
}

/// The sizes of the turning points of a ring, its start included: where the velocity changes sign.
fn turns(trace: &Trace) -> Vec<f64> {
    let (x, v) = (&trace.proof_mass, &trace.proof_mass_velocity);
    let mut all = vec![START];
    for i in 1..trace.len() {
        if v[i - 1] * v[i] < 0.0 {
            // A cubic through both ends turns where its slope is zero; the slopes are nearly a line.
            let s = v[i - 1] / (v[i - 1] - v[i]);
            let h = trace.time(i) - trace.time(i - 1);
            let (a, b) = (x[i - 1], x[i]);
            let (s2, s3) = (s * s, s * s * s);
            all.push(
                (a * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + b * (3.0 * s2 - 2.0 * s3)
                    + h * v[i - 1] * (s3 - 2.0 * s2 + s)
                    + h * v[i] * (s3 - s2))
                    .abs(),
            );
        }
    }
    all
}

/// Motion by small Runge-Kutta steps, the sign of friction taken from the velocity. Steps are cut at
/// turning points, so that no step holds a jump of the force.
fn integrated(force: impl Fn(f64, f64, f64) -> f64, times: usize) -> Vec<f64> {
    const PARTS: usize = 10;
    let h = 1.0 / RATE / PARTS as f64;
    let (mut x, mut v) = (START, 0.0);
    // Released at rest to the right: it slides to the left.
    let mut sliding = -1.0;
    let mut out = vec![x];
    let step = |x: f64, v: f64, sliding: f64, h: f64| {
        let a = |x: f64, v: f64| force(x, v, sliding) / MASS;
        let (k1, l1) = (v, a(x, v));
        let (k2, l2) = (v + 0.5 * h * l1, a(x + 0.5 * h * k1, v + 0.5 * h * l1));
        let (k3, l3) = (v + 0.5 * h * l2, a(x + 0.5 * h * k2, v + 0.5 * h * l2));
        let (k4, l4) = (v + h * l3, a(x + h * k3, v + h * l3));
        (
            x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4),
            v + h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4),
        )
    };
    for _ in 1..times {
        for _ in 0..PARTS {
            let mut left = h;
            let (nx, nv) = step(x, v, sliding, left);
            if nv * sliding < 0.0 {
                // To the turn, and on with the other sign.
                let (mut low, mut high) = (0.0, left);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if step(x, v, sliding, middle).1 * sliding < 0.0 {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                (x, _) = step(x, v, sliding, low);
                v = 0.0;
                left -= low;
                sliding = -sliding;
                (x, v) = step(x, v, sliding, left);
            } else {
                (x, v) = (nx, nv);
            }
        }
        out.push(x);
    }
    out
}

#[test]
fn viscous_quadratic_and_dry_damping_act_together() {
    let (zeta, cd, fc) = (0.004, 0.08, 0.003);
    let model = oscillator(
        zeta,
        &[
            ("quadratic_drag", &[("cd", cd)]),
            ("dry_friction", &[("fc", fc)]),
        ],
    );
    // The mass still swings at the end: it has not stuck.
    let trace = run(&model, 6.0);
    let omega = (STIFFNESS / MASS).sqrt();
    let viscous = 2.0 * zeta * omega * MASS;
    let force = |x: f64, v: f64, sliding: f64| {
        -STIFFNESS * x - viscous * v - cd * v * v.abs() - fc * sliding
    };
    let expected = integrated(force, trace.len());
    for (i, (a, b)) in trace.proof_mass.iter().zip(&expected).enumerate() {
        assert!((a - b).abs() < 1e-8, "{i}: {a} {b}");
    }
    // Each of the three counts.
    for without in [
        oscillator(
            0.0,
            &[
                ("quadratic_drag", &[("cd", cd)]),
                ("dry_friction", &[("fc", fc)]),
            ],
        ),
        oscillator(zeta, &[("dry_friction", &[("fc", fc)])]),
        oscillator(zeta, &[("quadratic_drag", &[("cd", cd)])]),
    ] {
        let other = run(&without, 6.0);
        let pairs = trace.proof_mass.iter().zip(&other.proof_mass);
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart > 1e-3, "{apart}");
    }
}

#[test]
fn friction_in_proportion_to_the_deflection_decays_by_a_ratio() {
    // Inward the spring is softer by `ml`, outward stiffer: A' / A = sqrt((k - ml) / (k + ml)).
    let ml = 0.6;
    let trace = run(&oscillator(0.0, &[("load_friction", &[("ml", ml)])]), 6.0);
    let ratio = ((STIFFNESS - ml) / (STIFFNESS + ml)).sqrt();
    let all = turns(&trace);
    assert!(all.len() > 14, "{}", all.len());
    for (n, size) in all.iter().enumerate() {
        let expected = START * ratio.powi(n as i32);
        assert!(
            (size / expected - 1.0).abs() < 1e-5,
            "{n}: {size} {expected}"
        );
    }
    let inward = ((STIFFNESS - ml) / MASS).sqrt();
    let outward = ((STIFFNESS + ml) / MASS).sqrt();
    let half = 0.5 * PI / inward + 0.5 * PI / outward;
    // After whole half swings the mass is at a turning point.
    let index = (4.0 * half * RATE).round() as usize;
    let off = trace.time(index) - 4.0 * half;
    let there = START * ratio.powi(4);
    let bend = 0.5 * (TAU * 1.5 * off).powi(2);
    assert!((trace.proof_mass[index] / there - 1.0).abs() < bend + 1e-6);
}

#[test]
fn friction_that_falls_with_the_deflection_takes_less_energy_and_is_not_below_zero() {
    // Half a swing from A to A' loses the work of friction: fc (A + A') + mq (A^3 + A'^3) / 3.
    let (fc, mq) = (0.02, -1.2);
    let model = oscillator(
        0.0,
        &[
            ("dry_friction", &[("fc", fc)]),
            ("load_friction", &[("ml", 0.0), ("mq", mq)]),
        ],
    );
    let all = turns(&run(&model, 6.0));
    assert!(all.len() > 10, "{}", all.len());
    for pair in all.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let lost = 0.5 * STIFFNESS * (a * a - b * b);
        let work = fc * (a + b) + mq * (a.powi(3) + b.powi(3)) / 3.0;
        assert!((lost / work - 1.0).abs() < 1e-3, "{pair:?}: {lost} {work}");
    }
    // Alone it would push the mass on: there is none.
    let alone = oscillator(0.0, &[("load_friction", &[("ml", 0.0), ("mq", mq)])]);
    let (alone, none) = (run(&alone, 3.0), run(&oscillator(0.0, &[]), 3.0));
    for (a, b) in alone.proof_mass.iter().zip(&none.proof_mass) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn an_uneven_spring_swings_farther_to_its_soft_side() {
    // k A^2 / 2 + k2 A^3 / 3 is the same at both ends.
    let k2 = 20.0;
    let model = oscillator(0.0, &[("even_stiffness", &[("k2", k2)])]);
    let trace = run(&model, 5.0);
    let lowest = trace.proof_mass.iter().copied().fold(0.0, f64::min);
    let energy = |x: f64| 0.5 * STIFFNESS * x * x + k2 * x.powi(3) / 3.0;
    let off = (energy(lowest) / energy(START) - 1.0).abs();
    assert!(off < 2e-5 && lowest < -START, "{lowest} {off}");
}
