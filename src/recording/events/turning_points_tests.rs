//! Turning points of a ball that bounces, as a camera reads it.

use super::*;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::recording::events::{EventOptions, find_events, hop_height};
use crate::sim::{Options, simulate};

const CAMERA_RATE: f64 = 200.0;

/// Heights of the preset's ball with a restitution of `alpha`, read for `duration` \[s\] with `noise`
/// \[m\]; each reading is the mean over `exposure` \[s\].
fn filmed(alpha: f64, duration: f64, noise: f64, exposure: f64) -> Vec<f64> {
    let mut model = Preset::embedded("bouncing-ball").unwrap().model;
    model.set("alpha", alpha).unwrap();
    let parts = 20;
    let options = Options {
        rate: CAMERA_RATE * parts as f64,
        ..Options::default()
    };
    let trace = simulate(&model, &Waveform::Rest, duration, &options).unwrap();
    let own = (exposure * options.rate).round() as usize;
    let mut xp: Vec<f64> = trace
        .proof_mass
        .windows(own + 1)
        .step_by(parts)
        .map(|w| w.iter().sum::<f64>() / w.len() as f64)
        .collect();
    let sensor = Sensor {
        noise,
        ..Sensor::default()
    };
    sensor.add_noise(&mut xp, 7);
    xp
}

fn camera() -> TimeAxis<'static> {
    TimeAxis::Uniform {
        t0: 0.0,
        dt: 1.0 / CAMERA_RATE,
    }
}

#[test]
fn the_bounces_of_a_ball_give_level_and_restitution() {
    // It bounces after 0.25 s, then each time after `alpha` times 0.49 s, 0.49 s alpha^2, ...
    for (alpha, duration, noise, exposure, fewest) in [
        (0.7, 1.0, 5e-5, 0.0, 3),
        (0.85, 1.25, 1e-5, 0.0, 3),
        (0.6, 1.0, 1e-4, 0.0, 2),
        // Smoothed over a frame: no sample is at the ground.
        (0.7, 1.0, 2e-5, 5e-3, 3),
    ] {
        let xp = filmed(alpha, duration, noise, exposure);
        let turns = turning_points(camera(), &xp, noise);
        assert!(turns.len() >= fewest, "{alpha}: {turns:?}");
        for turn in &turns {
            let ratio = -turn.v_after / turn.v_before;
            let slack = 0.01 + 4.0 * turn.v_error / turn.v_before.abs();
            assert!((ratio - alpha).abs() < slack, "{alpha}: {turn:?}");
        }
        let ground = level_of_turns(camera(), &xp, noise).expect("a ground");
        assert!(ground.turns >= fewest, "{ground:?}");
        assert!((ground.level + 0.05).abs() < 5e-4, "{ground:?}");
        // Events at that level are the same bounces.
        let options = EventOptions::for_travel(ground.level, noise, &xp);
        let impacts = find_events(camera(), &xp, &options).impacts;
        for turn in &turns {
            let same = |i: &&Impact| (i.time - turn.time).abs() < 1e-3;
            let impact = impacts.iter().find(same).expect("an impact");
            let apart = (impact.v_after - turn.v_after).abs();
            assert!(apart < 0.02 * turn.v_after, "{impact:?} {turn:?}");
        }
    }
}

#[test]
fn turning_points_are_the_same_in_other_units() {
    let noise = 5e-5;
    let xp = filmed(0.7, 1.0, noise, 0.0);
    let turns = turning_points(camera(), &xp, noise);
    // 0.3 m become 60 um, and a second becomes 14 ms.
    let (length, time) = (2e-4, 0.014);
    let small: Vec<f64> = xp.iter().map(|x| length * x).collect();
    let axis = TimeAxis::Uniform {
        t0: 0.0,
        dt: time / CAMERA_RATE,
    };
    let again = turning_points(axis, &small, length * noise);
    assert_eq!(turns.len(), again.len());
    assert!(turns.len() >= 3);
    for (a, b) in turns.iter().zip(&again) {
        let speed = length / time;
        assert!((b.time / (time * a.time) - 1.0).abs() < 1e-6, "{a:?} {b:?}");
        assert!((b.v_after / (speed * a.v_after) - 1.0).abs() < 1e-6);
        assert!((b.height / (length * a.height) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn a_swing_has_no_sudden_turn_and_no_ground() {
    let noise = 2e-5;
    for frequency in [0.5, 1.37, 4.0] {
        let swing = |i: u32| {
            let t = f64::from(i) / CAMERA_RATE;
            0.1 * (std::f64::consts::TAU * frequency * t).cos()
        };
        let mut xp: Vec<f64> = (0..800).map(swing).collect();
        let sensor = Sensor {
            noise,
            ..Sensor::default()
        };
        sensor.add_noise(&mut xp, 3);
        assert_eq!(turning_points(camera(), &xp, noise), Vec::new());
        assert_eq!(level_of_turns(camera(), &xp, noise), None);
    }
}

#[test]
fn hops_go_with_the_travel() {
    // The paper's device in any of its travels, a ball, and a device of a micrometre.
    for travel in [60e-6, 110e-6, 200e-6] {
        assert_eq!(hop_height(travel), 5e-6);
    }
    assert!((hop_height(0.3) - 6e-3).abs() < 1e-12);
    assert!((hop_height(1e-6) - 1e-7).abs() < 1e-18);
    assert_eq!(hop_height(f64::NAN), 5e-6);
    assert_eq!(hop_height(0.0), 5e-6);
}
