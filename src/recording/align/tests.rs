use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::recording::align::*;

/// A start-up and then a periodic motion with a sharp edge in it.
fn signal(t: f64) -> f64 {
    if t < 0.0 {
        return 0.0;
    }
    let slow = (std::f64::consts::TAU * 50.0 * t).sin() * (1.0 - (-t / 0.02).exp());
    1e-4 * slow.max(-0.58) + 2e-5 * (-t / 0.05).exp() * (std::f64::consts::TAU * 623.0 * t).sin()
}

fn simulated() -> Vec<f64> {
    (0..15_000).map(|i| signal(i as f64 * 1e-5)).collect()
}

#[test]
fn shift_is_found_to_a_tenth_of_a_sample() {
    let values = simulated();
    let grid = Grid {
        t0: 0.0,
        dt: 1e-5,
        values: &values,
        slopes: None,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for (rate, shift) in [
        (50e3, 0.0),
        (50e3, 0.0123),
        (20e3, -0.01234567),
        (200e3, 0.003_333),
    ] {
        let n = (0.1 * rate) as usize;
        // Time as the recorder counts it: the motion at t is the model's at t + shift.
        let time: Vec<f64> = (0..n).map(|i| 0.02 + i as f64 / rate).collect();
        let mut x: Vec<f64> = time
            .iter()
            .map(|t| 1.3 * signal(t + shift) + 5e-6 + 1e-7 * (rng.random::<f64>() - 0.5))
            .collect();
        x.iter_mut().step_by(97).for_each(|v| *v = f64::NAN);
        let (mut time, mut x) = (time, x);
        // A gap.
        time.drain(n / 2..n / 2 + n / 20);
        x.drain(n / 2..n / 2 + n / 20);
        let recording = Recording::new("r", time, None, x, None).unwrap();
        let found = auto_align(&recording, Channel::ProofMass, 1.0, grid, None).unwrap();
        let error = (found.time_shift - shift) * rate;
        assert!(
            error.abs() < 0.1,
            "{rate} {shift}: {error} samples, {found:?}"
        );
        assert!(found.correlation > 0.999);
        assert!((found.scale * 1.3 - 1.0).abs() < 1e-2, "{found:?}");
    }
}

#[test]
fn a_periodic_motion_takes_the_nearest_period() {
    let wave = |t: f64| (std::f64::consts::TAU * 50.0 * t).sin();
    let values: Vec<f64> = (0..20_000).map(|i| wave(i as f64 * 1e-5)).collect();
    let time: Vec<f64> = (0..2000).map(|i| i as f64 * 5e-5).collect();
    let x: Vec<f64> = time.iter().map(|t| wave(t - 0.002)).collect();
    let recording = Recording::new("r", time, None, x, None).unwrap();
    let grid = Grid {
        t0: 0.0,
        dt: 1e-5,
        values: &values,
        slopes: None,
    };
    // Before zero there is no simulation, but half the recording still overlaps.
    let found = auto_align(&recording, Channel::ProofMass, 1.0, grid, None).unwrap();
    assert!((found.time_shift + 0.002).abs() < 5e-6, "{found:?}");
    let found = auto_align(&recording, Channel::ProofMass, 1.0, grid, Some(1e-3));
    assert!(found.is_ok_and(|f| f.time_shift.abs() <= 2e-3));
}

#[test]
fn nothing_to_align_is_an_error() {
    let grid = |values| Grid {
        t0: 0.0,
        dt: 1e-5,
        values,
        slopes: None,
    };
    let time: Vec<f64> = (0..100).map(f64::from).collect();
    let flat = Recording::new("r", time.clone(), None, vec![3.0; 100], None).unwrap();
    let moving = Recording::new("r", time.clone(), None, time.clone(), None).unwrap();
    let values = simulated();
    let align = |r: &Recording, g| auto_align(r, Channel::ProofMass, 1.0, g, None).unwrap_err();
    assert_eq!(
        align(&flat, grid(&values)),
        AlignError::Constant { which: "recording" }
    );
    assert_eq!(
        align(&moving, grid(&[1.0; 50])),
        AlignError::Constant {
            which: "simulation"
        }
    );
    assert_eq!(align(&moving, grid(&[])), AlignError::BadGrid);
    let missing = auto_align(&moving, Channel::Voltage, 1.0, grid(&values), None);
    assert_eq!(missing, Err(AlignError::NotRecorded("V")));
    let far = auto_align(
        &moving,
        Channel::ProofMass,
        1.0,
        Grid {
            t0: 1e6,
            dt: 1.0,
            values: &values,
            slopes: None,
        },
        Some(1.0),
    );
    assert_eq!(far, Err(AlignError::NoOverlap));
}

/// A ring-down: amplitude, frequency [Hz], time constant [s], offset.
fn ring_down(amplitude: f64, frequency: f64, decay: f64, offset: f64, t: f64) -> f64 {
    offset + amplitude * (-t / decay).exp() * (std::f64::consts::TAU * frequency * t).cos()
}

fn recorded(count: usize, x: impl Fn(f64) -> f64) -> Recording {
    let time: Vec<f64> = (0..count).map(|i| i as f64 * 0.01).collect();
    let x = time.iter().map(|t| x(*t)).collect();
    Recording::new("r", time, None, x, None).unwrap()
}

#[test]
fn a_long_ring_down_is_not_matched_far_down_its_decay() {
    let values: Vec<f64> = (0..6000)
        .map(|i| ring_down(0.1, 1.37, 60.0, 0.0, i as f64 * 0.005))
        .collect();
    let grid = Grid {
        t0: 0.0,
        dt: 0.005,
        values: &values,
        slopes: None,
    };
    let align = |r: &Recording, scale| auto_align(r, Channel::ProofMass, scale, grid, None);
    // Four times as long as the simulation, far from zero, a third of a period late.
    let same = recorded(12_000, same_at);
    let found = align(&same, 1.0).unwrap();
    assert!((found.time_shift + 0.25).abs() < 2e-3, "{found:?}");
    assert!(found.correlation > 0.999 && found.share > 0.2, "{found:?}");
    // Drawn turned over it matches half a period away.
    let turned = align(&same, -1.0).unwrap();
    let half = 0.5 / 1.37;
    let away = ((turned.time_shift + 0.25).abs() - half).abs();
    assert!(away < 5e-3, "{turned:?}");
    // Another frequency fits over short stretches only: nothing is better than nonsense.
    let other = recorded(12_000, |t| ring_down(0.08, 1.42, 60.0, 0.42, t));
    let error = align(&other, 1.0).unwrap_err();
    assert!(matches!(error, AlignError::NoMatch { .. }), "{error}");
    assert!(error.to_string().starts_with("no clear match"));
    // Millimetres read as metres.
    let error = align(&recorded(12_000, |t| 1e3 * same_at(t)), 1.0).unwrap_err();
    assert!(
        matches!(error, AlignError::Amplitude { ratio } if ratio > 300.0),
        "{error}"
    );
    assert!(align(&recorded(12_000, |t| 1e3 * same_at(t)), 1e-3).is_ok());
}

fn same_at(t: f64) -> f64 {
    ring_down(0.08, 1.37, 60.0, 0.42, t - 0.25)
}
