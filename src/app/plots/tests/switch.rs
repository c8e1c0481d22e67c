//! Curves are shown and hidden by their names; heights are changed with the handles.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};

use crate::app::plots::tests::*;

fn forces() -> Harness<'static, State> {
    let mut state = with(empty(), trace(20_000));
    state.view.pictures = [Picture::Voltage, Picture::Forces].into();
    harness(state)
}

#[test]
fn a_click_on_its_name_shows_and_hides_a_curve() {
    let mut harness = forces();
    // The drive force is much larger than the others, so it is hidden at first.
    assert!(names(&harness).iter().any(|name| name.contains("[nN]")));
    harness.get_by_label("Show Forces: drive").click();
    harness.run_steps(2);
    assert!(
        harness
            .state()
            .view
            .switched_curves
            .contains("Forces: drive")
    );
    assert!(
        names(&harness)
            .iter()
            .any(|name| name.contains("[\u{b5}N]"))
    );
    harness.get_by_label("Show Forces: drive").click();
    harness.run_steps(2);
    assert!(harness.state().view.switched_curves.is_empty());
}

#[test]
fn each_of_many_recordings_has_one_name_for_all_its_curves() {
    let mut state = empty();
    for id in 0..9 {
        state = recorded(state);
        let overlay = state.setup.overlays.last_mut().unwrap();
        let mut recording = overlay.recording.as_ref().clone();
        recording.name = format!("tap-{id}.csv");
        (overlay.id, overlay.color) = (id, id as usize);
        overlay.recording = Arc::new(recording);
    }
    let mut harness = harness(with(state, trace(20_000)));
    let entry = |harness: &Harness<'_, State>, name: &str| {
        harness.query_all_by_label_contains(name).count()
    };
    assert_eq!(entry(&harness, "Show tap-4.csv"), 1);
    assert_eq!(entry(&harness, "Show Trajectory: xp tap-4.csv"), 0);
    assert_eq!(entry(&harness, "Show Trajectory: xp"), 1);
    harness.get_by_label("Show tap-4.csv").click();
    harness.run_steps(2);
    let switched = &harness.state().view.switched_curves;
    for key in [
        "Voltage: V tap-4.csv",
        "Trajectory: xp tap-4.csv",
        "Residual: residual tap-4.csv",
    ] {
        assert!(switched.contains(key), "{key} is not in {switched:?}");
    }
    harness.get_by_label("Show tap-4.csv").click();
    harness.run_steps(2);
    assert!(harness.state().view.switched_curves.is_empty());
    let colors: std::collections::BTreeSet<_> = (0..12)
        .map(|i| {
            let mut color = None;
            let context = eframe::egui::Context::default();
            let mut output = context.run_ui(Default::default(), |ui| {
                color = Some(crate::app::plots::frame::style::overlay_color(ui, i).to_array());
            });
            output.textures_delta.clear();
            color
        })
        .collect();
    assert_eq!(colors.len(), 12, "no two recordings look alike");
}

fn heights(harness: &Harness<'_, State>) -> (f32, f32) {
    let height = |name| plot(harness, name).height();
    (height("Voltage"), height("Forces"))
}

#[test]
fn a_handle_changes_the_heights() {
    let mut harness = forces();
    let before = heights(&harness);
    let at = harness
        .get_by_label("Height of Voltage and Forces")
        .rect()
        .center();
    harness.event(Event::PointerMoved(at));
    harness.step();
    for (y, pressed) in [(0.0, true), (40.0, false)] {
        let pos = at + vec2(0.0, y);
        harness.event(Event::PointerMoved(pos));
        harness.step();
        harness.event(Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        harness.step();
    }
    harness.run_steps(2);
    let after = heights(&harness);
    assert!(
        (after.0 - before.0 - 40.0).abs() < 4.0,
        "{before:?} {after:?}"
    );
    assert!(
        (after.1 - before.1 + 40.0).abs() < 4.0,
        "{before:?} {after:?}"
    );
}

#[test]
fn a_handle_moves_by_the_arrow_keys() {
    let mut harness = forces();
    let before = heights(&harness);
    harness.get_by_label("Height of Voltage and Forces").focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowDown);
    harness.run_steps(3);
    let after = heights(&harness);
    assert!(after.0 > before.0 + 6.0, "{before:?} {after:?}");
    // The scales of the plots are splitters too; each has its own name.
    let splitters = harness.query_all_by_role(Role::Splitter);
    let mut names: Vec<String> = splitters
        .map(|node| node.accesskit_node().label().unwrap())
        .collect();
    names.sort();
    let expected = [
        "Height of Voltage and Forces",
        "Scale of Forces",
        "Scale of Voltage",
    ];
    assert_eq!(names, expected);
}

#[test]
fn a_device_without_forces_gives_the_reason() {
    let mut state = with(empty(), trace(2000));
    state.setup.preset = Preset::embedded("oscillator").unwrap();
    state.view.pictures = [Picture::Forces].into();
    let mut run = trace(2000);
    run.forces = Some(ForceTraces::default());
    let described = |state: &State| {
        let mut message = None;
        let context = eframe::egui::Context::default();
        let mut output = context.run_ui(Default::default(), |ui| {
            message = crate::app::plots::forces::describe(ui, state).message;
        });
        output.textures_delta.clear();
        message
    };
    assert_eq!(described(&state), None);
    let state = with(state, run);
    let message = described(&state).unwrap();
    assert!(
        message.contains("no drive, no ground and no effects"),
        "{message}"
    );
}

#[test]
fn kept_curves_are_drawn_with_their_residuals_and_shown_and_hidden_as_one() {
    let mut state = with(recorded(empty()), trace(20_000));
    keep(&mut state, "soft film");
    keep(&mut state, "stiff film");
    state.setup.kept[1].visible = false;
    let mut harness = harness(state);
    // The names of the curves that are drawn.
    let drawn = |harness: &Harness<'_, State>| -> Vec<String> {
        let state = harness.state().clone();
        let mut found = Vec::new();
        let context = eframe::egui::Context::default();
        let mut output = context.run_ui(Default::default(), |ui| {
            let (plots, _) = crate::app::plots::describe(ui, &state);
            let names = (plots.iter()).flat_map(|plot| plot.drawn().map(|c| c.name.clone()));
            found = names.collect::<Vec<_>>();
            let size = [300.0, 200.0];
            let plane = crate::app::plots::plane(ui, &state, Picture::PhasePortrait, size);
            found.extend(plane.lines.iter().map(|line| format!("vp {}", line.name)));
        });
        output.textures_delta.clear();
        found
    };
    let lines = [
        "soft film: xp",
        "soft film: xp simulated as tap.csv",
        "soft film: residual tap.csv",
        "vp soft film: xp",
    ];
    let shown = drawn(&harness);
    for line in lines {
        assert!(shown.iter().any(|name| name == line), "{line}: {shown:?}");
    }
    assert!(
        !shown.iter().any(|name| name.contains("stiff")),
        "{shown:?}"
    );
    let entries = harness.query_all_by_label_contains("Show kept: soft film");
    assert_eq!(entries.count(), 1, "one entry for all its lines");
    harness.get_by_label("Show kept: soft film").click();
    harness.run_steps(2);
    let hidden = drawn(&harness);
    assert!(
        !hidden.iter().any(|name| name.contains("soft")),
        "{hidden:?}"
    );
    assert!(hidden.iter().any(|name| name == "xp"));
    harness.state_mut().setup.kept[1].visible = true;
    harness.run_steps(2);
    assert!(drawn(&harness).iter().any(|name| name == "stiff film: xp"));
}
