//! Features of recordings against those of the run that they were made from, and bounces against
//! the events of the simulator: several drives, noises and rates, and the period recognised from the
//! recorded voltage.

use impactscope::model::drive::{DriveReading, Waveform};
use impactscope::model::preset::Preset;
use impactscope::model::sensor::Sensor;
use impactscope::recording::features::{FeatureOptions, Features, features, recording_features};
use impactscope::recording::{Recording, TimeAxis};
use impactscope::sim::{EventKind, Options, Trace, simulate};

/// Drives and spans, all of them whole periods.
const CASES: [(&str, f64); 5] = [
    ("square:15Hz:8V", 0.2),
    ("sine:15Hz:8V", 0.2),
    ("square:50Hz:8V", 0.1),
    ("sine:50Hz:8V", 0.1),
    ("ramped:5Hz:8V:0.2", 0.6),
];
/// Departures up to this height do not end a contact [m]; longer contacts are sustained [s].
const HOP: f64 = 5e-6;
const SUSTAINED: f64 = 2e-4;

fn run(drive: &Waveform, span: f64, rate: f64) -> Trace {
    let options = Options {
        rate,
        ..Options::default()
    };
    simulate(&Preset::default().model, drive, span, &options).unwrap()
}

/// As the window has them of a run.
fn of_run(trace: &Trace, drive: &Waveform) -> Features {
    let options = FeatureOptions {
        contact_level: trace.ground_level,
        period: drive.period(),
        noise: Some(0.0),
        ..FeatureOptions::default()
    };
    let axis = TimeAxis::Uniform {
        t0: trace.t0,
        dt: trace.dt,
    };
    features(axis, Some(&trace.voltage), &trace.proof_mass, &options)
}

/// As the window has them of a recording: nothing given but the period that its voltage shows.
fn of_recording(recording: &Recording) -> Features {
    let drive = recording.drive(DriveReading::Recognised);
    let options = FeatureOptions {
        period: drive.and_then(Result::ok).and_then(|drive| drive.period()),
        ..FeatureOptions::default()
    };
    recording_features(recording, &options)
}

/// A recording of the first `samples` samples of a run.
fn recorded(trace: &Trace, samples: usize, noise: f64) -> Recording {
    let mut xp = trace.proof_mass.clone();
    let sensor = Sensor {
        noise,
        ..Sensor::default()
    };
    sensor.add_noise(&mut xp, 7);
    let (mut time, mut voltage) = (trace.times(), trace.voltage.clone());
    time.truncate(samples);
    voltage.truncate(samples);
    xp.truncate(samples);
    Recording::new("made", time, Some(voltage), xp, None).unwrap()
}

fn bounces(features: &Features) -> Vec<u32> {
    features.periods.iter().filter_map(|p| p.bounces).collect()
}

/// Bounces of each period from the simulator's events: departures above a hop before the sustained
/// contact.
fn bounces_by_events(drive: &Waveform, span: f64) -> Vec<u32> {
    let fine = run(drive, span, 1e6);
    let index = |t: f64| (((t - fine.t0) / fine.dt) as usize).min(fine.len() - 1);
    let impacts = fine.events.iter().filter(|e| e.kind == EventKind::Impact);
    let mut stays: Vec<(f64, f64)> = impacts.map(|e| (e.time, e.time)).collect();
    stays.extend(&fine.contacts);
    stays.sort_by(|a, b| a.0.total_cmp(&b.0));
    let level = fine.ground_level.unwrap();
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (start, end) in stays {
        let flight = |last: f64| {
            let aloft = &fine.proof_mass[index(last)..=index(start)];
            aloft.iter().copied().fold(f64::NEG_INFINITY, f64::max) - level
        };
        match merged.last_mut() {
            Some(last) if flight(last.1) <= HOP => last.1 = last.1.max(end),
            _ => merged.push((start, end)),
        }
    }
    let period = drive.period().unwrap();
    let count = (span / period + 1e-6).floor() as u32;
    let of_period = |k: u32| {
        let (from, to) = (f64::from(k) * period, f64::from(k + 1) * period);
        let own = merged.iter().filter(|s| s.1 >= from && s.0 < to);
        let sustained = own.clone().position(|s| s.1 - s.0 > SUSTAINED);
        sustained.unwrap_or(0) as u32
    };
    (0..count).map(of_period).collect()
}

#[test]
fn features_of_recordings_are_those_of_the_run() {
    for (text, span) in CASES {
        let drive = Waveform::parse(text, span).unwrap();
        for rate in [50e3, 100e3] {
            let trace = run(&drive, span, rate);
            let own = of_run(&trace, &drive);
            let steady = own
                .steady
                .as_ref()
                .unwrap_or_else(|e| panic!("{text}: {e}"));
            for noise in [20e-9, 150e-9] {
                let name = format!("{text} at {rate} Hz with {noise} m");
                let found = of_recording(&recorded(&trace, trace.len(), noise));
                let same = found
                    .steady
                    .as_ref()
                    .unwrap_or_else(|e| panic!("{name}: {e}"));
                assert_eq!(found.periods.len(), own.periods.len(), "{name}");
                let (a, b) = (found.period.clone().unwrap(), own.period.clone().unwrap());
                assert!((a / b - 1.0).abs() < 1e-3, "{name}: {a} of {b}");
                let peaks = same.peak_amplitude.zip(steady.peak_amplitude);
                let (a, b) = peaks.unwrap_or_else(|| panic!("{name}: no peak"));
                assert!((a.mean / b.mean - 1.0).abs() < 0.01, "{name}: {a:?} {b:?}");
                // Where the ground does not show, the recording says so.
                if found.contact_level.is_err() {
                    assert!(steady.contact_duration.unwrap().mean < SUSTAINED, "{name}");
                    continue;
                }
                assert_eq!(bounces(&found), bounces(&own), "{name}");
                assert_eq!(found.bounces_sentence(), own.bounces_sentence(), "{name}");
                let contacts = same.contact_duration.zip(steady.contact_duration);
                let (a, b) = contacts.unwrap();
                // Hops lower than the noise shows count as on the ground.
                let most = if noise < 1e-7 { 2e-4 } else { 4e-4 };
                assert!((a.mean - b.mean).abs() < most, "{name}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn bounces_are_those_of_the_events() {
    for (text, span) in [("square:15Hz:8V", 0.2), ("square:50Hz:8V", 0.1)] {
        let drive = Waveform::parse(text, span).unwrap();
        let expected = bounces_by_events(&drive, span);
        for rate in [50e3, 100e3] {
            let found = bounces(&of_run(&run(&drive, span, rate), &drive));
            assert_eq!(found, expected, "{text} at {rate} Hz");
        }
    }
}

#[test]
fn all_whole_periods_count_with_or_without_the_last_sample() {
    for (text, span, periods) in [
        ("square:15Hz:8V", 2.0 / 15.0, 2),
        ("sine:15Hz:8V", 2.0 / 15.0, 2),
        ("sine:15Hz:8V", 0.2, 3),
        ("square:50Hz:8V", 0.1, 5),
    ] {
        let drive = Waveform::parse(text, span).unwrap();
        let trace = run(&drive, span, 50e3);
        let last = (span * 50e3).round() as usize;
        for samples in [last, last + 1] {
            let recording = recorded(&trace, samples.min(trace.len()), 20e-9);
            let found = of_recording(&recording);
            assert_eq!(found.periods.len(), periods, "{text}: {samples} samples");
            assert!(found.steady.is_ok(), "{text}: {:?}", found.steady);
        }
    }
}
