//! Contacts, impacts and features found in sampled traces of the simulator, against
//! what the simulator knows: the 16 drives of Table A.1.

use impactscope::model::drive::Waveform;
use impactscope::model::preset::Preset;
use impactscope::recording::TimeAxis;
use impactscope::recording::features::{FeatureOptions, features};
use impactscope::sim::{EventKind, Options, Trace, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const LEVEL: f64 = -58e-6;

fn runs() -> Vec<(String, Trace)> {
    let model = Preset::default().model;
    let mut runs = Vec::new();
    for frequency in [5.0, 15.0, 50.0, 100.0] {
        for amplitude in [6.0, 8.0] {
            for (name, drive) in [
                (
                    "square",
                    Waveform::Square {
                        frequency,
                        amplitude,
                    },
                ),
                (
                    "sine",
                    Waveform::Sine {
                        frequency,
                        amplitude,
                    },
                ),
            ] {
                let trace = simulate(&model, &drive, 6.0 / frequency, &Options::default()).unwrap();
                runs.push((format!("{name} {frequency} Hz {amplitude} V"), trace));
            }
        }
    }
    runs
}

fn axis(trace: &Trace) -> TimeAxis<'static> {
    TimeAxis::Uniform {
        t0: trace.t0,
        dt: trace.dt,
    }
}

fn noisy(values: &[f64], sigma: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    values
        .iter()
        .map(|x| {
            let (a, b): (f64, f64) = (rng.random(), rng.random());
            x + sigma * (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
        })
        .collect()
}

/// Impacts of the simulator that can be told apart from their neighbours at 50 kHz,
/// as (time, speed before, speed after).
fn separate_impacts(trace: &Trace) -> Vec<(f64, f64, f64)> {
    let at_ground: Vec<_> = trace
        .events
        .iter()
        .filter(|e| e.kind != EventKind::DriveStep)
        .collect();
    at_ground
        .iter()
        .filter(|e| matches!(e.kind, EventKind::Impact | EventKind::Stick))
        .filter(|e| e.velocity_before < -0.02 && e.time < trace.end() - 1e-4)
        .filter(|e| {
            at_ground
                .iter()
                .all(|o| o.time == e.time || (o.time - e.time).abs() > 1e-4)
        })
        .map(|e| (e.time, e.velocity_before, e.velocity_after))
        .collect()
}

#[test]
fn impacts_are_the_simulators() {
    for (sigma, least, v_median) in [(0.0, 0.97, 0.05), (20e-9, 0.93, 0.10)] {
        let (mut separate, mut found) = (0, 0);
        let mut errors = Vec::new();
        for (seed, (name, trace)) in runs().into_iter().enumerate() {
            let x = noisy(&trace.proof_mass, sigma, seed as u64);
            let given = FeatureOptions {
                contact_level: Some(LEVEL),
                ..FeatureOptions::default()
            };
            let f = features(axis(&trace), Some(&trace.voltage), &x, &given);
            for impact in &f.events.impacts {
                let real = trace
                    .events
                    .iter()
                    .any(|e| (e.time - impact.time).abs() < 4e-5);
                assert!(real, "{name}: invented {impact:?}");
            }
            for (time, before, _) in separate_impacts(&trace) {
                separate += 1;
                let same = f
                    .events
                    .impacts
                    .iter()
                    .find(|i| (i.time - time).abs() < 1e-5);
                if let Some(impact) = same {
                    found += 1;
                    errors.push((impact.v_before / before - 1.0).abs());
                }
            }
        }
        errors.sort_by(f64::total_cmp);
        let median = errors[errors.len() / 2];
        println!(
            "noise {sigma:e} m: {found} of {separate} found, arriving speed within {:.1} % (median)",
            100.0 * median
        );
        assert!(separate >= 60 && f64::from(found) >= least * f64::from(separate));
        assert!(median < v_median, "{median}");
    }
}

#[test]
fn contacts_and_level_are_the_simulators() {
    for (seed, (name, trace)) in runs().into_iter().enumerate() {
        let sustained: Vec<(f64, f64)> = trace
            .contacts
            .iter()
            .copied()
            .filter(|c| c.1 - c.0 > 2e-4)
            .collect();
        let x = noisy(&trace.proof_mass, 20e-9, seed as u64);
        // Nothing given: the level is found from the data, or its absence said.
        let f = features(
            axis(&trace),
            Some(&trace.voltage),
            &x,
            &FeatureOptions::default(),
        );
        match &f.contact_level {
            Ok(level) => assert!(
                !sustained.is_empty() && (level - LEVEL).abs() < 5e-8,
                "{name}: {level}"
            ),
            Err(reason) => assert!(sustained.is_empty(), "{name}: {reason}"),
        }
        for (start, end) in sustained {
            let covered = f
                .events
                .contacts
                .iter()
                .any(|c| c.start < start + 5e-5 && c.end > end - 5e-5);
            assert!(covered, "{name}: {start} to {end}");
        }
        let steady = f.steady.unwrap_or_else(|e| panic!("{name}: {e}"));
        // The last whole periods of the run, straight from the simulator's samples.
        let period = f.period.unwrap();
        let last = (period / trace.dt).round() as usize;
        let tail = trace.len() - last..trace.len();
        let lowest = tail
            .clone()
            .map(|i| trace.proof_mass[i])
            .fold(f64::MAX, f64::min);
        let highest = |counts: &dyn Fn(usize) -> bool| {
            let chosen = tail.clone().filter(|i| counts(*i));
            chosen.map(|i| trace.proof_mass[i]).fold(f64::MIN, f64::max)
        };
        let peak = steady.peak_amplitude.unwrap().mean;
        if name.starts_with("sine") {
            // The ring that starts when the voltage turns upwards is none of it.
            let falling = highest(&|i| trace.voltage[i] < trace.voltage[i - 1]) - lowest;
            assert!(
                (peak / falling - 1.0).abs() < 0.02,
                "{name}: {peak} of {falling}"
            );
        } else {
            let travel = highest(&|_| true) - lowest;
            assert!(
                peak < travel * 1.02 && peak > travel * 0.8,
                "{name}: {peak} of {travel}"
            );
        }
    }
}
