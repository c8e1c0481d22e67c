//! The diagnosis on sealed recordings: made by the trial's own model and solver, with a rig
//! that is slightly off, and an effect of which the diagnosis knows nothing.

use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

use impactscope::diagnose::findings::Remark;
use impactscope::diagnose::report::sentences;
use impactscope::diagnose::{
    DiagnoseControl, DiagnoseError, DiagnoseOptions, Diagnosis, Verdict, diagnose,
};
use impactscope::fit::Part;
use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::model::effects::{ActiveEffect, find};
use impactscope::model::parameter::ParameterId;
use impactscope::model::preset::Preset;
use impactscope::model::sensor::Sensor;
use impactscope::recording::Recording;
use impactscope::sim::{Options, simulate};
use impactscope::trial::{Case, Class, Mix, Settings};

/// Diagnoses a few recordings of a trial, for the sake of time.
fn ask(seed: u64, mix: Mix, cancelled: bool) -> Result<Diagnosis, DiagnoseError> {
    let settings = Settings {
        rate: 25e3,
        mix,
        ..Settings::default()
    };
    // The first from this seed on in which what is concealed can be seen.
    let sized = |seed| {
        let case = Case::draw(seed, &settings).expect("a trial");
        let sizes = case
            .truth()
            .effects
            .iter()
            .map(|e| e.times_smallest_visible);
        (sizes.fold(f64::INFINITY, f64::min) > 10.0).then_some(case)
    };
    let case = (seed..seed + 20).find_map(sized).expect("a visible one");
    let parts = |all: &[std::sync::Arc<impactscope::recording::Recording>], which: &[usize]| {
        let pick = |&i: &usize| Part::whole(all[i].clone());
        which.iter().map(pick).collect::<Vec<Part>>()
    };
    let recordings = case.recordings();
    let train = parts(&recordings.train, &[1, 2, 3]);
    let held_out = parts(&recordings.held_out, &[2]);
    let model = Preset::embedded("paper").expect("a preset").model;
    let options = DiagnoseOptions::default();
    answer(&model, (&train, &held_out), &options, cancelled)
}

/// A diagnosis whose progress nobody sees.
fn answer(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    options: &DiagnoseOptions,
    cancelled: bool,
) -> Result<Diagnosis, DiagnoseError> {
    let cancel = AtomicBool::new(cancelled);
    let quiet = |_: &impactscope::diagnose::DiagnoseProgress| {};
    let control = DiagnoseControl {
        cancel: &cancel,
        progress: &quiet,
    };
    diagnose(model, train, held_out, options, &control)
}

#[test]
fn a_concealed_drag_is_named_and_proved() {
    let found = ask(31, Mix::Effect("quadratic_drag".to_owned()), false).unwrap();
    assert_eq!(found.verdict, Verdict::MissingPhysics, "{:?}", found.named);
    let names: Vec<&str> = found.named.iter().map(|n| n.id.as_str()).collect();
    assert_eq!(names, ["quadratic_drag"]);
    let held = &found.held_out;
    assert!(held.after.rms < held.before.rms, "{held:?}");
    assert!(held.after.rms < 1.3 * found.noise, "{held:?}");
}

#[test]
fn where_nothing_was_left_out_nothing_is_named() {
    let found = ask(32, Mix::Only(Class::Nothing), false).unwrap();
    assert_eq!(found.verdict, Verdict::Adequate, "{:?}", found.remarks);
    assert!(found.named.is_empty());
}

#[test]
fn cancelled_it_still_answers_and_names_nothing() {
    let found = ask(31, Mix::Effect("quadratic_drag".to_owned()), true).unwrap();
    assert!(found.cancelled);
    assert!(found.named.is_empty());
}

#[test]
fn senseless_questions_are_refused() {
    let model = Preset::embedded("paper").unwrap().model;
    let options = DiagnoseOptions::default();
    let none = answer(&model, (&[], &[]), &options, false);
    assert!(matches!(none, Err(DiagnoseError::NoRecording)));
    let options = DiagnoseOptions {
        candidates: vec!["nonsense".to_owned()],
        ..options
    };
    let unknown = answer(&model, (&[], &[]), &options, false);
    let text = unknown.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(
        text.contains("nonsense") && text.contains("quadratic_drag"),
        "{text}"
    );
}

/// A recording of `model` as the simulator makes it, 150 nm of noise on both points.
fn recording(model: &Model, drive: &str, duration: f64, seed: u64) -> Part {
    Part::whole(std::sync::Arc::new(recorded(model, drive, duration, seed)))
}

/// The same by itself.
fn recorded(model: &Model, drive: &str, duration: f64, seed: u64) -> Recording {
    let waveform = Waveform::parse(drive, duration).expect("a drive");
    let options = Options {
        rate: 25e3,
        ..Options::default()
    };
    let mut trace = simulate(model, &waveform, duration, &options).expect("a trace");
    let sensor = Sensor {
        noise: 150e-9,
        ..Sensor::default()
    };
    sensor.add_noise(&mut trace.proof_mass, seed);
    sensor.add_noise(&mut trace.cantilever, seed + 1000);
    let (time, volts) = (trace.times(), Some(trace.voltage.clone()));
    let (xp, xc) = (trace.proof_mass, Some(trace.cantilever));
    Recording::new(drive, time, volts, xp, xc).expect("a recording")
}

/// Three recordings of `model` to fit to and one to keep out, in which `also` may lay something
/// over the readings.
fn series(model: &Model, also: impl Fn(&mut Recording)) -> Vec<Part> {
    let drives = [
        ("square:15Hz:8V", 0.2),
        ("sine:50Hz:8V", 0.1),
        ("square:50Hz:6V", 0.12),
        ("square:40Hz:7V", 0.12),
    ];
    let one = |(k, (drive, duration)): (usize, (&str, f64))| {
        let mut recording = recorded(model, drive, duration, 10 + k as u64);
        also(&mut recording);
        Part::whole(std::sync::Arc::new(recording))
    };
    drives.into_iter().enumerate().map(one).collect()
}

#[test]
fn what_rings_by_itself_is_no_mode_and_a_mode_is() {
    const RING: f64 = 1750.0;
    let paper = Preset::embedded("paper").expect("a preset").model;
    let ask = |parts: &[Part]| {
        let (train, held_out) = parts.split_at(3);
        let options = DiagnoseOptions::default();
        answer(&paper, (train, held_out), &options, false).expect("an answer")
    };
    // Every so often something rings and dies away, whatever the drive does.
    let bursts = |recording: &mut Recording| {
        for (i, t) in recording.time.iter().enumerate() {
            let since = (t + 3e-3 * (t * 40.0).floor().sin()) % 9.7e-3;
            let ring = 0.5e-6 * (-since / 2e-3).exp() * (TAU * RING * since).sin();
            recording.proof_mass[i] += ring;
            recording.cantilever.as_mut().expect("both points")[i] += 0.4 * ring;
        }
    };
    let found = ask(&series(&paper, bursts));
    assert_eq!(found.verdict, Verdict::Unexplained, "{:?}", found.named);
    assert!(found.named.is_empty(), "{:?}", found.named);
    let mut with = paper.clone();
    let mut mode = ActiveEffect::new(find("extra_mode").expect("an effect"));
    for (id, value) in [("f", RING), ("zeta", 0.01), ("phi_p", 2e3), ("phi_c", 4e3)] {
        assert!(mode.set(id, value), "{id}");
    }
    with.effects.push(mode);
    let found = ask(&series(&with, |_| ()));
    let names: Vec<&str> = found.named.iter().map(|n| n.id.as_str()).collect();
    assert_eq!(names, ["extra_mode"], "{:?}", found.remarks);
}

#[test]
fn a_weak_mode_shows_in_step_with_what_sets_it_off() {
    let paper = Preset::embedded("paper").expect("a preset").model;
    let mut with = paper.clone();
    let mut mode = ActiveEffect::new(find("extra_mode").expect("an effect"));
    let own = [
        ("f", 13.7e3),
        ("zeta", 5e-3),
        ("phi_p", 9.3e3),
        ("phi_c", 12.6e3),
        ("phi_d", 11.2e3),
    ];
    for (id, value) in own {
        assert!(mode.set(id, value), "{id}");
    }
    with.effects.push(mode);
    let parts = series(&with, |_| ());
    let (train, held_out) = parts.split_at(3);
    let options = DiagnoseOptions::default();
    let found = answer(&paper, (train, held_out), &options, false).expect("an answer");
    let names: Vec<&str> = found.named.iter().map(|n| n.id.as_str()).collect();
    assert_eq!(names, ["extra_mode"], "{:?}", found.remarks);
    let f = found.model.get("extra_mode.f").expect("its frequency");
    assert!((f / 13.7e3 - 1.0).abs() < 0.01, "{f}");
}

#[test]
fn a_zero_that_drifts_by_micrometres_is_named() {
    let paper = Preset::embedded("paper").expect("a preset").model;
    // Slower and slower without end, which is not the law that is fitted.
    let drifts = |recording: &mut Recording| {
        let moved = |t: &f64| -6e-6 * (t / 0.04).ln_1p();
        let moved: Vec<f64> = recording.time.iter().map(moved).collect();
        let xc = recording.cantilever.as_mut().expect("both points");
        for (i, moved) in moved.into_iter().enumerate() {
            recording.proof_mass[i] += moved;
            xc[i] += moved;
        }
    };
    let parts = series(&paper, drifts);
    let (train, held_out) = parts.split_at(3);
    let options = DiagnoseOptions::default();
    let found = answer(&paper, (train, held_out), &options, false).expect("an answer");
    let names: Vec<&str> = found.named.iter().map(|n| n.id.as_str()).collect();
    assert_eq!(names, ["zero_drift"], "{:?}", found.remarks);
    let held = &found.held_out;
    let drift = found.model.effects.last();
    assert!(
        held.after.rms < 0.1 * held.before.rms,
        "{held:?} {drift:?} {:?}",
        found.remarks
    );
}

#[test]
fn a_mass_that_hovers_over_the_ground_is_not_taken_to_stay_on_it() {
    let mut model = Preset::embedded("paper").expect("a preset").model;
    // Little enough that the mass does not stick where it hovers.
    model.set("Ca0", 1e-9).expect("a parameter");
    let start = model.clone();
    // Where it rests without a ground, half a period after the step down.
    let rest = |volts: f64| {
        let mut free = model.clone();
        free.set("dp", 300e-6).expect("a parameter");
        free.set("gp", 320e-6).expect("a parameter");
        let drive = Waveform::parse(&format!("square:5Hz:{volts}V"), 0.2).expect("a drive");
        let trace = simulate(&free, &drive, 0.2, &Options::default()).expect("a trace");
        let end = |share: f64| trace.proof_mass[(share * trace.proof_mass.len() as f64) as usize];
        end(0.49).min(end(0.99))
    };
    let over = -model.parameters[ParameterId::Dp] + 0.5e-6;
    let (mut low, mut high) = (2.0, 8.0);
    for _ in 0..30 {
        let volts = 0.5 * (low + high);
        if rest(volts) > over {
            low = volts;
        } else {
            high = volts;
        }
    }
    let hovering = format!("square:50Hz:{low:.6}V");
    model
        .set("eta", 1.02 * start.parameters[ParameterId::Eta])
        .expect("a parameter");
    let train = [
        recording(&start, "square:15Hz:8V", 0.2, 1),
        recording(&start, "sine:50Hz:8V", 0.1, 2),
        recording(&start, &hovering, 0.12, 3),
    ];
    let held_out = [recording(&start, "square:40Hz:7.5V", 0.1, 4)];
    let options = DiagnoseOptions::default();
    let found = answer(&model, (&train, &held_out), &options, false).expect("an answer");
    let said = |r: &Remark| {
        let text = sentences::remark(r);
        text.starts_with(&hovering) && text.contains("without touching")
    };
    assert!(found.remarks.iter().any(said), "{:?}", found.remarks);
    assert_eq!(found.verdict, Verdict::Adequate, "{:?}", found.remarks);
}

#[test]
fn a_ground_that_gives_way_may_also_step() {
    let paper = Preset::embedded("paper").expect("a preset").model;
    let names = |step: f64| {
        let mut model = paper.clone();
        let effect = |id: &str| ActiveEffect::new(find(id).expect("an effect"));
        model.effects.push(effect("compliant_ground"));
        if step != 0.0 {
            let mut own = effect("gap_step");
            assert!(own.set("h", step) && own.set("t0", 0.05));
            model.effects.push(own);
        }
        let parts = series(&model, |_| ());
        let (train, held_out) = parts.split_at(3);
        let options = DiagnoseOptions::default();
        let found = answer(&paper, (train, held_out), &options, false).expect("an answer");
        let mut names: Vec<String> = found.named.into_iter().map(|n| n.id).collect();
        names.sort();
        names
    };
    assert_eq!(names(0.0), ["compliant_ground"]);
    assert_eq!(names(-0.5e-6), ["compliant_ground", "gap_step"]);
}
