//! Each rig's recordings have the properties that it claims, and tell nothing else.

use super::instrument::{Imperfections, Instruments};
use super::rig::{ActuatorRig, Maker};
use super::rigs::{RIGS, find};
use super::rng::TrialRng;
use super::voltage::{Waveform, pieces, voltage};
use crate::model::effects::CATALOGUE;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::trial::device::reference_device::excitations;
use crate::trial::*;

/// The trial of a rig with nothing concealed: it is made quickly.
fn plain(rig: &str, seed: u64) -> Case {
    let settings = Settings {
        mix: Mix::Only(Class::Nothing),
        ..Settings::of_rig(rig)
    };
    Case::draw(seed, &settings).unwrap()
}

/// An actuator's rig as the first attempt of a seed draws it.
fn actuator(rig: &str, seed: u64) -> ActuatorRig {
    match find(rig).unwrap().maker {
        Maker::Actuator(draw) => draw(&mut TrialRng::new(seed, 8)),
        _ => panic!("{rig} is no actuator"),
    }
}

fn all(case: &Case) -> Vec<&Recording> {
    let recordings = case.recordings();
    let both = recordings.train.iter().chain(&recordings.held_out);
    both.map(|r| &**r).collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(n, s), v| (n + 1.0, s + v * v));
    (sum / f64::max(count, 1.0)).sqrt()
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
        assert_eq!((instruments.noise, instruments.rate), (noise, rate), "{rig}");
        for recording in all(&case) {
            assert_eq!(recording.cantilever.is_some(), cantilever, "{rig}");
            assert!((recording.sampling_rate() / rate - 1.0).abs() < 1e-6, "{rig}");
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
        assert!((shown / instruments.rate - 1.0).abs() < 0.02, "{rig}: {shown}");
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
    assert!((found / expected - 1.0).abs() < 0.1, "{found:e} {expected:e}");
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
        assert!((recording.sampling_rate() * recording.interval() - 1.0).abs() < 1e-9);
        assert!((recording.sampling_rate() / instruments.rate - 1.0).abs() < 0.02);
    }
}

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
            assert!(x.iter().all(|x| (x / step - (x / step).round()).abs() < 1e-6));
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

#[test]
fn a_rescaled_trial_is_another_one_in_other_units() {
    let mut bases = std::collections::BTreeSet::new();
    for seed in 0..12 {
        let case = plain("rescaled", seed);
        let units = case.truth().units.expect("units");
        let twin = ["both-points", "spring", "ball", "pendulum"]
            .into_iter()
            .find(|rig| {
                let other = plain(rig, seed);
                let (a, b) = (all(&case), all(&other));
                a.len() == b.len()
                    && a.iter().zip(&b).all(|(a, b)| {
                        let scaled = b.proof_mass.iter().map(|x| x * units.length);
                        a.proof_mass.iter().copied().eq(scaled)
                            && a.time.iter().copied().eq(b.time.iter().map(|t| t * units.time))
                            && a.voltage == b.voltage
                    })
            })
            .unwrap_or_else(|| panic!("seed {seed}"));
        bases.insert(twin);
        let other = plain(twin, seed);
        let model = |case: &Case| match case.preset() {
            Some(text) => Preset::parse("test", text).unwrap().model,
            None => Preset::default().model,
        };
        let (new, old) = (model(&case), model(&other));
        assert!((new.proof_mass / old.proof_mass / units.mass - 1.0).abs() < 1e-9);
        let f1 = |model: &crate::model::Model| model.get("f1").unwrap();
        assert!((f1(&new) * units.time - f1(&old)).abs() <= 1e-9 * f1(&old));
        // The noise is stated in the recordings' unit.
        let ratio = case.truth().noise() / other.truth().noise();
        assert!((ratio / units.length - 1.0).abs() < 1e-9);
    }
    assert!(bases.len() >= 3, "{bases:?}");
}

#[test]
fn sizes_are_those_asked_for() {
    for (rig, id) in [("spring", "dry_friction"), ("ball", "quadratic_drag")] {
        for seed in 0..8 {
            let settings = Settings {
                mix: Mix::Effect(id.into()),
                sizes: Some((4.0, 5.0)),
                ..Settings::of_rig(rig)
            };
            let case = Case::draw(seed, &settings).unwrap();
            let size = case.truth().effects[0].times_smallest_visible;
            assert!((3.99..5.01).contains(&size), "{rig}: {size}");
        }
    }
    let two = Settings {
        mix: Mix::Only(Class::Two),
        ..Settings::of_rig("spring")
    };
    for seed in 0..10 {
        let case = Case::draw(seed, &two).unwrap();
        let effects = &case.truth().effects;
        assert_eq!(effects.len(), 2);
        assert_ne!(effects[0].id, effects[1].id);
        for effect in effects {
            assert!((0.5..30.5).contains(&effect.times_smallest_visible));
        }
    }
    for sizes in [(0.0, 1.0), (3.0, 2.0), (1.0, 1e4), (f64::NAN, 2.0)] {
        let bad = Settings {
            sizes: Some(sizes),
            ..Settings::of_rig("spring")
        };
        let error = Case::draw(1, &bad).unwrap_err();
        assert!(error.is_of_settings(), "{error}");
    }
}

#[test]
fn what_a_rig_cannot_have_is_refused() {
    let of = |rig: &str, mix: Mix| {
        let settings = Settings {
            mix,
            ..Settings::of_rig(rig)
        };
        Case::draw(1, &settings).unwrap_err().to_string()
    };
    let unknown = of("swing", Mix::Standard);
    assert!(unknown.contains("both-points") && unknown.contains("rescaled"));
    let gap = of("spring", Mix::Effect("gap_step".into()));
    assert!(gap.contains("spring") && gap.contains("dry_friction"), "{gap}");
    let two = of("ball", Mix::Only(Class::Two));
    assert!(two.contains("two effects"), "{two}");
    let even = Settings {
        mix: Mix::Effect("even_stiffness".into()),
        rig: RigChoice::Each,
        sizes: Some(RIG_SIZES),
        ..Settings::default()
    };
    // Of all rigs one is taken that can.
    let case = Case::draw(7, &even).unwrap();
    assert_eq!(case.truth().effects[0].id, "even_stiffness");
}

#[test]
fn the_seed_says_the_rig_and_each_has_its_turn() {
    let settings = Settings {
        rig: RigChoice::Each,
        mix: Mix::Only(Class::Nothing),
        sizes: Some(RIG_SIZES),
        ..Settings::default()
    };
    let mut seen = Vec::new();
    for seed in 0..RIGS.len() as u64 {
        let case = Case::draw(seed, &settings).unwrap();
        seen.push(case.truth().rig.clone().unwrap());
    }
    assert_eq!(seen, RIGS.map(|rig| rig.id));
}

#[test]
fn a_rig_and_a_seed_determine_every_byte() {
    for rig in RIGS {
        // Effects of actuators take their time to be sized: one of them stands for all.
        let quick = matches!(rig.maker, Maker::OneMode(_));
        let settings = Settings {
            mix: if quick || rig.id == "walking-zero" {
                Mix::Only(Class::One)
            } else {
                Mix::Only(Class::Nothing)
            },
            ..Settings::of_rig(rig.id)
        };
        let bytes = |seed: u64| {
            let case = Case::draw(seed, &settings).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let files = write_case(folder.path(), case.recordings()).unwrap();
            let mut all = vec![case.seal().as_bytes().to_vec()];
            all.push(case.preset().unwrap_or_default().as_bytes().to_vec());
            for path in files.train.iter().chain(&files.held_out) {
                all.push(std::fs::read(path).unwrap());
            }
            all
        };
        assert!(bytes(21) == bytes(21), "{}", rig.id);
        assert!(bytes(21) != bytes(22), "{}", rig.id);
    }
}

#[test]
fn nothing_of_the_truth_reaches_the_diagnosis() {
    // With and without an effect: preset, names, times and the exact voltage are the same.
    for (rig, id) in [
        ("both-points", "quadratic_drag"),
        ("proof-mass-alone", "dry_friction"),
        ("spring", "even_stiffness"),
        ("ball", "quadratic_drag"),
        ("pendulum", "dry_friction"),
        ("rescaled", "quadratic_drag"),
    ] {
        let settings = |mix| Settings {
            mix,
            ..Settings::of_rig(rig)
        };
        // Seeds whose first attempt is followed in both.
        let with = Case::draw(33, &settings(Mix::Effect(id.into()))).unwrap();
        let without = Case::draw(33, &settings(Mix::Only(Class::Nothing))).unwrap();
        assert_eq!(with.preset(), without.preset(), "{rig}");
        let (a, b) = (all(&with), all(&without));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert_eq!((&a.name, &a.time), (&b.name, &b.time), "{rig}");
            assert_eq!(a.voltage, b.voltage, "{rig}");
            assert!(a.path.is_none() && a.sha256.is_none() && a.warnings.is_empty());
            assert_ne!(a.proof_mass, b.proof_mass, "{rig}");
        }
        // No word of it either: gravity is what a ball falls by.
        let mut words = with.preset().unwrap_or_default().to_owned();
        words.extend(a.iter().map(|r| r.name.as_str()));
        for effect in CATALOGUE.iter().filter(|e| e.id != "gravity") {
            assert!(!words.contains(effect.id), "{rig}: {words}");
        }
        assert!(!words.contains("outside"), "{rig}: {words}");
    }
}

#[test]
fn the_first_trials_keep_their_seeds() {
    // A plain actuator has none of what rigs have.
    let case = Case::draw(546_000, &Settings::default()).unwrap();
    let truth = case.truth();
    assert_eq!((&truth.rig, truth.units), (&None, None));
    assert_eq!(truth.instruments.imperfections, Imperfections::default());
    assert!(truth.instruments.scale_errors.is_empty());
    assert!(case.preset().is_none());
    // As the program before the rigs wrote it, in um: a sample of proof mass and cantilever.
    assert_eq!(truth.effects[0].id, "extra_mode");
    for (recording, sample, xp, xc) in [
        (0, 1, -2.942_981_312_663_211, 1.392_227_782_132_922_5),
        (0, 2498, -64.217_053_281_929_27, -24.961_631_550_965_418),
        (6, 2498, 99.858_415_202_863_84, 34.170_703_901_066_984),
    ] {
        let recording = all(&case)[recording];
        let c = recording.cantilever.as_ref().unwrap()[sample];
        let p = recording.proof_mass[sample];
        assert!((1e6 * p - xp).abs() < 1e-4, "{p:e} {xp}");
        assert!((1e6 * c - xc).abs() < 1e-4, "{c:e} {xc}");
    }
}
