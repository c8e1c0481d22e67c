//! Curves switched by their names, heights shared out by the handles.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};

use super::*;

fn forces() -> Harness<'static, State> {
    let mut state = with(empty(), trace(20_000));
    state.view.pictures = [Picture::Voltage, Picture::Forces].into();
    harness(state)
}

#[test]
fn a_click_on_its_name_shows_and_hides_a_curve() {
    let mut harness = forces();
    // The drive dwarfs the other forces: it waits to be asked for.
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

fn heights(harness: &Harness<'_, State>) -> (f32, f32) {
    let height = |name| plot(harness, name).height();
    (height("Voltage"), height("Forces"))
}

#[test]
fn a_handle_shares_out_the_height() {
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
fn a_handle_obeys_the_arrow_keys() {
    let mut harness = forces();
    let before = heights(&harness);
    harness.get_by_label("Height of Voltage and Forces").focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowDown);
    harness.run_steps(3);
    let after = heights(&harness);
    assert!(after.0 > before.0 + 6.0, "{before:?} {after:?}");
    let handle = harness.get_by_role(Role::Splitter);
    assert!(handle.accesskit_node().label().is_some());
}
