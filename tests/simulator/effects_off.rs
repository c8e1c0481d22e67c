//! Effects of strength zero leave the device exactly as it is, and a lagging amplifier
//! drives it as the lagged voltage would.

use std::sync::Arc;

use crate::support::device::with;
use crate::support::difference::largest_difference;
use impactscope::model::Model;
use impactscope::model::drive::{VoltageTable, Waveform};
use impactscope::model::effects::{ActiveEffect, CATALOGUE, find};
use impactscope::model::preset::Preset;
use impactscope::sim::{Options, Trace, simulate};

fn run(model: &Model, drive: &Waveform, duration: f64) -> Trace {
    simulate(model, drive, duration, &Options::default()).unwrap()
}

#[test]
fn strength_zero_is_the_baseline() {
    let baseline = Preset::default().model;
    for effect in CATALOGUE {
        // A ground that gives way has no strength zero: the stiffest is the rigid one.
        if effect.id == "compliant_ground" {
            continue;
        }
        let strengths = effect.facts.strengths;
        assert!(!strengths.is_empty(), "{}: no strength is named", effect.id);
        let zero: Vec<(&str, f64)> = strengths.iter().map(|id| (*id, 0.0)).collect();
        let model = with(effect.id, &zero);
        for drive in ["square:50Hz:8V", "sine:50Hz:6V"] {
            let drive = Waveform::parse(drive, 0.1).unwrap();
            let (with, without) = (run(&model, &drive, 0.1), run(&baseline, &drive, 0.1));
            // To the last bit, events, contacts and the number of steps included.
            assert!(with == without, "{}", effect.id);
        }
    }
}

#[test]
fn every_strength_changes_the_run() {
    // Longer than until the ground steps.
    const SPAN: f64 = 0.15;
    let drives = ["square:50Hz:8V", "sine:50Hz:6V"];
    let drives = drives.map(|text| Waveform::parse(text, SPAN).unwrap());
    let baseline = Preset::default().model;
    let plain = drives.each_ref().map(|drive| run(&baseline, drive, SPAN));
    for effect in CATALOGUE {
        let strengths = effect.facts.strengths;
        // Those that are on at their defaults, or at the end of their range where that is 0.
        let changes = |on: &[&str]| {
            let value = |id: &&'static str| {
                let spec = effect.parameters.iter().find(|p| p.id == *id).unwrap();
                let own = if spec.default == 0.0 {
                    spec.range.1
                } else {
                    spec.default
                };
                (*id, if on.contains(id) { own } else { 0.0 })
            };
            let values: Vec<(&str, f64)> = strengths.iter().map(value).collect();
            let model = with(effect.id, &values);
            let mut runs = drives.iter().zip(&plain);
            runs.any(|(drive, plain)| run(&model, drive, SPAN) != *plain)
        };
        for id in strengths {
            // A mode shows where something moves it and a reading sees it: a shape may need another
            // one beside it that shows nothing alone either.
            let beside =
                |other: &&str| other != id && !changes(&[*other]) && changes(&[*id, *other]);
            assert!(
                changes(&[*id]) || strengths.iter().any(beside),
                "{}: {id} is no strength",
                effect.id
            );
        }
    }
}

/// The lagged voltage of a sine from rest in closed form, as a table.
fn lagged_sine(frequency: f64, amplitude: f64, tau: f64, duration: f64) -> Waveform {
    let w = std::f64::consts::TAU * frequency;
    let scale = amplitude / (1.0 + (w * tau).powi(2));
    let step = 2e-7;
    let time: Vec<f64> = (0..=(duration / step) as usize)
        .map(|i| i as f64 * step)
        .collect();
    let voltage = time
        .iter()
        .map(|t| scale * ((w * t).sin() - w * tau * (w * t).cos() + w * tau * (-t / tau).exp()))
        .collect();
    Waveform::Table(Arc::new(
        VoltageTable::new("lagged", time, voltage).unwrap(),
    ))
}

#[test]
fn a_lagging_amplifier_drives_like_the_lagged_voltage() {
    for (frequency, tau) in [(50.0, 50e-6), (120.0, 300e-6)] {
        let drive = Waveform::Sine {
            frequency,
            amplitude: 6.0,
        };
        let lagging = run(&with("amplifier_lag", &[("tau", tau)]), &drive, 0.05);
        let table = lagged_sine(frequency, 6.0, tau, 0.05);
        let driven = run(&Preset::default().model, &table, 0.05);
        let apart = largest_difference(&lagging.proof_mass, &driven.proof_mass);
        println!("{frequency} Hz, {tau} s: {apart:e} m");
        // The table turns within a fifth of a microsecond of where the sine does; at
        // 0.3 m/s that is 60 nm at most after an impact.
        assert!(apart < 60e-9, "{apart}");
        let plain = run(&Preset::default().model, &drive, 0.05);
        assert!(largest_difference(&lagging.proof_mass, &plain.proof_mass) > 1e-6);
    }
}

/// The square wave of an amplifier that takes `pace` seconds for a volt and settles with the
/// time constant `tau`, in closed form as a table of lines: from rest to the upper level, then
/// from one to the other, each time straight until what is left is a slope of the exponential.
fn slewed_square(frequency: f64, amplitude: f64, (pace, tau): (f64, f64), end: f64) -> Waveform {
    let half = 0.5 / frequency;
    let (mut time, mut voltage) = (vec![0.0], vec![0.0]);
    for k in 0..(end / half).round() as usize {
        let at = k as f64 * half;
        let level = if k % 2 == 0 { 1.0 } else { -1.0 } * amplitude;
        let from = voltage[voltage.len() - 1];
        let up = (level - from).signum();
        let left = (tau / pace).min((level - from).abs());
        let straight = pace * ((level - from).abs() - left);
        if k > 0 {
            time.push(at);
            voltage.push(from);
        }
        if straight > 0.0 {
            time.push(at + straight);
            voltage.push(level - up * left);
        }
        let settles: Vec<f64> = (1..)
            .map(|i| 2e-3 * f64::from(i) * tau)
            .take_while(|s| *s < half - straight && *s < 40.0 * tau)
            .collect();
        time.extend(settles.iter().map(|s| at + straight + s));
        voltage.extend(settles.iter().map(|s| level - up * left * (-s / tau).exp()));
    }
    time.push(end);
    voltage.push(voltage[voltage.len() - 1]);
    Waveform::Table(Arc::new(
        VoltageTable::new("slewed", time, voltage).unwrap(),
    ))
}

#[test]
fn an_amplifier_of_bounded_pace_drives_like_the_slopes_that_it_makes() {
    for (frequency, pace, tau) in [
        (50.0, 20e-6, 0.0),
        (80.0, 100e-6, 0.0),
        (50.0, 20e-6, 80e-6),
        // Too near for the pace to bind it; hardly settled before the next edge.
        (50.0, 5e-6, 80e-6),
        (80.0, 100e-6, 1e-3),
    ] {
        let drive = Waveform::Square {
            frequency,
            amplitude: 7.0,
        };
        let slow = run(
            &with("amplifier_lag", &[("tau", tau), ("r", pace)]),
            &drive,
            0.05,
        );
        let slopes = slewed_square(frequency, 7.0, (pace, tau), 0.05);
        let driven = run(&Preset::default().model, &slopes, 0.05);
        let apart = largest_difference(&slow.proof_mass, &driven.proof_mass);
        println!("{frequency} Hz, {pace} s/V, {tau} s: {apart:e} m");
        assert!(apart < 2e-9, "{apart}");
        let plain = run(&Preset::default().model, &drive, 0.05);
        assert!(largest_difference(&slow.proof_mass, &plain.proof_mass) > 1e-6);
    }
}

/// What an amplifier that settles with `tau` and takes `pace` seconds for a volt makes of a
/// waveform, by small steps, as a table.
fn stepped(waveform: &Waveform, (tau, pace): (f64, f64), end: f64) -> Waveform {
    const STEP: f64 = 5e-9;
    const KEPT: usize = 40;
    let (mut time, mut voltage) = (vec![0.0], vec![0.0]);
    let mut own = 0.0f64;
    for k in 0..(end / STEP) as usize {
        let middle = waveform.voltage((k as f64 + 0.5) * STEP);
        own += ((middle - own) / tau).clamp(-1.0 / pace, 1.0 / pace) * STEP;
        if (k + 1) % KEPT == 0 {
            time.push((k + 1) as f64 * STEP);
            voltage.push(own);
        }
    }
    Waveform::Table(Arc::new(
        VoltageTable::new("stepped", time, voltage).unwrap(),
    ))
}

#[test]
fn an_amplifier_that_is_outrun_slews_and_settles() {
    // Steeper than the pace in places (15 against 10 kV/s), at each instant of a triangle's
    // sides, hardly, exactly as steep, and all but settled throughout.
    for (text, tau, pace) in [
        ("sine:300Hz:8V", 8e-5, 1e-4),
        ("chirp:50Hz:300Hz:7V", 3e-5, 1e-4),
        ("triangle:200Hz:8V", 1e-4, 2e-4),
        ("sine:200Hz:6V", 5e-5, 1.33e-4),
        ("triangle:200Hz:8V", 5e-5, 1.0 / 6400.0),
        ("sine:50Hz:8V", 2e-5, 1e-5),
    ] {
        let drive = Waveform::parse(text, 0.02).unwrap();
        let slow = run(
            &with("amplifier_lag", &[("tau", tau), ("r", pace)]),
            &drive,
            0.02,
        );
        let driven = run(
            &Preset::default().model,
            &stepped(&drive, (tau, pace), 0.02),
            0.02,
        );
        let apart = largest_difference(&slow.proof_mass, &driven.proof_mass);
        println!("{text}, {tau} s, {pace} s/V: {apart:e} m");
        // The table turns within a fifth of a microsecond, as that of the lagged sine.
        assert!(apart < 60e-9, "{text}: {apart}");
        let plain = run(&Preset::default().model, &drive, 0.02);
        assert!(largest_difference(&slow.proof_mass, &plain.proof_mass) > 1e-7);
    }
}

#[test]
fn a_late_reading_is_the_reading_of_before() {
    let drive = Waveform::parse("square:50Hz:8V", 0.05).unwrap();
    let plain = run(&Preset::default().model, &drive, 0.05);
    // Ten samples late.
    let model = with("sensor_lag", &[("tau", 0.0), ("delay", 200e-6)]);
    let late = run(&model, &drive, 0.05);
    assert_eq!(late.voltage, plain.voltage);
    let (now, before) = (&late.proof_mass[10..], &plain.proof_mass);
    let apart = largest_difference(now, &before[..now.len()]);
    assert!(apart < 1e-12, "{apart}");
    // A first-order lag of a slow swing is a delay by its time constant, but for the
    // (w tau)^2 of the amplitude: 3.7e-5 at 1.37 Hz and 1 ms.
    let mut model = Preset::embedded("oscillator").unwrap().model;
    let plain = run(&model, &Waveform::Rest, 1.0);
    let mut lag = ActiveEffect::new(find("sensor_lag").unwrap());
    lag.set("tau", 1e-3);
    model.effects.push(lag);
    let late = run(&model, &Waveform::Rest, 1.0);
    let (now, before) = (&late.proof_mass[5050..], &plain.proof_mass[5000..]);
    let apart = largest_difference(now, &before[..now.len()]);
    assert!(apart < 1e-4 * 0.1 && apart > 1e-6 * 0.1, "{apart}");
}

#[test]
fn the_ground_steps_under_the_mass() {
    let drive = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
    for height in [2e-6, -2e-6] {
        // Stuck until 33 ms; the step comes at 20 ms.
        let trace = run(
            &with("gap_step", &[("h", height), ("t0", 0.02)]),
            &drive,
            0.1,
        );
        let (before, after) = (trace.proof_mass[990], trace.proof_mass[1400]);
        assert!((before + 58e-6).abs() < 1e-12, "{before}");
        assert!((after + 58e-6 - height).abs() < 1e-9, "{after}");
    }
}
