//! The presenter by its keys, and the mass pulled with the pointer.

use std::time::Duration;

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::super::window::Shell;
use super::{harness, preset, wait};
use crate::app::analysis::learning::built_in;
use crate::app::analysis::learning::presenting::Presenting;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::model::parameter::ParameterId;

fn presenting<'a>(harness: &'a Harness<'_, Shell>) -> &'a Presenting {
    harness.state().services.state.presenting.as_ref().unwrap()
}

fn press(harness: &mut Harness<'_, Shell>, key: Key) {
    harness.key_press(key);
    harness.run_steps(3);
}

/// Draws until every side shows the run of its scene.
fn runs_done(harness: &mut Harness<'_, Shell>) {
    for _ in 0..3000 {
        harness.run_steps(1);
        let is_done = presenting(harness).sides.iter().all(|side| {
            let model = side.result().map(|result| &result.run.model);
            model.is_some_and(|model| **model == side.scene.preset.model)
        });
        if is_done {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("a scene of the presenter has no run");
}

/// A window that presents a device.
fn presenter() -> Harness<'static, Shell> {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    press(&mut harness, Key::F11);
    runs_done(&mut harness);
    harness
}

fn x0(harness: &Harness<'_, Shell>, side: usize) -> f64 {
    let scene = &presenting(harness).sides[side].scene;
    scene.preset.model.parameters[ParameterId::X0]
}

fn names(harness: &Harness<'_, Shell>, role: Role) -> Vec<String> {
    let nodes = harness.query_all_by_role(role);
    let labels = nodes.map(|node| node.accesskit_node().label().unwrap_or_default());
    labels.collect()
}

fn image_starts(harness: &Harness<'_, Shell>, with: &str) -> usize {
    let names = names(harness, Role::Image);
    names.iter().filter(|name| name.starts_with(with)).count()
}

#[test]
fn it_fills_the_window_and_gives_it_back() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    let zoom = harness.ctx.zoom_factor();
    press(&mut harness, Key::F11);
    runs_done(&mut harness);
    assert!(harness.ctx.zoom_factor() > 1.5 * zoom);
    assert!(
        harness
            .query_by_role_and_label(Role::Button, "File")
            .is_none()
    );
    assert_eq!(image_starts(&harness, "Device"), 1);
    assert_eq!(image_starts(&harness, "Energies"), 1);
    assert!(image_starts(&harness, "Trajectory") > 0);
    press(&mut harness, Key::F11);
    assert!(harness.state().services.state.presenting.is_none());
    assert!((harness.ctx.zoom_factor() - zoom).abs() < 1e-6);
    assert!(
        harness
            .query_by_role_and_label(Role::Button, "File")
            .is_some()
    );
    press(&mut harness, Key::F11);
    press(&mut harness, Key::Escape);
    assert!(harness.state().services.state.presenting.is_none());
    assert!((harness.ctx.zoom_factor() - zoom).abs() < 1e-6);
}

#[test]
fn only_the_sliders_that_the_lesson_names_are_there() {
    let mut harness = harness(preset("paper"));
    wait(&mut harness, |_| true);
    let lesson = &built_in()[0];
    let step = lesson.steps.len() - 1;
    let state = &mut harness.state_mut().services.state;
    state.view.workspace = WorkspaceId::Learn.name().to_owned();
    state.learning.open_step(lesson, step);
    harness.run_steps(4);
    press(&mut harness, Key::F11);
    runs_done(&mut harness);
    let controls = lesson.steps[step].task.controls();
    let shown = names(&harness, Role::Slider);
    assert_eq!(shown.len(), controls.len(), "{shown:?}");
    for (name, control) in shown.iter().zip(controls) {
        assert!(name.starts_with(&control.id), "{name}");
    }
    assert_eq!(
        presenting(&harness).sides[0].scene,
        lesson.steps[step].scene
    );
}

#[test]
fn scenes_are_saved_on_digits_and_come_back() {
    let mut harness = presenter();
    let first = presenting(&harness).sides[0].scene.clone();
    let digits = [
        Key::Num1,
        Key::Num2,
        Key::Num3,
        Key::Num4,
        Key::Num5,
        Key::Num6,
        Key::Num7,
        Key::Num8,
        Key::Num9,
    ];
    let mut saved = Vec::new();
    for digit in digits {
        press(&mut harness, Key::ArrowRight);
        press(&mut harness, Key::S);
        press(&mut harness, digit);
        saved.push(presenting(&harness).sides[0].scene.clone());
    }
    assert_eq!(harness.state().services.state.scenes.len(), 9);
    for (i, scene) in saved.iter().enumerate() {
        assert!(*scene != first && !saved[..i].contains(scene), "{i}");
    }
    press(&mut harness, Key::E);
    for (digit, scene) in digits.into_iter().zip(&saved) {
        press(&mut harness, digit);
        assert_eq!(presenting(&harness).sides[0].scene, *scene);
        assert!(presenting(&harness).shows.energies, "bars were shown");
    }
    // Escape gives up saving, and does not leave.
    press(&mut harness, Key::S);
    press(&mut harness, Key::Escape);
    assert!(!presenting(&harness).is_saving);
    press(&mut harness, Key::Num0);
    assert_eq!(presenting(&harness).sides[0].scene, saved[8], "0 restores");
}

#[test]
fn a_and_b_stand_beside_each_other_and_are_changed_one_at_a_time() {
    let mut harness = presenter();
    press(&mut harness, Key::B);
    runs_done(&mut harness);
    assert_eq!(presenting(&harness).sides.len(), 2);
    assert_eq!(image_starts(&harness, "Device"), 2);
    let before = presenting(&harness).sides[0].scene.clone();
    press(&mut harness, Key::ArrowRight);
    let sides = &presenting(&harness).sides;
    assert_eq!(sides[0].scene, before);
    assert_ne!(sides[1].scene, before);
    press(&mut harness, Key::X);
    press(&mut harness, Key::ArrowLeft);
    assert_ne!(presenting(&harness).sides[0].scene, before);
    // The other slider.
    let first = presenting(&harness).control;
    press(&mut harness, Key::ArrowDown);
    assert_ne!(presenting(&harness).control, first);
    press(&mut harness, Key::ArrowUp);
    assert_eq!(presenting(&harness).control, first);
    press(&mut harness, Key::B);
    assert_eq!(presenting(&harness).sides.len(), 1);
    assert_eq!(image_starts(&harness, "Device"), 1);
}

#[test]
fn it_plays_pauses_and_steps_by_keys_and_pictures_are_switched() {
    let mut harness = presenter();
    let time = |harness: &Harness<'_, Shell>| presenting(harness).playback.time;
    press(&mut harness, Key::Space);
    let paused = time(&harness);
    harness.run_steps(5);
    assert_eq!(time(&harness), paused);
    press(&mut harness, Key::Period);
    let later = time(&harness);
    assert!(later > paused);
    press(&mut harness, Key::Comma);
    assert!(time(&harness) < later);
    press(&mut harness, Key::Space);
    harness.run_steps(5);
    assert!(time(&harness) > paused);
    let speed = presenting(&harness).playback.speed;
    press(&mut harness, Key::Plus);
    assert!(presenting(&harness).playback.speed > speed);
    press(&mut harness, Key::Minus);
    assert!((presenting(&harness).playback.speed / speed - 1.0).abs() < 1e-9);
    press(&mut harness, Key::E);
    assert_eq!(image_starts(&harness, "Energies"), 0);
    press(&mut harness, Key::P);
    assert_eq!(image_starts(&harness, "Trajectory"), 0);
    press(&mut harness, Key::H);
    assert!(
        harness
            .query_all_by_label_contains("Keys of the presenter")
            .next()
            .is_some()
    );
    press(&mut harness, Key::Escape);
    assert!(
        harness
            .query_all_by_label_contains("Keys of the presenter")
            .next()
            .is_none()
    );
    let slows = presenting(&harness).playback.slows_at_impacts;
    press(&mut harness, Key::M);
    assert_ne!(presenting(&harness).playback.slows_at_impacts, slows);
    // The keys of the window are not those of the presenter.
    let dark = harness.state().services.state.view.dark;
    press(&mut harness, Key::N);
    assert_eq!(harness.state().services.state.view.dark, dark);
}

#[test]
fn the_mass_is_pulled_with_the_pointer_or_by_keys_and_let_go() {
    let mut harness = presenter();
    press(&mut harness, Key::Space);
    let begin = x0(&harness, 0);
    let images = harness.query_all_by_role(Role::Image);
    let device = images
        .filter(|node| {
            let label = node.accesskit_node().label().unwrap_or_default();
            label.starts_with("Device")
        })
        .map(|node| node.rect())
        .next()
        .unwrap();
    let from = device.center();
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(pos2(from.x, device.top() + 0.2 * device.height()));
    harness.run_steps(2);
    let held = presenting(&harness).pulled.unwrap();
    assert_eq!(presenting(&harness).playback.time, 0.0);
    assert!((x0(&harness, 0) - held).abs() < 1e-9, "{held}");
    harness.drop_at(pos2(from.x, device.top() + 0.2 * device.height()));
    harness.run_steps(2);
    assert_eq!(presenting(&harness).pulled, None);
    let let_go_at = presenting(&harness).let_go_at.unwrap();
    assert!(let_go_at > 0.0 && x0(&harness, 0) != begin);
    assert!(presenting(&harness).playback.is_playing);
    let is_said = harness
        .query_all_by_label_contains("let go at")
        .next()
        .is_some();
    assert!(is_said, "the kick is shown in SI");
    runs_done(&mut harness);
    let trace = &presenting(&harness).sides[0].result().unwrap().run.trace;
    assert!((trace.proof_mass[0] - let_go_at).abs() < 1e-9);
    press(&mut harness, Key::Num0);
    assert_eq!(x0(&harness, 0), begin);
    runs_done(&mut harness);
    press(&mut harness, Key::K);
    assert!(x0(&harness, 0) > 0.0);
}

#[test]
fn a_film_is_asked_for_between_the_brackets() {
    let mut harness = presenter();
    press(&mut harness, Key::Space);
    press(&mut harness, Key::OpenBracket);
    for _ in 0..5 {
        press(&mut harness, Key::Period);
    }
    press(&mut harness, Key::CloseBracket);
    let (from, to) = presenting(&harness).film;
    assert!(from.unwrap() < to.unwrap());
    press(&mut harness, Key::V);
    let services = &harness.state().services;
    let request = services.film.as_ref().unwrap();
    assert_eq!(request.span, (from.unwrap(), to.unwrap()));
    assert!(services.dialogs.is_open(), "it asks for a path");
    // Its letters go to the dialog, not to the presenter.
    let slows = presenting(&harness).playback.slows_at_impacts;
    harness.key_press_modifiers(Modifiers::NONE, Key::M);
    harness.run_steps(2);
    assert_eq!(presenting(&harness).playback.slows_at_impacts, slows);
}
