//! Whole trials: the same seed gives the same bytes, strength zero is the baseline,
//! files read back.

use super::concealed::concealed_effects::{CATALOGUE, OUTSIDE, choose};
use super::concealed::law::Law;
use super::device::reference_device::{excitations, table_beam, table_device, table_modes};
use super::device::structure::Structure;
use super::device::{Device, TOLERANCE};
use super::hybrid::run;
use super::rig::Maker;
use super::rigs::RIGS;
use super::rng::TrialRng;
use super::voltage::pieces;
use crate::model::effects;
use crate::recording::Channel;
use crate::recording::csv::import_auto;
use crate::trial::*;

fn of(mix: Mix) -> Settings {
    Settings {
        mix,
        ..Settings::default()
    }
}

#[test]
fn a_seed_determines_everything() {
    let a = Case::draw(7, &Settings::default()).unwrap();
    let b = Case::draw(7, &Settings::default()).unwrap();
    assert_eq!(a.seal(), b.seal());
    for (a, b) in a.recordings().train.iter().zip(&b.recordings().train) {
        assert_eq!(a.proof_mass, b.proof_mass);
        assert_eq!(a.cantilever, b.cantilever);
    }
    let c = Case::draw(8, &Settings::default()).unwrap();
    assert_ne!(a.seal(), c.seal());
}

#[test]
fn files_read_back_bit_for_bit_and_the_seal_fits() {
    use sha2::{Digest, Sha256};
    let case = Case::draw(3, &of(Mix::Only(Class::Nothing))).unwrap();
    let seal = case.seal().to_owned();
    let (recordings, envelope) = case.into_parts();
    let folder = tempfile::tempdir().unwrap();
    let files = write_case(folder.path(), &recordings).unwrap();
    assert_eq!((files.train.len(), files.held_out.len()), (5, 4));
    let all = recordings.train.iter().chain(&recordings.held_out);
    for (path, made) in files.train.iter().chain(&files.held_out).zip(all) {
        let read = import_auto(path, None).unwrap();
        for channel in Channel::ALL {
            let (a, b) = (read.channel(channel), made.channel(channel));
            let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-14;
            assert!(a.unwrap().iter().zip(b.unwrap()).all(close));
        }
        assert!(read.warnings.is_empty());
    }
    let path = folder.path().join("truth.json");
    write_truth(&path, envelope).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let digest = Sha256::digest(&bytes);
    let hex: String = digest.iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(hex, seal);
    let truth: Truth = serde_json::from_slice(&bytes).unwrap();
    assert!(truth.effects.is_empty());
}

fn motion(device: &Device, law: Option<&Law>, which: usize) -> Vec<f64> {
    let e = excitations()[which];
    let times: Vec<f64> = (0..(e.duration * 2e4) as usize)
        .map(|i| i as f64 / 2e4)
        .collect();
    let mut device = device.clone();
    let mut path = pieces(&e.waveform, e.duration);
    let mut late = times.clone();
    if let Some(law) = law {
        law.install(&mut device, which, e.duration);
        path = law.alter_drive(path);
        law.note_history(&mut path);
        late.iter_mut().for_each(|t| *t -= law.delay());
    }
    let mut xp = run(&device, &path, e.duration, &late, TOLERANCE)
        .unwrap()
        .proof_mass;
    for (x, t) in xp.iter_mut().zip(&times) {
        *x += law.map_or(0.0, |law| law.zero(*t));
    }
    xp
}

#[test]
fn strength_zero_is_the_baseline() {
    let lumped = table_device(Structure::lumped(&table_modes(), 0.0).unwrap());
    let beam = table_device(table_beam().unwrap());
    for device in [lumped, beam] {
        for id in CATALOGUE.iter().chain(&OUTSIDE) {
            for seed in 0..3 {
                let choice = choose(id, &device, &mut TrialRng::new(seed, 0)).unwrap();
                // Short enough that impacts do not magnify rounding.
                let worst = |strength: f64, which: usize| {
                    let plain = motion(&device, None, which);
                    let law = choice.law.scaled(strength);
                    let with = motion(&device, Some(&law), which);
                    plain
                        .iter()
                        .zip(&with)
                        .take(600)
                        .fold(0.0f64, |w, (a, b)| w.max((a - b).abs()))
                };
                // A ground of no compliance, gas of no elasticity and lags of no length
                // are limits, not values: the lags are brought nearer theirs, not below the
                // microsecond of the grid on which an amplifier is followed.
                let lag = matches!(
                    choice.law,
                    Law::Term(crate::trial::concealed::hidden_forces::Term::SensorLag { .. })
                ) || matches!(choice.law, Law::Amplifier(_));
                if lag {
                    let (a, b) = (worst(1.0, 1), worst(0.1, 1));
                    assert!(b < 0.3 * a, "{id} {}: {a:e} {b:e}", choice.formulation);
                } else if !matches!(choice.law, Law::Ground(_) | Law::Film { .. }) {
                    let zero = worst(0.0, 1);
                    assert!(zero < 2e-9, "{id} {}: {zero:e}", choice.formulation);
                }
            }
        }
    }
}

#[test]
fn every_effect_of_the_catalogue_can_be_concealed() {
    let ids: Vec<&str> = effects::CATALOGUE.iter().map(|e| e.id).collect();
    let of_one_mode: Vec<&str> = (RIGS.iter())
        .filter_map(|rig| match rig.maker {
            Maker::OneMode(one) => Some(one.effects),
            _ => None,
        })
        .flatten()
        .copied()
        .collect();
    let missing: Vec<&&str> = (ids.iter())
        .filter(|id| !CATALOGUE.contains(id) && !of_one_mode.contains(id))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
    let unknown: Vec<&&str> = CATALOGUE.iter().filter(|id| !ids.contains(id)).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

#[test]
fn all_that_can_be_concealed_can_be_drawn() {
    for (seed, id) in CATALOGUE.iter().chain(&OUTSIDE).enumerate() {
        let started = std::time::Instant::now();
        let mix = of(Mix::Effect((*id).to_owned()));
        let case = Case::draw(seed as u64, &mix).unwrap();
        let truth = case.truth();
        println!(
            "{id}: {:.2} x smallest visible, {:?} nN, {}, {:?}",
            truth.effects[0].times_smallest_visible,
            truth.effects[0].size_nn,
            truth.effects[0].formulation,
            started.elapsed()
        );
        for r in &case.recordings().train {
            assert!(r.proof_mass.iter().all(|x| x.abs() < 1e-3));
        }
    }
}

#[test]
fn a_weight_is_invisible_to_first_order() {
    // A weight is absorbed by zero, gap, ground and adhesion; what the linear projection
    // leaves of it is of second order and falls with its square.
    for structure in [StructureKind::Lumped, StructureKind::Beam] {
        let size = |force: f64| {
            let (device, _) =
                crate::trial::instrument::device(structure, &mut TrialRng::new(5, 0)).unwrap();
            let instruments = crate::trial::instrument::instruments(
                50e3,
                20e-9,
                true,
                9,
                &mut TrialRng::new(5, 1),
            );
            let law = Law::Term(crate::trial::concealed::hidden_forces::Term::Weight { force });
            crate::trial::draw::size::visibility(&device, &instruments, &law).unwrap()
        };
        let (full, tenth, none) = (size(3.4e-9), size(3.4e-10), size(0.0));
        println!("{structure:?}: {full} {tenth} {none}");
        // The solver's own floor, a tenth of the smallest size that is drawn.
        assert!(none < 0.05, "{none}");
        assert!(tenth < 0.05 * full + 2.0 * none, "{tenth} of {full}");
    }
}
