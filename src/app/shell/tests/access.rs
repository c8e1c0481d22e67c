//! Every control has a name and can be reached by Tab, in all workspaces and panels; dropped
//! files are opened.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{DroppedFile, Key};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};

use super::{WithRecording, harness_of, preset, read_all, recording, wait};
use crate::app::analysis::learning::built_in;
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::setup::explore::ExplorePanel;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::shell::options::WindowOptions;
use crate::app::shell::window::*;
use crate::learn::lesson::Task;
use crate::model::drive::{VoltageTable, Waveform};

/// Roles of controls.
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

/// All controls with their roles.
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

/// Draws until no work can be cancelled any more, because buttons come and go with it.
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

/// Presses Tab until every control has had the focus.
fn check(harness: &mut Harness<'_, Shell>, what: &str) {
    harness.run_steps(4);
    let nameless: Vec<String> = controls(harness)
        .into_iter()
        .filter(|(_, node)| name(node).trim().is_empty())
        .map(|(role, node)| format!("{role:?} at {:?}", node.rect()))
        .collect();
    assert!(nameless.is_empty(), "{what}: no names: {nameless:#?}");
    let mut remaining: BTreeMap<_, String> = controls(harness)
        .into_iter()
        .filter(|(_, node)| !node.accesskit_node().is_disabled())
        // The library's window edges can be used by mouse only.
        .filter(|(_, node)| !name(node).starts_with("Resize window"))
        .map(|(role, node)| {
            let text = format!("{role:?} {} at {:?}", name(&node), node.rect());
            (node.accesskit_node().id(), text)
        })
        .collect();
    let count = remaining.len();
    assert!(count > 10, "{what}: only {count} controls");
    for _ in 0..2 * count + 40 {
        harness.key_press(Key::Tab);
        harness.run_steps(1);
        for (_, node) in controls(harness) {
            if node.is_focused() {
                remaining.remove(&node.accesskit_node().id());
            }
        }
        if remaining.is_empty() {
            break;
        }
    }
    let remaining: Vec<String> = remaining.into_values().collect();
    assert!(
        remaining.is_empty(),
        "{what}: {} of {count} controls are not reached by Tab: {remaining:#?}",
        remaining.len()
    );
    println!("{what}: {count} controls, all named, all reached by Tab");
}

#[test]
fn every_control_of_the_tune_workspace_is_reached() {
    let mut window = WithRecording::open();
    let harness = &mut window.harness;
    check(harness, "Tune");
    harness.state_mut().services.state.view.mode = Mode::Live;
    harness.state_mut().services.state.paused = true;
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
        Command::KeptCurves,
    ] {
        let mut window = WithRecording::open();
        let harness = &mut window.harness;
        let setup = &mut harness.state_mut().services.state.setup;
        if panel == Command::DriveEditor {
            let (times, volts) = (vec![0.0, 0.1, 0.2], vec![0.0, 8.0, 8.0]);
            let table = VoltageTable::new("edited", times, volts).unwrap();
            setup.drive = DriveChoice::Waveform(Waveform::Table(Arc::new(table)));
        }
        if panel == Command::KeptCurves {
            harness.state_mut().services.state.ask(Command::KeepCurve);
            harness.run_steps(2);
        }
        harness.state_mut().services.state.ask(panel);
        harness.run_steps(4);
        work_done(harness);
        check(harness, panel.text().0);
    }
}

#[test]
fn every_control_of_the_diagnose_workspace_is_reached() {
    let mut window = WithRecording::open();
    let harness = &mut window.harness;
    let state = &mut harness.state_mut().services.state;
    state.view.workspace = WorkspaceId::Diagnose.name().to_owned();
    check(harness, "Diagnose");
    harness.state_mut().services.state.ask(Command::SealedTrial);
    harness.run_steps(4);
    check(harness, "Diagnose, sealed trial");
}

#[test]
fn every_control_of_the_explore_workspace_is_reached() {
    for panel in ExplorePanel::ALL {
        let mut window = WithRecording::open();
        let harness = &mut window.harness;
        let state = &mut harness.state_mut().services.state;
        state.setup.explore.map.points = 3;
        state.setup.explore.orbit.points = 3;
        state.setup.explore.basins.points = 2;
        state.ask(Command::Explore(panel));
        harness.run_steps(4);
        work_done(harness);
        check(harness, panel.title());
    }
}

#[test]
fn every_control_of_the_learn_workspace_is_reached() {
    let mut harness = harness_of(preset("paper"), WindowOptions::default());
    wait(&mut harness, |_| true);
    let tasks = [
        |task: &Task| matches!(task, Task::Choice(_)),
        |task: &Task| matches!(task, Task::Curve(_)),
        |task: &Task| matches!(task, Task::Fit(_)),
        |task: &Task| matches!(task, Task::Concealed(_)),
    ];
    for is_wanted in tasks {
        let state = &mut harness.state_mut().services.state;
        state.view.workspace = WorkspaceId::Learn.name().to_owned();
        let mut all = built_in().iter().flat_map(|lesson| {
            let steps = lesson.steps.iter().enumerate();
            steps.map(move |(i, step)| (lesson, i, step))
        });
        let (lesson, step, of) = all.find(|(_, _, step)| is_wanted(&step.task)).unwrap();
        state.learning.open_step(lesson, step);
        for _ in 0..3000 {
            harness.run_steps(1);
            if harness
                .state()
                .services
                .state
                .learning
                .open
                .as_ref()
                .unwrap()
                .result()
                .is_some()
            {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        check(&mut harness, &format!("{}, {}", lesson.title, of.title));
    }
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
fn dropped_files_are_opened_in_their_order() {
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
    let state = &harness.state().services.state;
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
    // A file dropped again replaces the earlier recording.
    let path = folder.path().join("a.csv");
    let files = &mut harness.input_mut().dropped_files;
    files.push(Arc::new(Dropped(path)));
    read_all(&mut harness);
    assert_eq!(harness.state().services.state.setup.overlays.len(), 2);
}
