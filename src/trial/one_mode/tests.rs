//! One-mode devices against closed forms, and their bound.

use super::apparatus::{Apparatus, OneModeDevice, Reading, Run};
use super::law::OneModeLaw;
use super::law_draws::{self, are_alike};
use super::motion::motion;
use super::size::Bound;
use crate::model::preset::Preset;
use crate::trial::rig::Maker;
use crate::trial::rigs::{RIGS, find};
use crate::trial::rng::TrialRng;
use crate::trial::visibility::JUST_VISIBLE;

/// A device of mass 1 that begins at `x` at rest.
fn apparatus(frequency: f64, zeta: f64, gravity: f64, x: f64, duration: f64) -> Apparatus {
    let device = OneModeDevice {
        mass: 1.0,
        frequency,
        zeta,
        gravity,
    };
    Apparatus {
        name: "test",
        device,
        nominal: device,
        reading: Reading {
            rate: 200.0,
            noise: 1e-4,
            step: 0.0,
            scale: 1.0,
            zero: 0.0,
        },
        runs: vec![Run {
            x,
            v: 0.0,
            duration,
            held_out: false,
        }],
        swings: false,
    }
}

fn follow(apparatus: &Apparatus, law: Option<&OneModeLaw>) -> (Vec<f64>, Vec<f64>) {
    let times = apparatus.times(&apparatus.runs[0]);
    let laws: Vec<&OneModeLaw> = law.into_iter().collect();
    let x = motion(apparatus, &laws, 0, &times).unwrap();
    (times, x)
}

#[test]
fn a_linear_decay_has_its_closed_form() {
    let (f, zeta) = (1.3, 0.01);
    let apparatus = apparatus(f, zeta, 0.0, 0.1, 20.0);
    let (times, x) = follow(&apparatus, None);
    let w = std::f64::consts::TAU * f;
    let wd = w * (1.0f64 - zeta * zeta).sqrt();
    for (t, x) in times.iter().zip(&x) {
        let exact = 0.1 * (-zeta * w * t).exp() * ((wd * t).cos() + zeta * w / wd * (wd * t).sin());
        assert!((x - exact).abs() < 1e-8, "{t}: {x} {exact}");
    }
}

#[test]
fn a_fall_with_drag_has_its_closed_form() {
    let (g, c) = (9.81, 0.05);
    let apparatus = apparatus(0.0, 0.0, g, 40.0, 2.5);
    let (times, x) = follow(&apparatus, Some(&OneModeLaw::QuadraticDrag { c }));
    for (t, x) in times.iter().zip(&x) {
        let exact = 40.0 - ((g * c).sqrt() * t).cosh().ln() / c;
        assert!((x - exact).abs() < 1e-7, "{t}: {x} {exact}");
    }
}

#[test]
fn dry_friction_takes_the_same_from_each_half_turn_and_then_holds() {
    let f = 1.0;
    let a = 0.3;
    let apparatus = apparatus(f, 0.0, 0.0, 0.1, 20.0);
    let (times, x) = follow(&apparatus, Some(&OneModeLaw::DryFriction { a }));
    let held = a / (std::f64::consts::TAU * f).powi(2);
    // Half a period later it turns on the other side, nearer by twice the width of the hold.
    for half_turns in 1..6 {
        let t = 0.5 * f64::from(half_turns) / f;
        let i = (t * apparatus.reading.rate).round() as usize;
        let expected = 0.1 - 2.0 * held * f64::from(half_turns);
        assert!(
            (x[i].abs() - expected).abs() < 1e-8,
            "{half_turns}: {}",
            x[i]
        );
    }
    let last = x[times.len() - 1];
    assert!(last.abs() <= held * (1.0 + 1e-6), "{last} {held}");
    assert!(x[times.len() - 500..].iter().all(|x| *x == last));
}

#[test]
fn friction_by_load_takes_the_same_share_from_each_turn() {
    let f = 1.0;
    let omega = std::f64::consts::TAU * f;
    let share = 0.05;
    let apparatus = apparatus(f, 0.0, 0.0, 0.1, 6.0);
    let m = share * omega * omega;
    let (_, x) = follow(&apparatus, Some(&OneModeLaw::LoadFriction { m }));
    // A quarter turn outward is stiffer by 1 + share, one inward softer by as much; both take their
    // energy: from swing to swing the square falls by (1 - share)/(1 + share).
    let swings: Vec<f64> = (1..x.len() - 1)
        .filter(|&i| x[i] > 0.0 && x[i] >= x[i - 1] && x[i] > x[i + 1])
        .map(|i| x[i])
        .collect();
    assert!(swings.len() >= 4, "{swings:?}");
    for pair in swings.windows(2) {
        let expected = (1.0 - share) / (1.0 + share);
        assert!(
            (pair[1] / pair[0] / expected - 1.0).abs() < 1e-3,
            "{pair:?}"
        );
    }
}

#[test]
fn a_sine_slows_large_swings_as_a_pendulum() {
    let (f, swing) = (0.8, 0.6);
    let apparatus = apparatus(f, 0.0, 0.0, swing, 30.0);
    let omega = apparatus.omega();
    let sine = OneModeLaw::SineStiffness { b: 1.0, omega };
    let (times, x) = follow(&apparatus, Some(&sine));
    // Crossings of zero from above, by straight lines.
    let crossings: Vec<f64> = (1..x.len())
        .filter(|&i| x[i - 1] > 0.0 && x[i] <= 0.0)
        .map(|i| times[i - 1] + (times[i] - times[i - 1]) * x[i - 1] / (x[i - 1] - x[i]))
        .collect();
    let turns = (crossings.len() - 1) as f64;
    let period = (crossings[crossings.len() - 1] - crossings[0]) / turns;
    let s2 = swing * swing;
    let expected = (1.0 + s2 / 16.0 + 11.0 * s2 * s2 / 3072.0 + 173.0 * s2.powi(3) / 737_280.0) / f;
    assert!(
        (period / expected - 1.0).abs() < 2e-5,
        "{period} {expected}"
    );
}

#[test]
fn no_strength_is_no_law() {
    let apparatus = apparatus(1.0, 0.003, 0.0, 0.1, 5.0);
    let (_, plain) = follow(&apparatus, None);
    let ids = RIGS.iter().filter_map(|rig| match rig.maker {
        Maker::OneMode(one) => Some(one.effects.iter().chain(one.outside)),
        _ => None,
    });
    for id in ids.flatten() {
        let (_, law) = law_draws::draw(id, &apparatus, &mut TrialRng::new(3, 0)).unwrap();
        let (_, full) = follow(&apparatus, Some(&law));
        let (_, none) = follow(&apparatus, Some(&law.scaled(1e-12)));
        let worst = |x: &[f64]| {
            let both = x.iter().zip(&plain);
            both.fold(0.0f64, |w, (a, b)| w.max((a - b).abs()))
        };
        assert!(worst(&full) > 1e-4, "{id}: {:e}", worst(&full));
        assert!(worst(&none) < 1e-8, "{id}: {:e}", worst(&none));
    }
}

#[test]
fn what_re_tuning_absorbs_is_no_size_and_a_weak_law_counts_in_proportion() {
    for name in ["spring", "ball", "pendulum"] {
        let Maker::OneMode(one) = find(name).unwrap().maker else {
            panic!("{name}")
        };
        let apparatus = (one.draw)(&mut TrialRng::new(11, 8));
        let bound = Bound::new(&apparatus).unwrap();
        for id in one.effects {
            let (_, law) = law_draws::draw(id, &apparatus, &mut TrialRng::new(2, 0)).unwrap();
            let visible = bound.just_visible(&law).unwrap();
            let at = |factor: f64| bound.deviations(&law.scaled(factor * visible)).unwrap();
            assert!((at(1.0) / JUST_VISIBLE - 1.0).abs() < 0.05, "{name} {id}");
            // What a friction by load has in common with a viscous damping is absorbed; the rest is
            // of second order.
            if *id != "load_friction" {
                assert!((at(0.5) / at(1.0) - 0.5).abs() < 0.05, "{name} {id}");
            }
        }
    }
    // A cubic that is no more than a change of the frequency at one swing: of a decay that does not
    // decay nearly all is absorbed.
    let still = apparatus(1.0, 1e-7, 0.0, 0.1, 10.0);
    let law = OneModeLaw::CubicStiffness { k: 1e-2 };
    let bound = Bound::new(&still).unwrap();
    let (_, with) = follow(&still, Some(&law));
    let (_, without) = follow(&still, None);
    let squares = with
        .iter()
        .zip(&without)
        .map(|(a, b)| ((a - b) / 1e-4).powi(2));
    let all = squares.sum::<f64>().sqrt();
    let left = bound.deviations(&law).unwrap();
    assert!(left < 0.05 * all, "{left} of {all}");
}

#[test]
fn laws_that_are_one_another_are_not_drawn_together() {
    assert!(are_alike("sine_stiffness", "cubic_stiffness"));
    assert!(are_alike("cubic_stiffness", "sine_stiffness"));
    assert!(!are_alike("even_stiffness", "cubic_stiffness"));
}

#[test]
fn presets_can_be_read_and_state_what_was_measured() {
    for name in ["spring", "ball", "pendulum"] {
        let Maker::OneMode(one) = find(name).unwrap().maker else {
            panic!("{name}")
        };
        for seed in 0..20 {
            let apparatus = (one.draw)(&mut TrialRng::new(seed, 8));
            let preset = Preset::parse("test", &apparatus.preset());
            let preset = preset.unwrap_or_else(|e| panic!("{name} {seed}: {e}"));
            let model = &preset.model;
            let (real, nominal) = (apparatus.device, apparatus.nominal);
            assert!((model.proof_mass / real.mass - 1.0).abs() < 0.012);
            assert!(!model.has_ground && !model.has_cantilever);
            let f1 = model.get("f1").unwrap();
            assert!((f1 - nominal.frequency).abs() <= 2e-3 * nominal.frequency);
            // The ball's gravity is the only effect, and the true one is not given away.
            assert_eq!(model.effects.len(), usize::from(name == "ball"));
            if name == "ball" {
                assert_eq!(model.effects[0].spec.id, "gravity");
                assert_eq!(model.effects[0].values[0], 9.80665);
                let known = &preset.known[0];
                assert_eq!((known.id.as_str(), known.value), ("gravity.g", 9.80665));
                assert!((known.value - real.gravity).abs() < known.std_error);
            }
        }
    }
}
