//! Kept curves: kept twice, renamed, restored, removed and undone; their numbers; over a session
//! that is saved and opened again.

use std::path::Path;
use std::time::Duration;

use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::{WithRecording, harness_of, preset, read_all, set_alpha, settle, wait};
use crate::app::files::session;
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::setup::kept_curve::KeptCurve;
use crate::app::shell::options::WindowOptions;
use crate::app::shell::window::*;
use crate::app::simulation::kept::KeptRun;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::unit::format_number;
use crate::sim::{Options, simulate};

fn save(shell: &Shell, path: &Path) {
    let state = &shell.services.state;
    session::save(path, &state.setup, &state.view, &[]).unwrap();
}

fn opened(path: &Path) -> Harness<'static, Shell> {
    let options = WindowOptions {
        files: vec![path.to_owned()],
        ..WindowOptions::default()
    };
    let mut harness = harness_of(preset("oscillator"), options);
    // The session, then its recordings.
    for _ in 0..4 {
        read_all(&mut harness);
        std::thread::sleep(Duration::from_millis(20));
    }
    all_computed(&mut harness);
    harness
}

fn kept(shell: &Shell) -> &[KeptCurve] {
    &shell.services.state.setup.kept
}

fn names(shell: &Shell) -> Vec<String> {
    kept(shell).iter().map(|curve| curve.name.clone()).collect()
}

fn run(shell: &Shell, index: usize) -> Option<&KeptRun> {
    let state = &shell.services.state;
    state.kept_runs.of(&state.setup.kept[index].origin)
}

/// The line of a kept curve.
fn line(shell: &Shell, index: usize) -> Option<Vec<f64>> {
    let run = run(shell, index)?.run.as_ref().ok()?;
    Some(run.trace.proof_mass.clone())
}

/// Draws until all numbers of the kept curves are known.
fn all_computed(harness: &mut Harness<'_, Shell>) {
    for _ in 0..3000 {
        harness.run_steps(1);
        let state = &harness.state().services.state;
        if state.kept_runs.are_complete(&state.setup.kept) {
            return harness.run_steps(2);
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("the kept curves were not computed");
}

/// Keeps the present curve by its key.
fn keep(harness: &mut Harness<'_, Shell>) {
    harness.key_press(Key::G);
    harness.run_steps(2);
    settle(harness);
}

/// Sets the coefficient of restitution and waits for its run.
fn with_alpha(harness: &mut Harness<'_, Shell>, value: f64) {
    set_alpha(harness.state_mut(), value);
    wait(harness, |shown| {
        shown.model.parameters[ParameterId::Alpha] == value
    });
    settle(harness);
}

fn alpha(shell: &Shell) -> f64 {
    shell.services.state.setup.preset.model.parameters[ParameterId::Alpha]
}

fn undo(harness: &mut Harness<'_, Shell>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
}

fn press(harness: &mut Harness<'_, Shell>, label: &str) {
    harness.get_by_label(label).scroll_to_me();
    harness.run_steps(20);
    harness.get_by_label(label).click();
    harness.run_steps(3);
    settle(harness);
}

#[test]
fn curves_are_kept_renamed_restored_removed_and_each_can_be_undone() {
    let mut harness = harness_of(preset("paper"), WindowOptions::default());
    wait(&mut harness, |_| true);
    settle(&mut harness);
    keep(&mut harness);
    with_alpha(&mut harness, 0.5);
    keep(&mut harness);
    let second = names(harness.state())[1].clone();
    assert_eq!(names(harness.state())[0], "kept 1");
    assert!(second.ends_with(" 0.5"), "{second}");
    // The same curve once more says so.
    keep(&mut harness);
    assert_eq!(kept(harness.state()).len(), 2);
    let notice = harness.query_all_by_label_contains("kept already").count();
    assert!(notice > 0);
    harness.state_mut().services.state.ask(Command::KeptCurves);
    harness.run_steps(40);
    // Renamed in place.
    harness.get_by_label("name of kept 1").focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    let field = harness.get_by_label("name of kept 1");
    field.type_text("as printed");
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    settle(&mut harness);
    assert_eq!(
        names(harness.state()),
        ["as printed".to_owned(), second.clone()]
    );
    // Restored while the sliders are elsewhere.
    with_alpha(&mut harness, 0.2);
    press(&mut harness, "restore as printed");
    assert_eq!(alpha(harness.state()), 0.378);
    press(&mut harness, "draw as printed");
    assert!(!kept(harness.state())[0].visible);
    press(&mut harness, "remove as printed");
    assert_eq!(names(harness.state()), std::slice::from_ref(&second));
    // All of it backwards.
    undo(&mut harness);
    assert_eq!(
        names(harness.state()),
        ["as printed".to_owned(), second.clone()]
    );
    undo(&mut harness);
    assert!(kept(harness.state())[0].visible);
    undo(&mut harness);
    assert_eq!(alpha(harness.state()), 0.2);
    undo(&mut harness);
    assert_eq!(alpha(harness.state()), 0.5);
    undo(&mut harness);
    assert_eq!(names(harness.state()), ["kept 1".to_owned(), second]);
    undo(&mut harness);
    assert_eq!(names(harness.state()), ["kept 1"]);
    undo(&mut harness);
    undo(&mut harness);
    assert!(kept(harness.state()).is_empty());
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(names(harness.state()), ["kept 1"]);
    all_computed(&mut harness);
    assert!(
        line(harness.state(), 0).is_some(),
        "its line comes back with it"
    );
}

/// A recording of the device `paper` with another coefficient of restitution, with noise, as CSV.
fn true_recording(alpha: f64) -> String {
    let mut model = Preset::embedded("paper").unwrap().model;
    model.parameters.set(ParameterId::Alpha, alpha);
    let drive = Waveform::parse("square:15Hz:8V", 0.2).unwrap();
    let options = Options {
        rate: 25e3,
        ..Options::default()
    };
    let trace = simulate(&model, &drive, 0.2, &options).unwrap();
    let mut text = "t [s],V [V],xp [um]\n".to_owned();
    let mut state = 1u64;
    let mut uniform = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    for (i, xp) in trace.proof_mass.iter().enumerate() {
        // A sum of twelve is normal enough, with a standard deviation of 20 nm.
        let noise: f64 = 0.02 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0);
        text += &format!(
            "{},{},{}\n",
            trace.time(i),
            trace.voltage[i],
            1e6 * xp + noise
        );
    }
    text
}

#[test]
fn a_curve_kept_at_the_true_values_shows_its_misfit_while_the_sliders_are_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("true.csv");
    std::fs::write(&file, true_recording(0.45)).unwrap();
    let options = WindowOptions {
        files: vec![file],
        ..WindowOptions::default()
    };
    let mut harness = harness_of(preset("paper"), options);
    read_all(&mut harness);
    with_alpha(&mut harness, 0.45);
    let fitted = |shown: &crate::app::simulation::snapshot::Snapshot| {
        shown.total_misfit().is_some_and(|misfit| misfit < 1.2) && shown.features.is_some()
    };
    wait(&mut harness, fitted);
    let live = harness.state().services.state.snapshot.clone().unwrap();
    keep(&mut harness);
    with_alpha(&mut harness, 0.3);
    wait(&mut harness, |shown| {
        shown.total_misfit().is_some_and(|misfit| misfit > 5.0)
    });
    all_computed(&mut harness);
    let shown = run(harness.state(), 0).unwrap().run.clone().unwrap();
    let (own, present) = (shown.total_misfit().unwrap(), live.total_misfit().unwrap());
    assert!(
        (own - present).abs() < 0.02 * present,
        "{own} and {present}"
    );
    assert!(shown.comparisons[0].misfit().is_some());
    assert_eq!(shown.features, live.features);
    // The same numbers are on the screen, next to those of the present run.
    harness.state_mut().services.state.ask(Command::KeptCurves);
    harness.run_steps(40);
    let now = harness.state().services.state.snapshot.clone().unwrap();
    for misfit in [own, now.total_misfit().unwrap()] {
        let text = format_number(misfit, 3);
        let cells = harness.query_all_by_label(&text).count();
        assert!(cells > 0, "{text} is not in the table");
    }
    // A hidden recording is compared with neither.
    harness.state_mut().services.state.setup.overlays[0].visible = false;
    for _ in 0..500 {
        harness.run_steps(1);
        let run = run(harness.state(), 0).unwrap().run.as_ref().unwrap();
        if run.comparisons.is_empty() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("the hidden recording is still compared");
}

#[test]
fn kept_curves_come_back_with_the_session() {
    let mut window = WithRecording::open();
    let first = &mut window.harness;
    keep(first);
    // It belongs to neither the present device nor the present drive.
    set_alpha(first.state_mut(), 0.2);
    first.state_mut().services.state.setup.drive = DriveChoice::Waveform(Waveform::Rest);
    wait(first, |shown| {
        let drive = shown.run_of.as_ref().map(|(drive, _)| drive);
        shown.model.parameters[ParameterId::Alpha] == 0.2 && drive == Some(&Waveform::Rest)
    });
    keep(first);
    let saved = window.folder.path().join("s.impactscope.toml");
    save(first.state(), &saved);
    let before = [0, 1].map(|i| line(first.state(), i).unwrap());
    assert_ne!(before[0], before[1]);
    // Another open window would be reported by the second one. The folder stays.
    let WithRecording {
        harness, folder, ..
    } = window;
    drop(harness);
    let second = opened(&saved);
    drop(folder);
    for (i, before) in before.iter().enumerate() {
        assert_eq!(&line(second.state(), i).unwrap(), before, "to the last bit");
    }
    let first_run = run(second.state(), 0).unwrap().run.clone().unwrap();
    assert_eq!(first_run.model.parameters[ParameterId::Alpha], 0.378);
    assert!(
        first_run.comparisons[0].comparison.is_ok(),
        "with its distance to the recording"
    );
    let notices = &second.state().services.state.notices;
    assert!(notices.is_empty(), "{notices:?}");
}

#[test]
fn a_kept_curve_driven_by_a_recording_comes_back_with_it_or_reports_it_missing() {
    let mut window = WithRecording::open();
    let first = &mut window.harness;
    let id = first.state().services.state.setup.overlays[0].id;
    first.state_mut().services.state.setup.drive = DriveChoice::Recorded(id);
    wait(first, |shown| {
        let drive = shown.run_of.as_ref().map(|(drive, _)| drive);
        matches!(drive, Some(Waveform::Table(_)))
    });
    keep(first);
    let curve = kept(first.state())[0].clone();
    assert_eq!(curve.origin.drive, DriveChoice::Recorded(id));
    let saved = window.folder.path().join("s.impactscope.toml");
    save(first.state(), &saved);
    let before = line(first.state(), 0).unwrap();
    let second = opened(&saved);
    assert_eq!(line(second.state(), 0).unwrap(), before);
    drop(second);
    std::fs::remove_file(&window.file).unwrap();
    let mut third = opened(&saved);
    assert_eq!(line(third.state(), 0), None);
    let is_reported = |harness: &Harness<'_, Shell>| {
        let part = "\"kept 1\" cannot be shown";
        let found = harness.query_all_by_label_contains(part).next();
        found.is_some()
    };
    assert!(is_reported(&third));
    // It stays in the session until it is removed.
    assert_eq!(kept(third.state()), [curve]);
    third.state_mut().services.state.ask(Command::KeptCurves);
    third.run_steps(40);
    press(&mut third, "remove kept 1");
    assert!(kept(third.state()).is_empty());
}

#[test]
fn a_live_curve_lasts_until_the_window_is_closed_and_undo_brings_it_back() {
    let mut harness = harness_of(preset("paper"), WindowOptions::default());
    wait(&mut harness, |_| true);
    settle(&mut harness);
    harness.state_mut().services.state.view.mode = Mode::Live;
    wait(&mut harness, |shown| {
        shown.live.is_some_and(|live| live.time > 1e-3)
    });
    harness.key_press(Key::G);
    harness.run_steps(2);
    let state = &harness.state().services.state;
    assert!(state.setup.kept[0].origin.live.is_some());
    let before = line(harness.state(), 0).unwrap();
    settle(&mut harness);
    harness.state_mut().services.state.ask(Command::KeptCurves);
    harness.run_steps(40);
    let notes = harness.query_all_by_label_contains("lost when the window is closed");
    assert!(notes.count() > 0);
    press(&mut harness, "remove kept 1");
    assert!(kept(harness.state()).is_empty());
    undo(&mut harness);
    assert_eq!(line(harness.state(), 0).unwrap(), before);
}
