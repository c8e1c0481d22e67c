//! The window as a whole, without a GPU: menus, keys, undo. Nothing is saved, because no test
//! lasts until the autosave.

#[cfg(test)]
pub(super) mod access;
#[cfg(test)]
pub(super) mod diagnosis;
#[cfg(test)]
pub(super) mod first_start;
#[cfg(test)]
pub(super) mod kept_curves;
#[cfg(test)]
pub(super) mod lessons;
#[cfg(test)]
pub(super) mod presenter;
#[cfg(test)]
pub(super) mod reachable;

use std::path::{Path, PathBuf};
use std::time::Duration;

use eframe::egui::accesskit::Role;
use eframe::egui::{Context, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::window::*;
use crate::app::files::session;
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::view::Picture;
use crate::app::shell::options::WindowOptions;
use crate::app::shell::screenshot::PictureOutcome;
use crate::app::simulation::snapshot::Snapshot;
use crate::model::effects;
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;

pub(super) fn preset(name: &str) -> Preset {
    Preset::embedded(name).unwrap()
}

pub(super) fn harness(preset: Preset) -> Harness<'static, Shell> {
    harness_of(preset, WindowOptions::default())
}

pub(super) fn harness_of(preset: Preset, options: WindowOptions) -> Harness<'static, Shell> {
    harness_in_steps(preset, options, 1.0 / 120.0)
}

/// A window of which a frame takes `step` \[s\].
pub(super) fn harness_in_steps(
    preset: Preset,
    options: WindowOptions,
    step: f32,
) -> Harness<'static, Shell> {
    let shell = Shell::new(
        &Context::default(),
        options,
        Some(preset),
        PictureOutcome::default(),
    );
    Harness::builder()
        .with_size([1440.0, 900.0])
        .with_step_dt(step)
        .build_ui_state(|ui, shell: &mut Shell| shell.show(ui), shell.unwrap())
}

/// Draws until the simulator has sent a result that `done` accepts.
pub(super) fn wait(harness: &mut Harness<'_, Shell>, done: impl Fn(&Snapshot) -> bool) {
    for _ in 0..1000 {
        let shown = harness.state().services.state.snapshot.clone();
        if shown.is_some_and(|shown| done(&shown)) {
            return harness.run_steps(2);
        }
        std::thread::sleep(Duration::from_millis(10));
        harness.run_steps(1);
    }
    panic!("the simulator sent no such result");
}

fn alpha(shell: &Shell) -> f64 {
    shell.services.state.setup.preset.model.parameters[ParameterId::Alpha]
}

pub(super) fn set_alpha(shell: &mut Shell, value: f64) {
    let parameters = &mut shell.services.state.setup.preset.model.parameters;
    parameters.set(ParameterId::Alpha, value);
}

/// Enough frames for a change to become an undo step.
pub(super) fn settle(harness: &mut Harness<'_, Shell>) {
    harness.run_steps(60);
}

#[test]
fn a_change_is_computed_undone_and_redone() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    settle(&mut harness);
    set_alpha(harness.state_mut(), 0.5);
    wait(&mut harness, |shown| {
        shown.model.parameters[ParameterId::Alpha] == 0.5
    });
    settle(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(alpha(harness.state()), 0.378);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(alpha(harness.state()), 0.5);
}

#[test]
fn an_own_preset_is_reset_to_its_own_values() {
    let mut mine = preset("paper");
    mine.model.name = "mine".to_owned();
    mine.model.parameters.set(ParameterId::Alpha, 0.61);
    let mut harness = harness(mine);
    wait(&mut harness, |_| true);
    set_alpha(harness.state_mut(), 0.2);
    settle(&mut harness);
    harness
        .state_mut()
        .services
        .state
        .ask(Command::ResetParameters);
    harness.run_steps(3);
    assert_eq!(alpha(harness.state()), 0.61);
}

#[test]
fn every_menu_opens_and_its_entries_have_names() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    for (menu, entry) in [
        ("File", "Save session"),
        ("Edit", "Undo"),
        ("Recording", "Auto-align"),
        ("View", "Plot: phase portrait"),
        ("Run", "Live"),
        ("Help", "About"),
    ] {
        harness.get_by_role_and_label(Role::Button, menu).click();
        harness.run_steps(4);
        let found = harness.query_all_by_label_contains(entry).next();
        assert!(found.is_some(), "{menu} has no {entry}");
        let nameless = harness
            .query_all_by_role(Role::Button)
            .filter(|node| node.accesskit_node().label().is_none())
            .count();
        assert_eq!(nameless, 0, "buttons without a name under {menu}");
        harness.key_press(Key::Escape);
        harness.run_steps(4);
    }
}

#[test]
fn a_live_run_is_started_and_paused_by_keys() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    harness.key_press(Key::L);
    harness.run_steps(2);
    assert_eq!(harness.state().services.state.view.mode, Mode::Live);
    wait(&mut harness, |shown| {
        shown.live.is_some_and(|live| live.time > 1e-3)
    });
    harness.key_press(Key::Space);
    harness.run_steps(2);
    assert!(harness.state().services.state.paused);
    wait(&mut harness, |shown| shown.live.is_some_and(|l| l.paused));
}

#[test]
fn a_diverging_live_run_is_paused_and_reported_and_can_be_restarted() {
    let mut harness = harness(preset("oscillator"));
    wait(&mut harness, |_| true);
    harness.key_press(Key::L);
    wait(&mut harness, |shown| {
        shown.live.is_some_and(|live| live.time > 0.0)
    });
    // A spring that pushes away from rest, with a force that grows with the distance.
    let mut softening = ActiveEffect::new(effects::find("cubic_stiffness").unwrap());
    assert!(softening.set("k3", -1e5));
    let device = &mut harness.state_mut().services.state.setup.preset.model;
    device.effects.push(softening);
    for _ in 0..1000 {
        harness.run_steps(1);
        if harness.state().services.state.paused {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let state = &harness.state().services.state;
    assert!(state.paused);
    let is_reported = |text: &str| text.contains("Live run paused") && text.contains("diverges");
    assert!(
        state
            .notices
            .iter()
            .any(|n| n.is_error && is_reported(&n.text))
    );
    assert!(state.snapshot.is_some(), "what it did until then stays");
    let device = &mut harness.state_mut().services.state.setup.preset.model;
    device.effects.clear();
    harness.run_steps(2);
    harness.key_press(Key::R);
    let begun = |shown: &Snapshot| {
        shown
            .live
            .is_some_and(|live| !live.paused && live.time > 0.0)
    };
    wait(&mut harness, begun);
    assert!(!harness.state().services.state.paused);
}

#[test]
fn w_comes_back_to_the_whole_span_from_anywhere() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    let zoom = |harness: &mut Harness<'_, Shell>, range| {
        let view = &mut harness.state_mut().services.state.view;
        view.time_range = Some(range);
        let name = Picture::Trajectory.name().to_owned();
        view.value_ranges.insert(name, (0.0, 1e-6));
    };
    // Seconds into a live run, long after the span; part of both; without a live run.
    for (looked_at, live) in [
        ((5.0, 5.2), true),
        ((0.01, 0.02), true),
        ((0.01, 0.02), false),
    ] {
        if live {
            harness.key_press(Key::L);
            wait(&mut harness, |shown| shown.live.is_some());
            harness.state_mut().services.state.scrub = Some(0.0);
        }
        zoom(&mut harness, looked_at);
        harness.key_press(Key::W);
        wait(&mut harness, |shown| shown.live.is_none());
        let state = &harness.state().services.state;
        assert_eq!((state.view.time_range, state.scrub), (None, None));
        assert!(state.view.value_ranges.is_empty());
    }
}

#[test]
fn an_invalid_value_is_reported_and_the_last_curve_stays() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    let parameters = &mut harness
        .state_mut()
        .services
        .state
        .setup
        .preset
        .model
        .parameters;
    parameters.set(ParameterId::Gp, 50e-6);
    harness.run_steps(3);
    let state = &harness.state().services.state;
    let refusal = state.refusal.as_ref().unwrap();
    assert!(refusal.message.contains("must exceed dp"), "{refusal:?}");
    let shown = state.snapshot.as_ref().unwrap();
    assert_eq!(shown.model.parameters[ParameterId::Gp], 70e-6);
}

#[test]
fn information_disappears_and_errors_stay_and_neither_moves_the_layout() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    let place = |harness: &Harness<'_, Shell>| {
        let slider = harness
            .query_all_by_role(Role::Slider)
            .find(|n| {
                n.accesskit_node()
                    .label()
                    .is_some_and(|l| l.starts_with("alpha, "))
            })
            .unwrap();
        slider.rect()
    };
    let before = place(&harness);
    harness.state_mut().services.notice(false, "Saved a file");
    harness
        .state_mut()
        .services
        .notice(true, "something failed");
    harness.run_steps(3);
    assert!(harness.query_by_label("Saved a file").is_some());
    assert_eq!(place(&harness), before);
    // 120 frames a second for ten seconds.
    harness.run_steps(1200);
    assert!(harness.query_by_label("Saved a file").is_none());
    assert!(harness.query_by_label("something failed").is_some());
    harness
        .get_by_role_and_label(Role::Button, "Dismiss")
        .click();
    harness.run_steps(3);
    assert!(harness.state().services.state.notices.is_empty());
    // A message at a slider moves nothing either.
    let parameters = &mut harness
        .state_mut()
        .services
        .state
        .setup
        .preset
        .model
        .parameters;
    parameters.set(ParameterId::Gp, 50e-6);
    harness.run_steps(3);
    assert!(
        harness
            .query_all_by_label_contains("must exceed dp")
            .next()
            .is_some()
    );
    assert_eq!(place(&harness), before);
}

/// A window with a visible recording. The file of the recording and its folder last as long
/// as the window.
pub(super) struct WithRecording {
    pub(super) harness: Harness<'static, Shell>,
    pub(super) file: PathBuf,
    pub(super) folder: tempfile::TempDir,
}

impl WithRecording {
    pub(super) fn open() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tap.csv");
        std::fs::write(&file, recording(4000)).unwrap();
        let options = WindowOptions {
            files: vec![file.clone()],
            ..WindowOptions::default()
        };
        let mut harness = harness_of(preset("paper"), options);
        read_all(&mut harness);
        wait(&mut harness, |shown| {
            shown.comparisons.iter().any(|c| c.comparison.is_ok())
        });
        Self {
            harness,
            file,
            folder,
        }
    }
}

/// Draws until all files are read.
pub(super) fn read_all(harness: &mut Harness<'_, Shell>) {
    for _ in 0..1000 {
        harness.run_steps(1);
        if harness.state().services.files.pending() == 0 {
            return harness.run_steps(2);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("the files were not read");
}

pub(super) fn recording(samples: u32) -> String {
    let rows = (0..samples).map(|i| format!("{i}e-5,0,{}\n", i % 7));
    "t [s],V [V],xp [um]\n".to_owned() + &rows.collect::<String>()
}

#[test]
fn recordings_are_listed_in_the_order_of_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    // The first takes longest to read.
    let files = [("long.csv", 200_000), ("b.csv", 300), ("a.csv", 200)].map(|(name, samples)| {
        let path = folder.path().join(name);
        std::fs::write(&path, recording(samples)).unwrap();
        path
    });
    let options = WindowOptions {
        files: files.to_vec(),
        ..WindowOptions::default()
    };
    let mut harness = harness_of(preset("paper"), options);
    read_all(&mut harness);
    let overlays = &harness.state().services.state.setup.overlays;
    let shown: Vec<_> = overlays
        .iter()
        .map(|o| (o.recording.name.as_str(), o.color))
        .collect();
    assert_eq!(shown, [("long.csv", 0), ("b.csv", 1), ("a.csv", 2)]);
}

#[test]
fn a_moved_recording_of_a_session_can_be_located() {
    let folder = tempfile::tempdir().unwrap();
    let (before, after) = (
        folder.path().join("a.csv"),
        folder.path().join("moved/b.csv"),
    );
    std::fs::write(&before, recording(300)).unwrap();
    let options = WindowOptions {
        files: vec![before.clone()],
        ..WindowOptions::default()
    };
    let mut first = harness_of(preset("paper"), options);
    read_all(&mut first);
    let saved = folder.path().join("s.impactscope.toml");
    let state = &first.state().services.state;
    session::save(&saved, &state.setup, &state.view, &[]).unwrap();
    // Another open window would be reported by the second one.
    drop(first);
    std::fs::create_dir(folder.path().join("moved")).unwrap();
    std::fs::rename(&before, &after).unwrap();
    let options = WindowOptions {
        files: vec![saved],
        ..WindowOptions::default()
    };
    let mut second = harness_of(preset("paper"), options);
    read_all(&mut second);
    read_all(&mut second);
    assert!(second.state().services.state.setup.overlays.is_empty());
    second.get_by_label("Locate...").click();
    second.run_steps(6);
    // The field already holds the folder; an absolute path replaces it.
    second
        .get_by_role_and_label(Role::TextInput, "Path:")
        .type_text(&after.to_string_lossy());
    second.run_steps(2);
    second.key_press(Key::Enter);
    second.run_steps(3);
    read_all(&mut second);
    let overlays = &second.state().services.state.setup.overlays;
    assert_eq!(overlays[0].recording.path.as_deref(), Some(&*after));
    let notices = &second.state().services.state.notices;
    assert!(notices.is_empty(), "{notices:?}");
}

#[test]
fn a_missing_recording_can_be_removed_from_its_session() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    std::fs::write(&file, recording(300)).unwrap();
    let options = |file: &Path| WindowOptions {
        files: vec![file.to_owned()],
        ..WindowOptions::default()
    };
    let mut first = harness_of(preset("paper"), options(&file));
    read_all(&mut first);
    let saved = folder.path().join("s.impactscope.toml");
    let state = &first.state().services.state;
    session::save(&saved, &state.setup, &state.view, &[]).unwrap();
    drop(first);
    std::fs::remove_file(&file).unwrap();
    let mut second = harness_of(preset("paper"), options(&saved));
    read_all(&mut second);
    read_all(&mut second);
    assert_eq!(second.state().services.missing_recordings.len(), 1);
    second.get_by_label("Remove from session").click();
    second.run_steps(3);
    let services = &second.state().services;
    assert!(services.missing_recordings.is_empty());
    let notices = &services.state.notices;
    assert!(notices.is_empty(), "{notices:?}");
}
