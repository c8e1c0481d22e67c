//! From two files to the report, as a first-time user would do it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::{harness_of, preset, read_all};
use crate::app::files::session;
use crate::app::setup::command::Command;
use crate::app::shell::options::WindowOptions;
use crate::app::shell::window::*;
use crate::diagnose::report::verdict_sentence;
use crate::model::drive::Waveform;
use crate::model::parameter::ParameterId;
use crate::model::sensor::Sensor;
use crate::recording::TimeAxis;
use crate::recording::csv::write_csv;
use crate::sim::{Options, simulate};

/// A short recording of the device with a little noise.
fn record(folder: &Path, name: &str, drive: &str, seed: u64) -> PathBuf {
    let mut model = preset("paper").model;
    model.parameters.set(ParameterId::Noise, 2e-8);
    let options = Options {
        rate: 25e3,
        ..Options::default()
    };
    let drive = Waveform::parse(drive, 0.05).unwrap();
    let mut trace = simulate(&model, &drive, 0.05, &options).unwrap();
    Sensor::new(&model.parameters).add_noise(&mut trace.proof_mass, seed);
    let mut text = Vec::new();
    let (times, volts) = (trace.times(), Some(trace.voltage.as_slice()));
    let axis = TimeAxis::Samples(&times);
    write_csv(&mut text, axis, volts, &trace.proof_mass, None).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn press(harness: &mut Harness<'_, Shell>, button: &str) {
    harness.get_by_role_and_label(Role::Button, button).click();
    harness.run_steps(4);
}

#[test]
fn two_files_lead_to_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let files = vec![
        record(folder.path(), "one.csv", "square:40Hz:8V", 1),
        record(folder.path(), "two.csv", "square:60Hz:7V", 2),
    ];
    let options = WindowOptions {
        files,
        workspace: Some("diagnose".to_owned()),
        ..WindowOptions::default()
    };
    let mut harness = harness_of(preset("paper"), options);
    read_all(&mut harness);
    harness
        .get_all_by_role_and_label(Role::Button, "Diagnose")
        .find(|button| button.rect().height() > 40.0)
        .unwrap()
        .click();
    harness.run_steps(3);
    // A cancelled diagnosis also gives an answer.
    press(&mut harness, "Cancel");
    let started = Instant::now();
    while harness.state().services.state.diagnosing.running.is_some() {
        assert!(started.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(20));
        harness.run_steps(1);
    }
    harness.run_steps(3);
    let diagnosing = &harness.state().services.state.diagnosing;
    assert_eq!(diagnosing.error, None);
    let answer = diagnosing.shown().unwrap();
    assert!(answer.diagnosis.cancelled && !answer.asked.split);
    let sentence = verdict_sentence(&answer.diagnosis);
    press(&mut harness, "Export report...");
    let report = folder.path().join("report.html");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(2);
    harness
        .get_by_role_and_label(Role::TextInput, "Path:")
        .type_text(&report.to_string_lossy());
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    read_all(&mut harness);
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(page.contains(&sentence) && page.contains("Proof"));
    // After accepting, the device is the diagnosed one; undo restores the earlier one.
    let before = harness.state().services.state.setup.preset.model.clone();
    harness.run_steps(60);
    press(&mut harness, "Apply to the device");
    let state = &harness.state().services.state;
    let found = &state.diagnosing.shown().unwrap().diagnosis.model;
    assert_eq!(state.setup.preset.model, *found);
    harness.run_steps(60);
    harness.state_mut().services.state.ask(Command::Undo);
    harness.run_steps(3);
    assert_eq!(harness.state().services.state.setup.preset.model, before);
}

#[test]
fn a_session_holds_roles_and_workspace() {
    let mut harness = harness_of(preset("paper"), WindowOptions::default());
    harness.state_mut().services.state.ask(Command::Example);
    harness.run_steps(4);
    let state = &harness.state().services.state;
    assert_eq!(state.view.workspace, "diagnose");
    assert_eq!(state.setup.overlays.len(), 9);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    session::save(&path, &state.setup, &state.view, &[]).unwrap();
    let loaded = session::load(&path).unwrap();
    assert_eq!(loaded.setup.overlays, state.setup.overlays);
    assert_eq!(loaded.view.workspace, "diagnose");
}
