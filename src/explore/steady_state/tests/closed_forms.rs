//! Against closed forms: a linear oscillator, and a ball on a moving table.

use std::f64::consts::TAU;

use super::super::*;
use super::{preset, solve, with};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId as P;

/// A ball on a table that moves as `-a/w^2 sin(w t)`, in the table's frame.
fn ball_on_table(restitution: f64, acceleration: f64, hertz: f64) -> Model {
    let mut model = preset("bouncing-ball");
    model.parameters.set(P::Alpha, restitution);
    with(
        &model,
        "base_vibration",
        &[("a", acceleration), ("f", hertz), ("phase", 0.0)],
    )
}

const GRAVITY: f64 = 9.80665;

/// One mode under a square wave: the force is constant over each half, and motion about the place
/// where it would rest is a damped rotation.
#[test]
fn an_oscillator_under_a_square_wave_is_the_closed_form() {
    let mut model = preset("paper");
    model.has_ground = false;
    model.modes.truncate(1);
    for (hertz, zeta) in [(70.0, 0.0262), (311.7, 0.0262), (100.0, 1e-3)] {
        model.parameters.set(P::Zeta1, zeta);
        let response = solve(
            &model,
            &format!("square:{hertz}Hz:7V"),
            SteadyOptions::default(),
        );
        assert_eq!(response.kind, ResponseKind::Periodic { multiple: 1 });
        let mode = model.structure().modes[0];
        let (w, decay) = (mode.omega(), mode.zeta * mode.omega());
        let wd = (w * w - decay * decay).sqrt();
        let piezo = model.piezo.unwrap();
        let rest = |voltage: f64, branch| {
            mode.phi_drive * model.parameters[P::Eta] * piezo.gain(voltage, branch) / (w * w)
        };
        use crate::model::piezo::Branch::{Falling, Rising};
        let (high, low) = (rest(7.0, Rising), rest(-7.0, Falling));
        // (q - rest, v) after half a period.
        let h = 0.5 / hertz;
        let (e, s, c) = ((-decay * h).exp(), (wd * h).sin(), (wd * h).cos());
        let half = nalgebra::Matrix2::new(
            e * (c + decay / wd * s),
            e * s / wd,
            -e * w * w / wd * s,
            e * (c - decay / wd * s),
        );
        let (a, b) = (
            nalgebra::Vector2::new(high, 0.0),
            nalgebra::Vector2::new(low, 0.0),
        );
        // x1 = b + H (a + H (x0 - a) - b), and x1 = x0.
        let identity = nalgebra::Matrix2::identity();
        let right = b + half * (a - half * a - b);
        let x0 = (identity - half * half).try_inverse().unwrap() * right;
        let own = &response.cycle.start.coordinates;
        let size = (high - low).abs();
        let tolerance = 3e-6;
        assert!(
            (own.q[0] - x0[0]).abs() < tolerance * size,
            "{hertz}: {} {}",
            own.q[0],
            x0[0]
        );
        assert!((own.v[0] - x0[1]).abs() < tolerance * size * w, "{hertz}");
        let Stability::Multipliers(all) = &response.stability else {
            panic!("{:?}", response.stability)
        };
        let modulus = (-decay / hertz).exp();
        assert_eq!(all.len(), 2);
        for multiplier in all {
            assert!(
                (multiplier.norm() - modulus).abs() < 1e-5,
                "{multiplier} {modulus}"
            );
            let angle = (multiplier.arg().cos() - (wd / hertz).cos()).abs();
            assert!(angle < 1e-4, "{multiplier}");
        }
        // A transient of thousands of periods is cut short.
        let slow = zeta < 0.01;
        assert!(!slow || response.method == Method::Shooting);
        assert!(!slow || response.periods_followed < 40);
    }
}

/// At the top of the period-1 orbit over a table that passes its middle, in the table's frame:
/// `a sin` and `a cos` are the table's acceleration and `w` times its speed at the impact.
fn top_of_flight(hertz: f64, amplitude: f64, sine: f64) -> Start<'static> {
    let w = TAU * hertz;
    Start::Point {
        displacement: -0.05 + 0.125 * GRAVITY / (hertz * hertz) + amplitude * sine / (w * w),
        velocity: amplitude / w,
        switched_on: 0.0,
    }
}

/// J. Guckenheimer, P. Holmes, J. Sound Vib. 84 (1982) 173, without their approximation of a high
/// bounce: the period-1 orbit meets the table where its speed is `g T (1-r) / (2 (1+r))`, and its
/// multipliers have the product `r^2` and the sum `1 + r^2 - (1+r)^2 a sin(phi) / g`.
#[test]
fn a_ball_on_a_moving_table_has_the_known_orbit_and_multipliers() {
    let (r, hertz) = (0.5, 20.0);
    let w = TAU * hertz;
    let speed = 0.5 * GRAVITY / hertz * (1.0 - r) / (1.0 + r);
    for sine in [0.1, 0.3, 0.5] {
        // The table's velocity is a/w cos, its acceleration -a sin at the impact.
        let amplitude = {
            let cosine = f64::sqrt(1.0 - sine * sine);
            w * speed / cosine
        };
        // The base's acceleration is a sin(w t + phi): the table's own displacement has the
        // opposite sign.
        let model = ball_on_table(r, amplitude, hertz);
        let drive = Waveform::parse(&format!("sine:{hertz}Hz:1V"), 1.0).unwrap();
        let options = SteadyOptions {
            max_periods: 2000,
            ..SteadyOptions::default()
        };
        let mut solver = SteadySolver::new(&model, options).unwrap();
        let start = top_of_flight(hertz, amplitude, sine);
        let response = solver.solve(&drive, start).unwrap();
        assert_eq!(
            response.kind,
            ResponseKind::Periodic { multiple: 1 },
            "{sine}"
        );
        assert_eq!(response.cycle.arrivals.len(), 1, "{sine}");
        // Relative to the table it arrives with g T / (1 + r).
        let arrival = GRAVITY / hertz / (1.0 + r);
        let own = response.cycle.arrivals[0].speed;
        assert!((own / arrival - 1.0).abs() < 1e-5, "{own} {arrival}");
        let Stability::Multipliers(all) = &response.stability else {
            panic!("{:?}", response.stability)
        };
        let sum: f64 = all.iter().map(|m| m.re).sum();
        let product = all[0] * all[1];
        let expected = 1.0 + r * r - (1.0 + r).powi(2) * amplitude * sine / GRAVITY;
        assert!((product.re - r * r).abs() < 1e-4, "{product}");
        assert!(
            (sum - expected).abs() < 1e-3 * (1.0 + expected.abs()),
            "{sine}: {sum} {expected}"
        );
    }
}

/// The same orbit loses its stability where the sum of its multipliers reaches `-(1 + r^2)`: two
/// periods follow.
#[test]
fn a_ball_doubles_its_period_where_it_is_known_to() {
    let (r, hertz) = (0.5, 20.0);
    let w = TAU * hertz;
    // a sin = 2 g (1 + r^2) / (1 + r)^2, a cos = w speed.
    let speed = 0.5 * GRAVITY / hertz * (1.0 - r) / (1.0 + r);
    let limit = f64::hypot(2.0 * GRAVITY * (1.0 + r * r) / (1.0 + r).powi(2), w * speed);
    for (share, multiple) in [(0.98, 1), (1.02, 2)] {
        let model = ball_on_table(r, share * limit, hertz);
        let drive = Waveform::parse(&format!("sine:{hertz}Hz:1V"), 1.0).unwrap();
        let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
        let amplitude = share * limit;
        let sine = f64::sqrt(1.0 - (w * speed / amplitude).powi(2));
        let start = top_of_flight(hertz, amplitude, sine);
        let response = solver.solve(&drive, start).unwrap();
        assert_eq!(
            response.kind,
            ResponseKind::Periodic { multiple },
            "{share}"
        );
        assert_eq!(response.cycle.arrivals.len(), multiple);
        assert!(response.stability.largest_modulus().unwrap() < 1.0);
    }
}

#[test]
fn a_ball_on_a_hard_driven_table_is_chaotic() {
    // At little loss and many g neighbouring flights part (Holmes, J. Sound Vib. 84 (1982) 173).
    let model = ball_on_table(0.85, 8.0 * GRAVITY, 20.0);
    let response = solve(&model, "sine:20Hz:1V", SteadyOptions::default());
    assert!(
        matches!(response.kind, ResponseKind::NotPeriodic(Aperiodicity::Chaotic { exponent }) if exponent > 0.1),
        "{:?}",
        response.kind
    );
    assert_eq!(
        response.cycle.periods,
        SteadyOptions::default().kept_periods
    );
    assert_eq!(response.cycle.strobes.len(), response.cycle.periods);
}
