//! What the instruments of the actuators' rigs do to voltage, readings and times.

use super::{all, plain, rms};
use crate::trial::device::reference_device::excitations;
use crate::trial::instrument::{Imperfections, Instruments};
use crate::trial::rig::{ActuatorRig, Maker};
use crate::trial::rigs::find;
use crate::trial::rng::TrialRng;
use crate::trial::voltage::{Waveform, pieces, voltage};
use crate::trial::*;

/// An actuator's rig as the first attempt of a seed draws it.
fn actuator(rig: &str, seed: u64) -> ActuatorRig {
    match find(rig).unwrap().maker {
        Maker::Actuator(draw) => draw(&mut TrialRng::new(seed, 8)),
        _ => panic!("{rig} is no actuator"),
    }
}

/// Recorded minus true voltages of the first excitations of a trial \[V\].
fn voltage_errors(case: &Case) -> Vec<f64> {
    let instruments = &case.truth().instruments;
    let mut errors = Vec::new();
    for (recording, excitation) in all(case).into_iter().zip(excitations()) {
        let path = pieces(&excitation.waveform, excitation.duration);
        let shown = recording.voltage.as_ref().unwrap();
        errors.extend(
            (shown.iter().enumerate()).map(|(i, v)| v - voltage(&path, instruments.instant(i))),
        );
    }
    errors
}

#[test]
fn good_voltages_are_exact_and_others_have_their_noise_or_their_steps() {
    let worst = |case: &Case| {
        let errors = voltage_errors(case);
        errors.iter().fold(0.0f64, |w, e| w.max(e.abs()))
    };
    assert!(worst(&plain("both-points", 1)) < 1e-12);
    // The first seed of each kind.
    let mut kinds = std::collections::BTreeMap::new();
    for seed in 0..200 {
        let imperfections = actuator("voltage-noise", seed).imperfections;
        let kind = format!(
            "{} {}",
            imperfections.voltage_noise, imperfections.voltage_step
        );
        kinds.entry(kind).or_insert(seed);
    }
    assert_eq!(kinds.len(), 5, "{kinds:?}");
    for seed in kinds.into_values() {
        let case = plain("voltage-noise", seed);
        let Imperfections {
            voltage_noise,
            voltage_step,
            ..
        } = case.truth().instruments.imperfections;
        if voltage_step > 0.0 {
            assert_eq!(voltage_step, 0.08);
            for recording in all(&case) {
                for v in recording.voltage.as_ref().unwrap() {
                    let codes = v / voltage_step;
                    assert!((codes - codes.round()).abs() < 1e-9);
                }
            }
            assert!(worst(&case) <= 0.04 + 1e-9);
        } else {
            let found = rms(voltage_errors(&case).into_iter());
            let expected = voltage_noise;
            assert!((found - expected).abs() <= 0.02 * expected, "{found}");
        }
    }
}

#[test]
fn clocks_run_off_by_at_most_their_claim() {
    for seed in 0..12 {
        let case = plain("both-points", seed);
        let instruments = &case.truth().instruments;
        let off = instruments.imperfections.clock_error;
        assert!(off != 0.0 && off.abs() <= 3e-4);
        assert!(instruments.skew.abs() <= 10e-6);
        assert!((all(&case)[0].sampling_rate() / 50e3 - 1.0).abs() < 1e-9);
    }
    // A recorder that is fast shows a slower square than was set, by as much.
    let mut instruments = plain("both-points", 0).truth().instruments.clone();
    instruments.imperfections.clock_error = 3e-4;
    let square = Waveform::Square {
        frequency: 15.0,
        amplitude: 8.0,
    };
    let path = pieces(&square, 0.2);
    let edge = (0..6000).rfind(|&i| voltage(&path, instruments.instant(i)) > 0.0);
    let shown = edge.unwrap() as f64 / instruments.rate;
    assert!((shown / 0.1 - 1.0003).abs() < 2.5e-4, "{shown}");
}

#[test]
fn readings_have_the_noise_that_is_claimed() {
    for (rig, noise, rate, cantilever) in [
        ("both-points", 20e-9, 50e3, true),
        ("voltage-noise", 20e-9, 50e3, true),
        ("proof-mass-alone", 20e-9, 50e3, false),
        ("coarse", 150e-9, 25e3, true),
        ("beam", 20e-9, 50e3, true),
    ] {
        let case = plain(rig, 5);
        let instruments = &case.truth().instruments;
        assert_eq!(
            (instruments.noise, instruments.rate),
            (noise, rate),
            "{rig}"
        );
        for recording in all(&case) {
            assert_eq!(recording.cantilever.is_some(), cantilever, "{rig}");
            assert!(
                (recording.sampling_rate() / rate - 1.0).abs() < 1e-6,
                "{rig}"
            );
        }
        let mut still = vec![0.0; 200_000];
        instruments.read(&mut still, 1.0, 0.0, &mut TrialRng::new(1, 2));
        let found = rms(still.into_iter());
        assert!((found / noise - 1.0).abs() < 0.05, "{rig}: {found:e}");
    }
    assert!(plain("beam", 5).truth().is_beam());
    assert!(!plain("coarse", 5).truth().is_beam());
    for rig in ["walking-zero", "spot-anew"] {
        let drawn: Vec<ActuatorRig> = (0..400).map(|seed| actuator(rig, seed)).collect();
        let rates: std::collections::BTreeSet<u64> = drawn.iter().map(|r| r.rate as u64).collect();
        let expected = [12_500, 25_000, 50_000, 100_000];
        assert!(rates.into_iter().eq(expected), "{rig}");
        assert!(drawn.iter().all(|r| (20e-9..=150e-9).contains(&r.noise)));
        let case = plain(rig, 1);
        let instruments = &case.truth().instruments;
        let shown = all(&case)[0].sampling_rate();
        assert!(
            (shown / instruments.rate - 1.0).abs() < 0.02,
            "{rig}: {shown}"
        );
    }
}

#[test]
fn zeros_walk_as_far_as_is_claimed() {
    for seed in 0..4 {
        let case = plain("walking-zero", seed);
        let instruments = case.truth().instruments.clone();
        let count = (0.4 * instruments.rate) as usize;
        let end = |stream: u64| {
            let mut still = vec![0.0; count];
            instruments.walk(&mut still, &mut TrialRng::new(4, stream));
            assert_eq!(still[0], 0.0);
            still[count - 1]
        };
        let reached = rms((0..300).map(end));
        let claimed = instruments.imperfections.zero_walk * 0.4f64.sqrt();
        assert!((5e-9..=30e-9).contains(&claimed), "{claimed:e}");
        assert!((reached / claimed - 1.0).abs() < 0.15, "{reached:e}");
    }
    let still = plain("both-points", 3).truth().instruments.clone();
    assert_eq!(still.imperfections.zero_walk, 0.0);
}

#[test]
fn a_walking_zero_is_in_the_readings() {
    // The same seed with and without the walk: the difference is the walk alone.
    let case = plain("walking-zero", 6);
    let instruments = &case.truth().instruments;
    let still = Instruments {
        imperfections: Imperfections {
            zero_walk: 0.0,
            ..instruments.imperfections
        },
        ..instruments.clone()
    };
    let read = |instruments: &Instruments| {
        let mut readings = vec![1e-6; 1000];
        instruments.read(&mut readings, 1.0, 0.0, &mut TrialRng::new(1, 0));
        instruments.walk(&mut readings, &mut TrialRng::new(1, 1));
        readings
    };
    let (a, b) = (read(instruments), read(&still));
    let steps = a.iter().zip(&b).map(|(a, b)| a - b).collect::<Vec<_>>();
    let found = rms(steps.windows(2).map(|w| w[1] - w[0]));
    let expected = instruments.imperfections.zero_walk / instruments.rate.sqrt();
    assert!(
        (found / expected - 1.0).abs() < 0.1,
        "{found:e} {expected:e}"
    );
}

#[test]
fn scales_differ_between_recordings_where_the_spot_is_set_anew() {
    let mut errors = Vec::new();
    for seed in 0..20 {
        let case = plain("spot-anew", seed);
        let instruments = &case.truth().instruments;
        assert_eq!(instruments.scale_errors.len(), 9);
        errors.extend(instruments.scale_errors.iter().flatten().copied());
        let zeros = instruments.zeros.iter().flatten();
        assert!(zeros.map(|z| z.abs()).fold(0.0, f64::max) > 0.5e-6);
        let [first, second] = [instruments.scales(0), instruments.scales(1)];
        assert!(first[0] != second[0] && first[1] != second[1]);
    }
    let spread = rms(errors.into_iter());
    assert!((spread / 5e-3 - 1.0).abs() < 0.15, "{spread}");
    let same = plain("both-points", 3).truth().instruments.clone();
    assert_eq!(same.scales(0), same.scales(8));
}

#[test]
fn written_times_err_by_their_claim_and_come_back_even() {
    let jittered = (0..40).map(|seed| plain("spot-anew", seed));
    let case = (jittered.into_iter())
        .find(|case| case.truth().instruments.imperfections.stamp_jitter > 0.0)
        .expect("every second one");
    let instruments = &case.truth().instruments;
    let jitter = instruments.imperfections.stamp_jitter;
    assert!((0.5e-6..=3e-6).contains(&jitter), "{jitter:e}");
    let stamps = instruments.stamps(20_000, &mut TrialRng::new(1, 1));
    let errors = stamps.iter().enumerate();
    let found = rms(errors.map(|(i, t)| t - i as f64 / instruments.rate));
    assert!((found / jitter - 1.0).abs() < 0.05, "{found:e}");
    assert!(stamps.windows(2).all(|w| w[1] > w[0]));
    for recording in all(&case) {
        // The reader finds the even clock behind them, and says so.
        assert!(recording.is_uniform(), "{}", recording.name);
        assert!(!recording.warnings.is_empty(), "{}", recording.name);
        assert!((recording.sampling_rate() / instruments.rate - 1.0).abs() < 1e-4);
    }
}
