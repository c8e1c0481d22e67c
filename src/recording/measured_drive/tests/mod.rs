//! Every known waveform, at every rate and noise that is asked for.

mod open;

use std::f64::consts::TAU;

use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::model::sensor::gaussian;

/// Samples of `drive` at `rate` \[Hz\] for `duration` \[s\], their clock `late` \[s\], with white
/// noise \[V\] and rounded to a step \[V\].
fn sampled(
    drive: impl Fn(f64) -> f64,
    rate: f64,
    duration: f64,
    (noise, step): (f64, f64),
    seed: u64,
) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let time: Vec<f64> = (0..(rate * duration) as usize)
        .map(|i| i as f64 / rate)
        .collect();
    let volts = time
        .iter()
        .map(|&t| {
            let v = drive(t) + noise * gaussian(&mut rng);
            if step > 0.0 {
                (v / step).round() * step
            } else {
                v
            }
        })
        .collect();
    (time, volts)
}

fn recognised(time: &[f64], volts: &[f64]) -> MeasuredDrive {
    measured_drive("test", time, volts, DriveReading::Recognised).unwrap()
}

const ERRORS: [(f64, f64); 6] = [
    (0.0, 0.0),
    (1e-3, 0.0),
    (5e-3, 0.0),
    (20e-3, 0.0),
    (50e-3, 0.0),
    (0.0, 0.08),
];

#[test]
fn what_was_set_is_found_at_every_rate_and_noise() {
    let mut failures = Vec::new();
    for text in [
        "square:15Hz:8V",
        "square:50Hz:8V",
        "ramped:5Hz:8V:0.25",
        "ramped:20Hz:8V:0.1",
        "triangle:10Hz:8V",
        "triangle:40Hz:6V",
        "sine:50Hz:8V",
        "sine:12.5Hz:4V",
    ] {
        let drive = Waveform::parse(text, 1.0).unwrap();
        for rate in [12.5e3, 25e3, 50e3, 100e3] {
            for (seed, error) in ERRORS.into_iter().enumerate() {
                let (time, volts) = sampled(|t| drive.voltage(t), rate, 0.4, error, seed as u64);
                let found = recognised(&time, &volts);
                if found.command.as_deref() != Some(text) {
                    failures.push(format!(
                        "{text} at {rate} Hz, {error:?}: {:?} {}",
                        found.command, found.text
                    ));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}: {failures:#?}", failures.len());
}

/// Settings in tenths, recordings of a few periods, and voltages written with few decimals or read
/// by 8 bits whose zero lies between two steps.
#[test]
fn short_recordings_show_what_was_set() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut failures = Vec::new();
    for case in 0..160 {
        let tenths = |from: i32, to: i32, rng: &mut ChaCha8Rng| {
            f64::from(rng.random_range(from..=to)) / 10.0
        };
        let (volts, hertz) = (tenths(40, 80, &mut rng), tenths(100, 1000, &mut rng));
        let lambda = f64::from(rng.random_range(4..30)) / 100.0;
        let text = match case % 4 {
            0 => format!("square:{hertz}Hz:{volts}V"),
            1 => format!("ramped:{hertz}Hz:{volts}V:{lambda}"),
            2 => format!("triangle:{hertz}Hz:{volts}V"),
            _ => format!("sine:{hertz}Hz:{volts}V"),
        };
        let drive = Waveform::parse(&text, 1.0).unwrap();
        let duration = tenths(60, 120, &mut rng) / 100.0;
        let step = [0.0, 1e-5, 1e-3, 20.0 / 256.0][case / 4 % 4];
        let between = if step > 1e-2 { 0.5 * step } else { 0.0 };
        let shifted = |t| drive.voltage(t) - between;
        let (time, mut read) = sampled(shifted, 50e3, duration, (0.0, step), 0);
        read.iter_mut().for_each(|v| *v += between);
        let found = recognised(&time, &read);
        let waveform = found.waveform("test", 0.0);
        let off = |&t: &f64| (waveform.voltage(t) - drive.voltage(t)).abs();
        let far = |t: &&f64| found.edges.iter().all(|e| (e.time - **t).abs() > 21e-6);
        let worst = time.iter().filter(far).map(off).fold(0.0, f64::max);
        if !found.recognised || worst > 0.75 * step + 1e-6 {
            failures.push(format!(
                "{text} {duration} s step {step}: {} off {worst:.6}",
                found.text
            ));
        }
    }
    assert!(failures.is_empty(), "{}: {failures:#?}", failures.len());
}

/// Tables of points with one decimal of a volt and of a millisecond, read by 8 bits.
#[test]
fn a_typed_table_is_found_through_a_coarse_digitiser() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut worst = Vec::new();
    for case in 0..20 {
        let mut points = vec![(0.0, 0.0)];
        let mut end = 0.0;
        while end < 0.1 {
            end += f64::from(rng.random_range(15..90)) * 1e-4;
            let volts = f64::from(rng.random_range(-78..=78)) / 10.0;
            let last = points[points.len() - 1].1;
            let stays = rng.random_range(0..4) == 0;
            points.push((end, if stays { last } else { volts }));
        }
        let table = |t: f64| {
            let i = points
                .partition_point(|p| p.0 <= t)
                .clamp(1, points.len() - 1);
            let (a, b) = (points[i - 1], points[i]);
            a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0)
        };
        let between = 10.0 / 256.0;
        let (time, mut read) = sampled(|t| table(t) - between, 50e3, 0.1, (0.0, 20.0 / 256.0), 0);
        read.iter_mut().for_each(|v| *v += between);
        let found = recognised(&time, &read);
        assert!(found.recognised, "{case}: {}", found.text);
        let waveform = found.waveform("test", 0.0);
        // The last piece ends with the recording, not with its line.
        let inside = found.pieces[found.pieces.len() - 2].start;
        let off = time.iter().take_while(|t| **t < inside);
        let off = off.map(|&t| (waveform.voltage(t) - table(t)).abs());
        worst.push(off.fold(0.0, f64::max));
    }
    let exact = worst.iter().filter(|off| **off < 1e-6).count();
    // Corners that hardly turn, and voltages that differ by about a step, stay hidden.
    assert!(exact >= 9, "{exact} of 20 exactly: {worst:.3?}");
    assert!(worst.iter().all(|off| *off < 0.15), "{worst:.3?}");
}

/// Largest distance of the found voltage from the true one \[V\], away from edges, and the largest
/// error of an edge \[s\].
fn worst(
    found: &MeasuredDrive,
    drive: &impl Fn(f64) -> f64,
    time: &[f64],
    edges: &[f64],
) -> (f64, f64) {
    let waveform = found.waveform("test", 0.0);
    let interval = time[1] - time[0];
    let far = |t: f64| edges.iter().all(|e| (e - t).abs() > 1.01 * interval);
    let voltage = time
        .iter()
        .filter(|t| far(**t))
        .map(|&t| (waveform.voltage(t) - drive(t)).abs())
        .fold(0.0, f64::max);
    let late = edges
        .iter()
        .map(|e| {
            found
                .edges
                .iter()
                .map(|f| (f.time - e).abs())
                .fold(f64::INFINITY, f64::min)
        })
        .fold(0.0, f64::max);
    (voltage, late)
}

#[test]
fn odd_settings_are_met_within_what_the_samples_allow() {
    // Nothing round: phase, frequency, amplitude and offset drawn.
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut failures = Vec::new();
    for k in 0..60 {
        let u = |rng: &mut ChaCha8Rng| 0.5 + 0.28 * gaussian(rng).clamp(-1.7, 1.7);
        let (f, a) = (7.0 + 40.0 * u(&mut rng), 3.0 + 5.0 * u(&mut rng));
        let (offset, begin) = (u(&mut rng) - 0.5, -0.02 * u(&mut rng));
        let text = ["sine", "square", "triangle", "ramped"][k % 4];
        let lambda = if text == "ramped" { ":0.17" } else { "" };
        let plain = Waveform::parse(&format!("{text}:{f}Hz:{a}V{lambda}"), 1.0).unwrap();
        let drive = |t: f64| offset + plain.voltage(t - begin);
        let error = ERRORS[k % 5];
        let rate = [12.5e3, 25e3, 50e3, 100e3][(k / 4) % 4];
        let (time, volts) = sampled(drive, rate, 0.4, error, k as u64);
        let found = recognised(&time, &volts);
        let edges: Vec<f64> = (0..400)
            .map(|i| plain.segment(i).start + begin)
            .filter(|t| *t > 2.0 / rate && *t < 0.4 - 2.0 / rate)
            .collect();
        let (voltage, _) = worst(&found, &drive, &time, &edges);
        // Whatever was fitted has at most ten free numbers.
        let allowed = 6.0 * error.0 / ((0.4 * rate).sqrt() / 4.0) + 1e-6 * a;
        if voltage > allowed || !found.recognised {
            failures.push(format!(
                "{k} {text} {rate} {error:?}: off by {voltage:e} V, {allowed:e} allowed: {}",
                found.text
            ));
        }
    }
    assert!(failures.is_empty(), "{}: {failures:#?}", failures.len());
}

#[test]
fn many_edges_narrow_each_one() {
    let drive = |t: f64| {
        if ((t + 0.0021) * 30.7).fract() < 0.5 {
            8.0
        } else {
            -8.0
        }
    };
    let (time, volts) = sampled(drive, 50e3, 2.0, (4e-3, 0.0), 5);
    let found = recognised(&time, &volts);
    let worst = found.edges.iter().map(|e| e.reach).fold(0.0, f64::max);
    assert!(worst < 2.5e-6, "{worst:e}: {}", found.text);
    for edge in &found.edges {
        let turns = (edge.time + 0.0021) * 30.7 * 2.0;
        let off = (turns - turns.round()).abs() / (30.7 * 2.0);
        assert!(off <= edge.reach + 1e-9, "{off:e} {:e}", edge.reach);
    }
}

#[test]
fn other_waveforms_are_known_too() {
    type Case = (&'static str, Box<dyn Fn(f64) -> f64>, &'static str);
    let cases: Vec<Case> = vec![
        ("level", Box::new(|_| 3.0), "constant 3 V"),
        (
            "sawtooth",
            Box::new(|t| 8.0 * (t * 20.0).fract() - 4.0),
            "20 Hz",
        ),
        (
            "duty 30 %",
            Box::new(|t| if (t * 20.0).fract() < 0.3 { 8.0 } else { 0.0 }),
            "20 Hz",
        ),
        (
            "stairs",
            Box::new(|t| [0.0, 2.0, 5.0, 1.0][(t / 0.07) as usize % 4]),
            "levels joined by",
        ),
        (
            "sweep",
            Box::new(|t| 6.0 * (TAU * t * (5.0 + 50.0 * t)).sin()),
            "sweep from 5 Hz",
        ),
        (
            "two sines",
            Box::new(|t| 1.0 + 5.0 * (TAU * 20.0 * t).sin() + 2.0 * (TAU * 47.0 * t + 1.0).sin()),
            "sum of sines 20 Hz",
        ),
        (
            "points",
            Box::new(|t| {
                let p = [
                    (0.0, 0.0),
                    (0.05, 8.0),
                    (0.11, -2.0),
                    (0.2, -2.0),
                    (0.31, 6.0),
                    (0.5, 0.0),
                ];
                let i = p.partition_point(|q| q.0 <= t).clamp(1, 5);
                let (a, b) = (p[i - 1], p[i]);
                a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0)
            }),
            "joined by straight lines",
        ),
    ];
    for (name, drive, words) in cases {
        for error in [(0.0, 0.0), (5e-3, 0.0), (20e-3, 0.0)] {
            let (time, volts) = sampled(&drive, 50e3, 0.4, error, 8);
            let found = recognised(&time, &volts);
            assert!(
                found.recognised && found.text.contains(words),
                "{name} {error:?}: {}",
                found.text
            );
        }
    }
}

#[test]
fn pieces_follow_one_another_and_meet_the_samples() {
    let rough = |t: f64| {
        5.0 * (90.0 * t).sin() * (-3.0 * t).exp()
            + 2.0 * (37.0 * t * t).cos()
            + 0.6 * (t * 400.0).sin().powi(3)
    };
    for (drive, what) in [
        (Box::new(rough) as Box<dyn Fn(f64) -> f64>, "smooth"),
        (
            Box::new(|t: f64| if t < 0.2 { rough(t) } else { rough(t) + 6.0 }),
            "with a jump",
        ),
    ] {
        for error in [(0.0, 0.0), (1e-3, 0.0), (20e-3, 0.0), (0.0, 0.08)] {
            let (time, volts) = sampled(&drive, 50e3, 0.4, error, 9);
            let found = recognised(&time, &volts);
            assert!(!found.recognised, "{what} {error:?}: {}", found.text);
            for pair in found.pieces.windows(2) {
                assert_eq!(pair[0].end, pair[1].start, "{what} {error:?}");
            }
            for edge in &found.edges {
                assert_eq!(found.pieces[edge.piece].start, edge.time);
            }
            let waveform = found.waveform("test", 0.0);
            let squares: f64 = time
                .iter()
                .filter(|t| (**t - 0.2).abs() > 1e-4)
                .map(|&t| (waveform.voltage(t) - drive(t)).powi(2))
                .sum();
            let rms = (squares / time.len() as f64).sqrt();
            let allowed = 0.35 * error.0 + 0.4 * error.1 + 1e-5;
            assert!(rms < allowed, "{what} {error:?}: {rms:e} V");
            assert!(
                found.pieces.len() < time.len() / 4,
                "{}",
                found.pieces.len()
            );
        }
    }
}

#[test]
fn turns_of_a_smooth_voltage_are_found_between_samples() {
    let drive = |t: f64| 6.0 * (TAU * 20.0 * t + 0.9 * (TAU * 3.0 * t).sin()).sin();
    let turn = |t: f64| 20.0 * t + 0.9 * (TAU * 3.0 * t).sin() / TAU;
    for (noise, allowed) in [(0.0, 2e-7), (1e-3, 1e-6)] {
        let (time, volts) = sampled(drive, 50e3, 0.4, (noise, 0.0), 4);
        let found = recognised(&time, &volts);
        let mut worst = 0.0f64;
        assert_eq!(found.edges.len(), 16, "{}", found.text);
        for edge in &found.edges {
            let phase = 2.0 * turn(edge.time) - 0.5;
            let off = (phase - phase.round()).abs() / 40.0;
            worst = worst.max(off);
        }
        assert!(worst < allowed, "{noise}: {worst:e} s");
    }
}

#[test]
fn a_shift_in_time_and_the_unit_change_nothing() {
    let drive = Waveform::parse("ramped:7.3Hz:6.1V:0.2", 1.0).unwrap();
    let (time, volts) = sampled(|t| drive.voltage(t - 0.013), 50e3, 0.4, (5e-3, 0.0), 6);
    let found = recognised(&time, &volts);
    let later: Vec<f64> = time.iter().map(|t| t + 1.0).collect();
    let shifted = recognised(&later, &volts);
    assert_eq!(found.pieces.len(), shifted.pieces.len());
    for (a, b) in found.pieces.iter().zip(&shifted.pieces).skip(1) {
        assert!(
            (a.start + 1.0 - b.start).abs() < 1e-9,
            "{} {}",
            a.start,
            b.start
        );
        assert_eq!(a.branch, b.branch);
    }
    let moved = found.waveform("test", 1.0);
    for &t in time.iter().step_by(97) {
        assert!((moved.voltage(t + 1.0) - found.waveform("test", 0.0).voltage(t)).abs() < 1e-9);
    }
}

#[test]
#[ignore = "a measurement: how long ten million samples take"]
fn time_of_ten_million_samples() {
    for text in [
        "smooth",
        "square:15Hz:8V",
        "ramped:5Hz:8V:0.25",
        "sine:50Hz:8V",
        "square:900Hz:8V",
    ] {
        for error in [(0.0, 0.0), (5e-3, 0.0), (0.0, 0.08)] {
            let rough = |t: f64| 5.0 * (90.0 * t).sin() + 2.0 * (37.0 * t + (9.0 * t).sin()).cos();
            let plain = Waveform::parse(text, 1.0).unwrap_or_default();
            let drive = |t: f64| {
                if text == "smooth" {
                    rough(t)
                } else {
                    plain.voltage(t)
                }
            };
            let (time, volts) = sampled(drive, 50e3, 200.0, error, 1);
            let started = std::time::Instant::now();
            let found = recognised(&time, &volts);
            println!(
                "{text} {error:?}: {:.2} s, {}",
                started.elapsed().as_secs_f64(),
                found.text
            );
        }
    }
}

#[test]
fn corners_that_somebody_typed_are_joined_by_straight_lines() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for count in [64, 82, 120, 300] {
        for uneven in [false, true] {
            let mut at = 0.0;
            let mut time = Vec::new();
            for k in 0..count {
                time.push(at);
                at = if uneven {
                    at + 1e-4 + 2e-3 * rng.random::<f64>()
                } else {
                    1e-3 * f64::from(k + 1)
                };
            }
            let volts: Vec<f64> = time
                .iter()
                .map(|_| 16.0 * rng.random::<f64>() - 8.0)
                .collect();
            let drive = measured_drive("x", &time, &volts, DriveReading::Recognised).unwrap();
            let waveform = drive.waveform("x", 0.0);
            for (t, v) in time.windows(2).zip(volts.windows(2)) {
                for share in [0.0, 0.3, 0.5, 0.9] {
                    let (t, v) = (t[0] + share * (t[1] - t[0]), v[0] + share * (v[1] - v[0]));
                    let off = waveform.voltage(t) - v;
                    assert!(
                        off.abs() < 1e-9,
                        "{count} {uneven}: {off} V at {t}: {}",
                        drive.text
                    );
                }
            }
        }
    }
}
