//! Springs, balls and pendulums as they are recorded.

use super::{all, plain, rms};
use crate::recording::Recording;
use crate::trial::*;

#[test]
fn springs_are_read_in_steps_and_die_away() {
    let mut steps = std::collections::BTreeSet::new();
    for seed in 0..15 {
        let case = plain("spring", seed);
        let instruments = &case.truth().instruments;
        assert_eq!((instruments.rate, instruments.cantilever), (100.0, false));
        let step = instruments.reading_step;
        steps.insert((step * 1e4).round() as u64);
        let recordings = case.recordings();
        assert_eq!((recordings.train.len(), recordings.held_out.len()), (2, 2));
        for recording in all(&case) {
            assert!(recording.voltage.is_none());
            let x = &recording.proof_mass;
            assert!((2500..=3501).contains(&x.len()), "{}", x.len());
            assert!(
                x.iter()
                    .all(|x| (x / step - (x / step).round()).abs() < 1e-6)
            );
            let zero = instruments.zeros[0][0];
            let third = x.len() / 3;
            let swing = |part: &[f64]| rms(part.iter().map(|x| x - zero));
            assert!(swing(&x[2 * third..]) < swing(&x[..third]));
        }
    }
    assert_eq!(steps.into_iter().collect::<Vec<_>>(), [1, 10, 100]);
}

#[test]
fn balls_fall_freely_unless_a_drag_is_concealed() {
    let fall = |settings: &Settings, seed: u64| {
        let case = Case::draw(seed, settings).unwrap();
        let instruments = case.truth().instruments.clone();
        let rates = [15.0, 30.0, 60.0, 120.0, 240.0];
        assert!(rates.contains(&instruments.rate));
        let recordings: Vec<Recording> = all(&case).into_iter().cloned().collect();
        // The mean acceleration, from the middle and both ends.
        let of = |r: &Recording| {
            let x = &r.proof_mass;
            assert!(x.len() >= 38, "{}", x.len());
            let m = (x.len() - 1) / 2;
            let t = m as f64 / instruments.rate;
            let acceleration = (x[2 * m] - 2.0 * x[m] + x[0]) / (t * t);
            (acceleration, 10.0 * instruments.noise / (t * t))
        };
        recordings.iter().map(of).collect::<Vec<_>>()
    };
    let nothing = Settings {
        mix: Mix::Only(Class::Nothing),
        ..Settings::of_rig("ball")
    };
    let drag = Settings {
        mix: Mix::Effect("quadratic_drag".into()),
        sizes: Some((30.0, 30.0)),
        ..Settings::of_rig("ball")
    };
    let mut slower = 0;
    for seed in 0..10 {
        for (acceleration, error) in fall(&nothing, seed) {
            assert!((acceleration + 9.81).abs() < error + 0.1, "{acceleration}");
        }
        slower += (fall(&drag, seed).iter())
            .filter(|(acceleration, error)| acceleration + 9.81 > error + 0.1)
            .count();
    }
    assert!(slower > 10, "{slower} of 40");
}

#[test]
fn pendulums_swing_wide_enough_for_their_sine() {
    let settings = |size: f64| Settings {
        mix: Mix::Effect("sine_stiffness".into()),
        sizes: Some((size, size)),
        ..Settings::of_rig("pendulum")
    };
    for seed in 0..6 {
        let swing = |size: f64| {
            let case = Case::draw(seed, &settings(size)).unwrap();
            let found = case.truth().effects[0].times_smallest_visible;
            assert!((found / size - 1.0).abs() < 0.1, "{found} for {size}");
            assert!((25.0..=60.0).contains(&case.truth().instruments.rate));
            let x = all(&case)[0].proof_mass.clone();
            x.iter().fold(0.0f64, |w, x| w.max(x.abs()))
        };
        let (small, large) = (swing(1.5), swing(25.0));
        assert!(small < large && large < 1.5, "{small} {large}");
    }
}
