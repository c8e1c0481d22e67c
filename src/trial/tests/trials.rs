//! Other units, sizes, refusals, seeds, and what a diagnosis gets to see.

use super::{all, plain};
use crate::model::effects::CATALOGUE;
use crate::model::preset::Preset;
use crate::trial::instrument::Imperfections;
use crate::trial::rig::Maker;
use crate::trial::rigs::RIGS;
use crate::trial::*;

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
                            && a.time
                                .iter()
                                .copied()
                                .eq(b.time.iter().map(|t| t * units.time))
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
    assert!(
        gap.contains("spring") && gap.contains("dry_friction"),
        "{gap}"
    );
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
