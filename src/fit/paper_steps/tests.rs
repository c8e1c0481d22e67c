//! The steps on made-up recordings of the `paper` device.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use super::adhesion::{ExcludedRelease, adhesion};
use super::drive::fit_drive;
use super::film::{Film, film};
use super::restitution::restitution;
use super::sensitivity::{TABLE_2_ROWS, ZERO_SHIFT, sensitivity};
use super::{StepError, model_distance_warning};
use crate::fit::contact_readings::{ContactReadings, Release, read_contacts};
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::{FitOptions, Part};
use crate::fit::solve::levenberg_marquardt::Control;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::recording::Recording;
use crate::sim::{Options, simulate};

/// Both points under `drive`, 50 kHz, 20 nm of noise.
pub(crate) fn recording(drive: &str, duration: f64) -> Arc<Recording> {
    made(drive, duration, 50e3, 20e-9, &[])
}

/// Both points under `drive` of a device with other parameters, at a rate \[Hz\] and with
/// a noise \[m\].
pub(crate) fn made(
    drive: &str,
    duration: f64,
    rate: f64,
    noise: f64,
    changes: &[(ParameterId, f64)],
) -> Arc<Recording> {
    let mut model = Preset::default().model;
    for (id, value) in changes {
        model.parameters.set(*id, *value);
    }
    model.parameters.set(ParameterId::Noise, noise);
    let options = Options {
        rate,
        ..Options::default()
    };
    let waveform = Waveform::parse(drive, duration).unwrap();
    let trace = simulate(&model, &waveform, duration, &options).unwrap();
    let (mut xp, mut xc) = (trace.proof_mass.clone(), trace.cantilever.clone());
    let sensor = Sensor::new(&model.parameters);
    sensor.add_noise(&mut xp, 7);
    sensor.add_noise(&mut xc, 8);
    let (times, volts) = (trace.times(), trace.voltage.clone());
    Arc::new(Recording::new(drive, times, Some(volts), xp, Some(xc)).unwrap())
}

fn read(recordings: &[Arc<Recording>]) -> ContactReadings {
    let model = Preset::default().model;
    let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    read_contacts(&model, &parts, &FitOptions::for_model(&model), &control).unwrap()
}

#[test]
fn restitution_is_read_from_the_bounces_alone() {
    let found = restitution("taps", &read(&[recording("square:300Hz:6V", 0.05)])).unwrap();
    println!("{} +- {}, {:?}", found.mean, found.error, found.exponent);
    assert!(found.bounces.len() >= 8);
    assert!((found.mean - 0.378).abs() < 5.0 * found.error, "{found:?}");
    assert!(found.error < 0.003);
    assert!(found.constant > 1e-3, "{found:?}");
    // What does not bounce tells nothing.
    let none = restitution("rest", &ContactReadings::default()).unwrap_err();
    assert!(none.to_string().contains("300 Hz"), "{none}");
}

#[test]
fn readings_with_a_wrong_film_carry_a_warning() {
    let right = restitution("taps", &read(&[recording("sine:300Hz:5.5V", 0.1)])).unwrap();
    println!("{} off {}", right.mean, right.off);
    assert_eq!(model_distance_warning(right.off), None, "{}", right.off);
    let thick = [(ParameterId::Cs, 2.2e-21)];
    let taps = made("sine:300Hz:5.5V", 0.1, 50e3, 20e-9, &thick);
    let wrong = restitution("taps", &read(&[taps])).unwrap();
    println!("{} off {}", wrong.mean, wrong.off);
    assert!((wrong.mean - 0.378).abs() > 5.0 * wrong.error, "{wrong:?}");
    assert!(model_distance_warning(wrong.off).is_some(), "{}", wrong.off);
}

#[test]
fn contacts_of_similar_length_give_a_wide_band() {
    let ramps = [0.1, 0.15, 0.25].map(|l| recording(&format!("ramped:5Hz:8V:{l}"), 0.4));
    let near = adhesion("ramps", &read(&ramps)).unwrap();
    println!("{:?} {:?}", near.rate, near.start);
    let times = near.releases.iter().map(|r| r.contact);
    let (short, long) = times.fold((f64::MAX, 0.0f64), |(s, l), t| (s.min(t), l.max(t)));
    assert!(long < 1.3 * short, "{short} {long}");
    assert!((near.start.0 - 27.43e-9).abs() < 4.0 * near.start.1);
    assert!((near.rate.0 - 1.7e-6).abs() < 4.0 * near.rate.1);
    assert!(near.start.1 < 5e-9, "{:?}", near.start);
    let alike = [recording("ramped:5Hz:8V:0.1", 0.8)];
    let one = adhesion("ramps", &read(&alike)).unwrap_err().to_string();
    assert!(one.contains(" to ") && one.contains("ms"), "{one}");
}

#[test]
fn adhesion_is_read_from_the_releases_alone() {
    let lambdas = [0.05, 0.1, 0.2, 0.3, 0.4];
    // The device's own adhesion, a stronger start that hardly grows, one that grows fast
    // from little; the proof mass alone; five times the noise.
    for (rate, start, both, noise) in [
        (1.7e-6, 27.43e-9, true, 20e-9),
        (0.5e-6, 100e-9, true, 20e-9),
        (3e-6, 10e-9, true, 20e-9),
        (1.2e-6, 50e-9, false, 20e-9),
        (1.2e-6, 50e-9, true, 100e-9),
    ] {
        let law = [(ParameterId::Ca, rate), (ParameterId::Ca0, start)];
        let ramps = lambdas.map(|l| {
            let mut ramp = made(&format!("ramped:5Hz:8V:{l}"), 0.4, 50e3, noise, &law);
            if !both {
                Arc::make_mut(&mut ramp).cantilever = None;
            }
            ramp
        });
        let found = adhesion("ramps", &read(&ramps)).unwrap();
        let off = [found.rate.0 / rate - 1.0, found.start.0 / start - 1.0];
        println!("{off:?} {:?} {:?}", found.rate, found.start);
        let slack = if noise > 20e-9 { 3.0 } else { 1.0 };
        assert!(off[0].abs() < slack * 0.015, "{found:?}");
        assert!(off[1].abs() < slack * 0.03, "{found:?}");
        // The stated errors hold, and so does the band wherever there are contacts.
        assert!(
            (found.rate.0 - rate).abs() < 4.0 * found.rate.1,
            "{found:?}"
        );
        assert!(
            (found.start.0 - start).abs() < 4.0 * found.start.1,
            "{found:?}"
        );
        for release in &found.releases {
            let (at, half) = found.band(release.contact);
            let truth = start + rate * release.contact;
            assert!((at - truth).abs() < 2.0 * half, "{at} {truth} {half}");
        }
    }
}

#[test]
fn adhesion_excludes_releases_outside_its_law() {
    let drives = [
        ("square:15Hz:8V", 0.2),
        ("sine:50Hz:8V", 0.12),
        ("sine:15Hz:8V", 0.2),
        ("square:40Hz:7V", 0.15),
    ];
    let readings = read(&drives.map(|(drive, duration)| recording(drive, duration)));
    let found = adhesion("mixed", &readings).unwrap();
    println!("{:?} {:?} {:?}", found.rate, found.start, found.set_aside());
    assert!((found.rate.0 / 1.7e-6 - 1.0).abs() < 0.02, "{found:?}");
    assert!((found.start.0 / 27.43e-9 - 1.0).abs() < 0.02, "{found:?}");
    let count = |reason| found.aside.iter().filter(|a| a.1 == reason).count();
    // The squares let go in one step; landings chatter.
    assert!(count(ExcludedRelease::Jump) >= 5 && count(ExcludedRelease::Brief) >= 5);
    assert!(
        found
            .releases
            .iter()
            .all(|r| r.recording == 1 || r.recording == 2)
    );
    // Squares alone tell no line, and it is said why.
    let mut squares = readings.clone();
    squares.releases.retain(|r| r.recording == 0);
    let error = adhesion("square", &squares).unwrap_err().to_string();
    assert!(error.contains("where the drive jumps"), "{error}");
    assert!(error.contains("several lambda"), "{error}");
    // Contacts of one length give no slope.
    let mut alike = readings;
    alike.releases.retain(|r| r.recording == 1);
    let error = adhesion("one", &alike).unwrap_err();
    assert!(error.to_string().contains("several lambda"), "{error}");
    // What is pressed down is not pulled off.
    let stay = *alike.releases.last().unwrap();
    let pressed = Release {
        force: -1e-7,
        error: 1e-9,
        jump: 0.0,
        ..stay
    };
    alike.releases.push(Release {
        contact: 2.0 * pressed.contact,
        ..stay
    });
    alike.releases.push(pressed);
    let found = adhesion("pressed", &alike).unwrap();
    assert!(
        found.aside.contains(&(pressed, ExcludedRelease::Pressed)),
        "{found:?}"
    );
}

#[test]
fn sensitivity_follows_the_recording_from_either_zero() {
    let model = Preset::default().model;
    let parts = [Part::whole(recording("square:15Hz:8V", 0.1))];
    let cancel = AtomicBool::new(false);
    let shares = Mutex::new(Vec::new());
    let control = Control {
        cancel: &cancel,
        progress: &|p| {
            let share = p.iteration as f64 / p.expected as f64;
            shares.lock().unwrap().push((p.stage, share));
        },
    };
    let options = FitOptions::for_model(&model);
    let both = sensitivity(&model, &parts, &options, &control).unwrap();
    let (a, b) = (&both.original, &both.altered);
    println!("{:?} {:?}", a.train.0, b.train.0);
    // The same motion from another zero: as near to the data, and the ground as it was.
    assert!((b.train.0.rms / a.train.0.rms - 1.0).abs() < 0.05);
    assert!(a.train.0.rms < 1.1 * 20e-9);
    let apart = b.model.parameters[ParameterId::Dp] - a.model.parameters[ParameterId::Dp];
    assert!((apart - ZERO_SHIFT).abs() < 1e-12);
    for id in TABLE_2_ROWS {
        let of = |fit: &crate::fit::uncertainty::fit_result::FitResult| {
            let found = fit
                .parameters
                .iter()
                .find(|p| p.id == id.spec().id)
                .unwrap();
            (found.value, found.std_error)
        };
        let ((x, error), (y, _)) = (of(a), of(b));
        let moved = if id == ParameterId::Gp {
            ZERO_SHIFT
        } else {
            0.0
        };
        println!("{id:?} {x:e} +- {error:e} {y:e}");
        assert!((y - moved - x).abs() < 0.5 * error, "{id:?}");
    }
    // One count for both, which does not go back within either.
    let shares = shares.lock().unwrap().clone();
    for (stage, range) in [
        ("1 of 2: dp as it is", 0.0..=0.75),
        ("2 of 2: dp shifted", 0.75..=1.0),
    ] {
        let own: Vec<f64> = shares
            .iter()
            .filter(|s| s.0 == stage)
            .map(|s| s.1)
            .collect();
        assert!(
            !own.is_empty() && own.iter().all(|s| range.contains(s)),
            "{shares:?}"
        );
    }
    // Cancelled, it ends without two columns.
    cancel.store(true, Ordering::Relaxed);
    assert!(sensitivity(&model, &parts, &options, &control).is_err());
}

/// The step with the `paper` device, whose film is another one than the recordings'.
fn film_of(recordings: &[Arc<Recording>]) -> Result<Film, StepError> {
    let model = Preset::default().model;
    let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    let options = FitOptions::for_model(&model);
    film(&model, &parts, &options, &control)
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (square / a.len() as f64).sqrt()
}

/// Half as strong again, and 3 um thicker.
const OTHER_FILM: [(ParameterId, f64); 2] =
    [(ParameterId::Cs, 1.5 * 1.747e-21), (ParameterId::Gp, 73e-6)];

#[test]
fn film_comes_back_from_the_rings_after_break_off() {
    let square = made("square:15Hz:8V", 0.2, 50e3, 20e-9, &OTHER_FILM);
    let ramp = made("ramped:5Hz:8V:0.25", 0.4, 50e3, 20e-9, &OTHER_FILM);
    let expected = 1.5 * 1.747e-21 / 15e-6f64.powi(3);
    for recordings in [vec![square.clone()], vec![ramp.clone()], vec![square, ramp]] {
        let found = film_of(&recordings).unwrap();
        println!("{} {:?}", found.at_contact / expected, found.fit.remarks);
        assert!((found.at_contact / expected - 1.0).abs() < 0.1, "{found:?}");
        assert!(found.with_film.rms < 1.1 * 20e-9, "{found:?}");
        assert!(found.without_film.rms > 10.0 * found.with_film.rms);
        // So does the figure.
        let decay = found.decay.unwrap();
        assert!(decay.time[0] >= 0.0 && decay.time.len() > 100);
        assert!(rms(&decay.with_film, &decay.measured) < 1.3 * 20e-9);
        assert!(rms(&decay.without_film, &decay.measured) > 0.2e-6);
    }
}

#[test]
fn film_does_not_depend_on_the_grounds_laws_the_rate_or_the_points() {
    let ground = [
        (ParameterId::Cs, 2.4e-21),
        (ParameterId::Alpha, 0.3),
        (ParameterId::Ca0, 3.6e-8),
        (ParameterId::Ca, 1.2e-6),
    ];
    let slow = made("square:15Hz:8V", 0.2, 25e3, 20e-9, &ground);
    let fast = made("square:15Hz:8V", 0.1, 1e6, 20e-9, &OTHER_FILM);
    let mut lone = (*made("ramped:5Hz:8V:0.25", 0.4, 50e3, 20e-9, &OTHER_FILM)).clone();
    lone.cantilever = None;
    let other = 1.5 * 1.747e-21 / 15e-6f64.powi(3);
    for (recording, expected) in [
        (slow, 2.4e-21 / 12e-6f64.powi(3)),
        (Arc::new(lone), other),
        (fast, other),
    ] {
        let found = film_of(&[recording]).unwrap();
        println!("{} {:?}", found.at_contact / expected, found.with_film);
        assert!((found.at_contact / expected - 1.0).abs() < 0.1, "{found:?}");
    }
}

#[test]
fn film_is_never_worse_than_none() {
    let none = [(ParameterId::Cs, 1e-26)];
    // Nor with a structure and a drive that are not the model's.
    let other = [(ParameterId::Zeta1, 0.1), (ParameterId::Eta, 3.6e-7)];
    for changes in [&none[..], &other[..]] {
        let square = made("square:15Hz:8V", 0.2, 25e3, 20e-9, changes);
        let found = film_of(&[square]).unwrap();
        println!("{:?} {:?}", found.with_film, found.without_film);
        assert!(found.with_film.rms <= found.without_film.rms, "{found:?}");
        if changes == none {
            assert!(found.without_film.rms < 1.1 * 20e-9, "{found:?}");
            assert!(found.at_contact < 1e-2 * 1e-6, "{found:?}");
        }
    }
}

#[test]
fn film_recommends_a_recording_if_there_is_no_break_off() {
    for drive in ["sine:5Hz:2V", "square:300Hz:6V"] {
        let error = film_of(&[recording(drive, 0.1)]).unwrap_err().to_string();
        assert!(error.contains("no break-off"), "{error}");
        assert!(error.contains("ramped square"), "{error}");
    }
}

#[test]
fn a_recording_in_another_unit_is_refused() {
    let mut large = recording("ramped:5Hz:8V:0.25", 0.4).as_ref().clone();
    for x in large
        .proof_mass
        .iter_mut()
        .chain(large.cantilever.iter_mut().flatten())
    {
        *x *= 1e6;
    }
    let large = [Arc::new(large)];
    let film = film_of(&large).unwrap_err().to_string();
    let drive = fit_drive(&Preset::default().model, &large)
        .unwrap_err()
        .to_string();
    for said in [film, drive] {
        assert!(said.contains("unit of xp"), "{said}");
    }
}

#[test]
fn a_soft_arrival_shows_by_the_mass_resting_against_the_ramp() {
    for lambda in [0.05, 0.1, 0.2] {
        for (rate, noise) in [(50e3, 20e-9), (25e3, 150e-9)] {
            let ramp = made(&format!("ramped:5Hz:8V:{lambda}"), 0.4, rate, noise, &[]);
            let found = summarize(&Preset::default().model, &[Part::whole(ramp)]);
            let level = found[0].level.clone();
            println!("{lambda} {noise} {level:?}");
            assert!(level.is_ok_and(|l| (l + 58e-6).abs() < 0.1e-6), "{lambda}");
        }
    }
}
