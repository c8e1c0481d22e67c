//! Every control has a name and is reached by Tab, in all workspaces and panels; files
//! that are dropped are opened.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{DroppedFile, Key};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};

use super::{WithRecording, harness_of, preset, read_all, recording, wait};
use crate::app::WindowOptions;
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::shell::window::*;
use crate::model::drive::{VoltageTable, Waveform};

/// What a person acts on.
const CONTROLS: [Role; 12] = [
    Role::Button,
    Role::CheckBox,
    Role::ComboBox,
    Role::Link,
    Role::RadioButton,
    Role::Slider,
    Role::SpinButton,
    Role::Splitter,
    Role::Switch,
    Role::Tab,
    Role::TextInput,
    Role::MultilineTextInput,
];

fn name(node: &Node<'_>) -> String {
    node.accesskit_node().label().unwrap_or_default()
}

/// All controls: whether they are enabled, their roles and names.
fn controls<'a>(harness: &'a Harness<'_, Shell>) -> Vec<(Role, Node<'a>)> {
    CONTROLS
        .into_iter()
        .flat_map(|role| {
            harness
                .query_all_by_role(role)
                .map(move |node| (role, node))
        })
        .collect()
}

/// Runs until nothing is computed that could be cancelled: buttons come and go with it.
fn work_done(harness: &mut Harness<'_, Shell>) {
    let begun = std::time::Instant::now();
    while controls(harness)
        .iter()
        .any(|(_, node)| name(node) == "Cancel" && !node.accesskit_node().is_disabled())
    {
        assert!(begun.elapsed().as_secs() < 120, "the work does not end");
        std::thread::sleep(std::time::Duration::from_millis(10));
        harness.run_steps(1);
    }
}

/// Presses Tab until the round is closed; every control must have had its turn.
fn check(harness: &mut Harness<'_, Shell>, what: &str) {
    harness.run_steps(4);
    let nameless: Vec<String> = controls(harness)
        .into_iter()
        .filter(|(_, node)| name(node).trim().is_empty())
        .map(|(role, node)| format!("{role:?} at {:?}", node.rect()))
        .collect();
    assert!(nameless.is_empty(), "{what}: no names: {nameless:#?}");
    let mut left: BTreeMap<_, String> = controls(harness)
        .into_iter()
        .filter(|(_, node)| !node.accesskit_node().is_disabled())
        // The edges of a floating window are the library's: for the mouse alone.
        .filter(|(_, node)| !name(node).starts_with("Resize window"))
        .map(|(role, node)| {
            let text = format!("{role:?} {} at {:?}", name(&node), node.rect());
            (node.accesskit_node().id(), text)
        })
        .collect();
    let count = left.len();
    assert!(count > 10, "{what}: only {count} controls");
    for _ in 0..2 * count + 40 {
        harness.key_press(Key::Tab);
        harness.run_steps(1);
        for (_, node) in controls(harness) {
            if node.is_focused() {
                left.remove(&node.accesskit_node().id());
            }
        }
        if left.is_empty() {
            break;
        }
    }
    let left: Vec<String> = left.into_values().collect();
    assert!(
        left.is_empty(),
        "{what}: {} of {count} controls are not reached by Tab: {left:#?}",
        left.len()
    );
    println!("{what}: {count} controls, all named, all reached by Tab");
}

#[test]
fn every_control_of_the_tune_workspace_is_reached() {
    let mut window = WithRecording::open();
    let harness = &mut window.harness;
    check(harness, "Tune");
    harness.state_mut().state.view.mode = Mode::Live;
    harness.state_mut().state.paused = true;
    wait(harness, |shown| shown.live.is_some());
    check(harness, "Tune, live");
}

#[test]
fn every_control_of_the_panels_is_reached() {
    for panel in [
        Command::FitPanel,
        Command::Identification,
        Command::Validation,
        Command::DriveEditor,
    ] {
        let mut window = WithRecording::open();
        let harness = &mut window.harness;
        let setup = &mut harness.state_mut().state.setup;
        if panel == Command::DriveEditor {
            let (times, volts) = (vec![0.0, 0.1, 0.2], vec![0.0, 8.0, 8.0]);
            let table = VoltageTable::new("edited", times, volts, 0.0).unwrap();
            setup.drive = DriveChoice::Waveform(Waveform::Table(Arc::new(table)));
        }
        harness.state_mut().state.ask(panel);
        harness.run_steps(4);
        work_done(harness);
        check(harness, panel.text().0);
    }
}

#[test]
fn every_control_of_the_diagnose_workspace_is_reached() {
    let mut window = WithRecording::open();
    let harness = &mut window.harness;
    let state = &mut harness.state_mut().state;
    state.view.workspace = crate::app::workspaces::diagnose::NAME.to_owned();
    check(harness, "Diagnose");
    harness.state_mut().state.ask(Command::SealedTrial);
    harness.run_steps(4);
    check(harness, "Diagnose, sealed trial");
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

#[test]
fn files_that_are_dropped_are_opened_in_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = harness_of(preset("paper"), WindowOptions::default());
    wait(&mut harness, |_| true);
    for (name, text) in [
        ("b.csv", recording(30_000)),
        ("a.csv", recording(300)),
        ("broken.csv", "nothing\n".to_owned()),
        ("device.toml", preset("faller").to_toml()),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let files = &mut harness.input_mut().dropped_files;
        files.push(Arc::new(Dropped(path)));
    }
    read_all(&mut harness);
    let state = &harness.state().state;
    let overlays = &state.setup.overlays;
    let names: Vec<_> = overlays.iter().map(|o| o.recording.name.as_str()).collect();
    assert_eq!(names, ["b.csv", "a.csv"]);
    assert_eq!(state.setup.preset.model.name, "faller");
    let broken = state.notices.iter().find(|n| n.text.contains("broken.csv"));
    assert!(
        broken.is_some_and(|notice| notice.is_error),
        "{:?}",
        state.notices
    );
    // Dropped again, a file replaces its former self.
    let path = folder.path().join("a.csv");
    let files = &mut harness.input_mut().dropped_files;
    files.push(Arc::new(Dropped(path)));
    read_all(&mut harness);
    assert_eq!(harness.state().state.setup.overlays.len(), 2);
}
