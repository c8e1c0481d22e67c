//! The reference curve over a session that is saved and opened again.

use std::path::Path;
use std::time::Duration;

use eframe::egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::{WithRecording, harness_of, preset, read_all, set_alpha, settle, wait};
use crate::app::files::session;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::shell::options::WindowOptions;
use crate::app::shell::window::*;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;

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
    // The session, its recordings, the curve.
    for _ in 0..4 {
        read_all(&mut harness);
        std::thread::sleep(Duration::from_millis(20));
    }
    harness
}

/// The reference curve.
fn curve(shell: &Shell) -> Option<Vec<f64>> {
    let reference = shell.services.state.reference.as_ref()?;
    Some(reference.trace.proof_mass.clone())
}

#[test]
fn the_reference_curve_comes_back_with_the_session() {
    let mut window = WithRecording::open();
    let first = &mut window.harness;
    first.key_press(Key::G);
    first.run_steps(2);
    // The reference belongs to neither the present device nor the present drive.
    set_alpha(first.state_mut(), 0.2);
    first.state_mut().services.state.setup.drive = DriveChoice::Waveform(Waveform::Rest);
    wait(first, |shown| {
        shown.model.parameters[ParameterId::Alpha] == 0.2
    });
    let saved = window.folder.path().join("s.impactscope.toml");
    save(first.state(), &saved);
    let before = curve(first.state()).unwrap();
    // Another open window would be reported by the second one. The folder stays.
    let WithRecording {
        harness, folder, ..
    } = window;
    drop(harness);
    let second = opened(&saved);
    drop(folder);
    assert_eq!(curve(second.state()).unwrap(), before, "to the last bit");
    let reference = second.state().services.state.reference.clone().unwrap();
    assert_eq!(reference.model.parameters[ParameterId::Alpha], 0.378);
    assert!(
        reference.comparisons[0].comparison.is_ok(),
        "with its distance to the recording"
    );
    let notices = &second.state().services.state.notices;
    assert!(notices.is_empty(), "{notices:?}");
}

#[test]
fn a_reference_curve_driven_by_a_recording_comes_back_with_it_or_reports_it_missing() {
    let mut window = WithRecording::open();
    let first = &mut window.harness;
    let id = first.state().services.state.setup.overlays[0].id;
    first.state_mut().services.state.setup.drive = DriveChoice::Recorded(id);
    wait(first, |shown| {
        let drive = shown.run_of.as_ref().map(|(drive, _)| drive);
        matches!(drive, Some(Waveform::Table(_)))
    });
    first.key_press(Key::G);
    first.run_steps(2);
    let origin = first
        .state()
        .services
        .state
        .view
        .reference_curve
        .clone()
        .unwrap();
    assert_eq!(origin.drive, DriveChoice::Recorded(id));
    let saved = window.folder.path().join("s.impactscope.toml");
    save(first.state(), &saved);
    let before = curve(first.state()).unwrap();
    let second = opened(&saved);
    assert_eq!(curve(second.state()).unwrap(), before);
    drop(second);
    std::fs::remove_file(&window.file).unwrap();
    let mut third = opened(&saved);
    assert_eq!(curve(third.state()), None);
    let is_reported = |harness: &Harness<'_, Shell>| {
        let part = "reference curve (A) cannot be shown";
        let found = harness.query_all_by_label_contains(part).next();
        found.is_some()
    };
    assert!(is_reported(&third));
    // It stays in the session until it is discarded.
    assert_eq!(
        third.state().services.state.view.reference_curve,
        Some(origin)
    );
    third.key_press(Key::G);
    third.run_steps(2);
    assert_eq!(third.state().services.state.view.reference_curve, None);
}

#[test]
fn a_live_reference_curve_lasts_until_the_window_is_closed() {
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
    assert!(state.reference.is_some() && state.view.reference_curve.is_none());
    let notes = harness.query_all_by_label_contains("lost when the window is closed");
    assert_eq!(notes.count(), 1);
}
