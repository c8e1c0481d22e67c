//! Each fault is found where it was put, and none where there is none: in simulations of every preset,
//! sampled finely and coarsely, with noise and without, and with effects beyond the baseline.

use proptest::prelude::*;

use super::*;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, CATALOGUE};
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::model::{Model, with_effect};
use crate::recording::Recording;
use crate::sim::{Options, simulate};

/// A recording of a device; `noise` \[m\].
fn made(model: &Model, drive: &str, duration: f64, noise: f64, seed: u64) -> Recording {
    let waveform = Waveform::parse(drive, duration).unwrap();
    let mut trace = simulate(model, &waveform, duration, &Options::default()).unwrap();
    if noise > 0.0 {
        let sensor = Sensor {
            noise,
            ..Sensor::default()
        };
        sensor.add_noise(&mut trace.proof_mass, seed);
        sensor.add_noise(&mut trace.cantilever, seed + 1000);
    }
    let volts = (drive != "rest").then(|| trace.voltage.clone());
    let xc = model.has_cantilever.then(|| trace.cantilever.clone());
    Recording::new(drive, trace.times(), volts, trace.proof_mass.clone(), xc).unwrap()
}

fn paper() -> Model {
    Preset::embedded("paper").unwrap().model
}

/// The usual recording, with its displacement changed by `change(sample, time, value)`.
fn changed(drive: &str, change: impl Fn(usize, f64, &mut f64)) -> Recording {
    let mut r = made(&paper(), drive, 0.2, 20e-9, 7);
    for (i, (t, x)) in r.time.iter().zip(&mut r.proof_mass).enumerate() {
        change(i, *t, x);
    }
    r
}

fn thinned(r: &Recording, every: usize) -> Recording {
    let of = |v: &[f64]| v.iter().copied().step_by(every).collect::<Vec<f64>>();
    let volts = r.voltage.as_deref().map(of);
    let xc = r.cantilever.as_deref().map(of);
    Recording::new(r.name.clone(), of(&r.time), volts, of(&r.proof_mass), xc).unwrap()
}

fn only(r: &Recording) -> InstrumentFault {
    let found = r.instrument_faults().faults.clone();
    assert_eq!(found.len(), 1, "{found:?}");
    found.into_iter().next().unwrap()
}

#[test]
fn sound_recordings_have_no_fault() {
    let drives = [
        "square:15Hz:8V",
        "sine:50Hz:6V",
        "square:300Hz:6V",
        "triangle:20Hz:8V",
        "chirp:5:200:7V",
        "ramped:30Hz:8V:0.2",
    ];
    for name in ["paper", "paper-as-printed", "oscillator", "faller"] {
        let model = Preset::embedded(name).unwrap().model;
        // Of the two without a drive the displacements are metres.
        let noises = if model.piezo.is_some() {
            [0.0, 20e-9, 150e-9]
        } else {
            [0.0, 1e-4, 1e-3]
        };
        for (i, drive) in drives.into_iter().enumerate() {
            for noise in noises {
                let r = made(&model, drive, 0.2, noise, i as u64);
                for every in [1, 2, 5, 10, 25] {
                    let found = thinned(&r, every).instrument_faults().faults.clone();
                    assert!(
                        found.is_empty(),
                        "{name} {drive} {noise} {every}: {found:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn physics_beyond_the_model_is_no_fault_of_the_instrument() {
    for effect in CATALOGUE {
        let model = with_effect(&paper(), ActiveEffect::new(effect));
        for (noise, drive) in [(0.0, "square:15Hz:8V"), (20e-9, "sine:50Hz:8V")] {
            let r = made(&model, drive, 0.2, noise, 3);
            let found = r.instrument_faults().faults.clone();
            assert!(found.is_empty(), "{} {drive}: {found:?}", effect.id);
        }
    }
}

#[test]
fn spikes_are_counted_and_left_out() {
    let at = [1000, 2500, 2501, 6000, 9000];
    let r = changed("square:15Hz:8V", |i, _, x| {
        if at.contains(&i) {
            *x += 2e-6;
        }
    });
    let fault = only(&r);
    assert_eq!(
        (fault.kind, fault.count, fault.samples),
        (FaultKind::Spikes, 4, 5)
    );
    assert!((fault.size / 2e-6 - 1.0).abs() < 0.1, "{}", fault.size);
    let r = std::sync::Arc::new(r);
    let usable = r.usable();
    for i in at {
        assert!(usable.proof_mass[i].is_nan() && r.proof_mass[i].is_finite());
    }
    assert_eq!(usable.proof_mass.iter().filter(|x| x.is_nan()).count(), 5);
    assert_eq!(usable.cantilever, r.cantilever);
    // The copy knows what was found, and is its own usable copy.
    assert_eq!(
        usable.instrument_faults().faults,
        r.instrument_faults().faults
    );
    assert!(std::sync::Arc::ptr_eq(&usable, &usable.usable()));
}

#[test]
fn a_spike_of_the_voltage_is_not_its_step() {
    let mut r = made(&paper(), "square:15Hz:8V", 0.2, 20e-9, 7);
    if let Some(volts) = &mut r.voltage {
        volts[4000] = 30.0;
        volts[7000] = -60.0;
    }
    let fault = only(&r);
    assert_eq!(
        (fault.kind, fault.channel, fault.count),
        (FaultKind::Spikes, Channel::Voltage, 2)
    );
    assert_eq!(
        fault.places,
        [(r.time[4000], r.time[4000]), (r.time[7000], r.time[7000])]
    );
}

#[test]
fn held_readings_are_found_in_noise_and_without_it() {
    for noise in [0.0, 20e-9] {
        let mut r = made(&paper(), "square:15Hz:8V", 0.2, noise, 7);
        // In flight, where the mass moves.
        for start in [1720, 2200, 5100] {
            let held = r.proof_mass[start];
            r.proof_mass[start + 1..start + 5].fill(held);
        }
        let found = r.instrument_faults().faults.clone();
        let fault = found
            .iter()
            .find(|f| f.kind == FaultKind::HeldReadings)
            .unwrap();
        // Without noise a turning point hides one.
        let least = if noise > 0.0 { 3 } else { 1 };
        assert!(fault.count >= least && fault.count <= 3, "{found:?}");
        assert_eq!((found.len(), fault.size), (1, 5.0), "{found:?}");
    }
}

#[test]
fn every_frame_twice_is_a_held_reading() {
    let r = made(&paper(), "square:15Hz:8V", 0.2, 20e-9, 7);
    let mut twice = r.clone();
    for i in (1..twice.len()).step_by(2) {
        twice.proof_mass[i] = twice.proof_mass[i - 1];
    }
    let fault = only(&twice);
    assert_eq!(fault.kind, FaultKind::HeldReadings);
    assert!((fault.share() - 0.5).abs() < 0.02, "{}", fault.share());
    // What is left is a recording of half the rate, with the noise that it has.
    let half = std::sync::Arc::new(twice).usable();
    assert!((half.len() as f64 / r.len() as f64 - 0.5).abs() < 0.02);
    assert!((half.interval() / r.interval() - 2.0).abs() < 1e-9);
    assert_eq!(half.voltage.as_ref().map(Vec::len), Some(half.len()));
    let noise = half.noise(Channel::ProofMass).unwrap().sigma;
    assert!((noise / 20e-9 - 1.0).abs() < 0.25, "{noise}");
}

#[test]
fn fringe_jumps_are_multiples_of_one_size() {
    let fringe = 632.8e-9;
    let jumps = [(0.0405, 1.0), (0.052, -2.0), (0.11, 1.0), (0.125, 1.0)];
    let r = changed("square:15Hz:8V", |_, t, x| {
        *x += jumps
            .iter()
            .filter(|(at, _)| t > *at)
            .map(|(_, k)| k * fringe)
            .sum::<f64>();
    });
    let fault = only(&r);
    assert_eq!(fault.kind, FaultKind::FringeJumps);
    assert!(fault.count >= 2, "{fault:?}");
    assert!((fault.size / fringe - 1.0).abs() < 0.1, "{fault:?}");
}

#[test]
fn hum_is_found_while_the_mass_is_held() {
    for (frequency, amplitude) in [(50.0, 100e-9), (60.0, 300e-9), (150.0, 100e-9)] {
        let r = changed("square:8Hz:8V", |_, t, x| {
            *x += amplitude * (std::f64::consts::TAU * frequency * t + 0.7).sin();
        });
        let fault = only(&r);
        let FaultKind::SteadyLine { frequency: found } = fault.kind else {
            panic!("{fault:?}");
        };
        assert!((found - frequency).abs() < 1.0, "{found}");
        assert!((fault.size / amplitude - 1.0).abs() < 0.1, "{}", fault.size);
    }
    // A line of the drive may be motion, and what nothing holds may be shaken.
    for (drive, frequency) in [("square:25Hz:8V", 50.0), ("sine:50Hz:1V", 60.0)] {
        let r = changed(drive, |_, t, x| {
            *x += 100e-9 * (std::f64::consts::TAU * frequency * t).sin()
        });
        assert!(r.instrument_faults().faults.is_empty(), "{drive}");
    }
}

#[test]
fn ac_coupling_is_found_with_its_time_constant() {
    for constant in [0.05, 0.1] {
        let mut r = made(&paper(), "square:15Hz:8V", 0.4, 0.0, 7);
        let mut coupled = 0.0;
        let mut before = r.proof_mass[0];
        for x in &mut r.proof_mass {
            coupled = (coupled + *x - before) * (-2e-5f64 / constant).exp();
            before = *x;
            *x = coupled;
        }
        let sensor = Sensor {
            noise: 20e-9,
            ..Sensor::default()
        };
        sensor.add_noise(&mut r.proof_mass, 5);
        let found = r.instrument_faults().faults.clone();
        let fault = found
            .iter()
            .find(|f| f.kind == FaultKind::AcCoupling)
            .unwrap();
        assert!((fault.size / constant - 1.0).abs() < 0.1, "{found:?}");
    }
}

#[test]
fn coarse_steps_are_said_and_count_as_noise() {
    let step = 1e-6;
    let r = changed("sine:50Hz:6V", |_, _, x| *x = (*x / step).round() * step);
    let fault = only(&r);
    assert_eq!(fault.kind, FaultKind::Quantised);
    assert!((fault.size / step - 1.0).abs() < 1e-3, "{fault:?}");
    let noise = r.noise(Channel::ProofMass).unwrap();
    assert!(noise.sigma >= 0.999 * step / 12f64.sqrt(), "{noise:?}");
}

#[test]
fn clipped_and_missing_readings_have_their_places() {
    let r = made(&paper(), "square:15Hz:8V", 0.2, 20e-9, 7);
    let top = r.proof_mass.iter().copied().fold(f64::MIN, f64::max);
    let mut clipped = r.clone();
    clipped
        .proof_mass
        .iter_mut()
        .for_each(|x| *x = x.min(0.7 * top));
    let fault = only(&clipped);
    assert_eq!(fault.kind, FaultKind::Clipping);
    assert_eq!(fault.size, 0.7 * top);
    let mut gaps = r;
    gaps.proof_mass[500..520].fill(f64::NAN);
    gaps.proof_mass[900] = f64::INFINITY;
    let fault = only(&gaps);
    assert_eq!(
        (fault.kind, fault.count, fault.samples),
        (FaultKind::MissingReadings, 2, 21)
    );
    assert_eq!((fault.size, fault.places[1].0), (20.0, gaps.time[900]));
}

#[test]
fn no_unit_and_no_clock_matters() {
    let at = [1000, 6000];
    let r = changed("square:15Hz:8V", |i, _, x| {
        if at.contains(&i) {
            *x += 2e-6;
        }
    });
    let own = only(&r);
    for (metre, second) in [(1e6, 1.0), (1.0, 1e3), (3.7e-4, 2e5)] {
        let by = |v: &[f64], k: f64| v.iter().map(|x| k * x).collect::<Vec<f64>>();
        let xc = r.cantilever.as_deref().map(|v| by(v, metre));
        let scaled = Recording::new(
            "r",
            by(&r.time, second),
            r.voltage.clone(),
            by(&r.proof_mass, metre),
            xc,
        );
        let found = only(&scaled.unwrap());
        assert_eq!(
            (found.kind, found.count, found.samples),
            (own.kind, own.count, own.samples)
        );
        assert!((found.size / own.size / metre - 1.0).abs() < 1e-9);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Whatever the columns hold, the search ends, keeps to the recording, and says finite things.
    #[test]
    fn any_columns_are_searched(
        xp in prop::collection::vec(prop_oneof![
            8 => -1e-4..1e-4f64,
            1 => Just(f64::NAN),
            1 => Just(0.0),
            1 => prop::num::f64::ANY,
        ], 2..300),
        with_voltage in any::<bool>(),
    ) {
        let time: Vec<f64> = (0..xp.len()).map(|i| 1e-5 * i as f64).collect();
        let volts = with_voltage.then(|| xp.iter().map(|x| (1e5 * x).sin()).collect());
        let r = Recording::new("any", time, volts, xp, None).unwrap();
        let found = r.instrument_faults();
        for fault in &found.faults {
            prop_assert!(fault.count > 0 && fault.samples <= r.len() && fault.size.is_finite());
            prop_assert!(fault.places.len() <= thresholds::MAX_PLACES);
            prop_assert!(!fault.sentence().contains("NaN") && !fault.label().is_empty());
        }
        for channel in Channel::ALL {
            let unusable = found.unusable_samples(channel);
            prop_assert!(unusable.windows(2).all(|w| w[0] < w[1]));
            prop_assert!(unusable.iter().all(|i| *i < r.len()));
        }
    }

    /// A spike of any size beyond the noise and the motion's bends is found where it is.
    #[test]
    fn a_spike_is_found_where_it_is(at in 200usize..9800, height in 1e-6..1e-3f64, down in any::<bool>()) {
        let time: Vec<f64> = (0..10_000).map(|i| 2e-5 * f64::from(i)).collect();
        let mut xp: Vec<f64> = time.iter().map(|t| 1e-4 * (300.0 * t).sin()).collect();
        let sensor = Sensor { noise: 20e-9, ..Sensor::default() };
        sensor.add_noise(&mut xp, at as u64);
        xp[at] += if down { -height } else { height };
        let r = Recording::new("r", time, None, xp, None).unwrap();
        let found = r.instrument_faults();
        prop_assert_eq!(found.unusable_samples(Channel::ProofMass), &[at]);
    }
}
