//! Sliders: mouse, keys, typing, reset, lock, errors, screen readers.

use eframe::egui::{Key, Modifiers, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use super::support::{full, state};
use super::{harness, has_track, says, track, type_into};
use crate::app::setup::current_setup::choose_preset;
use crate::app::setup::notice::Refusal;
use crate::app::state::State;
use crate::model::parameter::ParameterId as P;
use crate::model::preset::Preset;

fn value(state: &State, id: P) -> f64 {
    state.setup.preset.model.parameters[id]
}

#[test]
fn a_drag_moves_the_value_on_a_log_scale() {
    let mut harness = harness(state());
    let rect = track(&harness, "Cs").rect();
    let start = pos2(rect.left() + 0.5 * rect.width(), rect.center().y);
    harness.drag_at(start);
    harness.run_steps(2);
    // The middle of 1e-23..1e-19.
    let middle = value(harness.state(), P::Cs);
    assert!((middle / 1e-21).log10().abs() < 0.05, "{middle}");
    harness.hover_at(start + vec2(0.25 * rect.width(), 0.0));
    harness.run_steps(2);
    let right = value(harness.state(), P::Cs);
    assert!(
        (right / middle).log10() > 0.9 && (right / middle).log10() < 1.2,
        "{right}"
    );
    harness.drop_at(start + vec2(0.25 * rect.width(), 0.0));
    harness.run_steps(2);
    assert_eq!(value(harness.state(), P::Cs), right);
}

#[test]
fn shift_makes_drags_finer() {
    let mut harness = harness(state());
    let rect = track(&harness, "gp").rect();
    let before = value(harness.state(), P::Gp);
    let distant = pos2(rect.left() + 0.8 * rect.width(), rect.center().y);
    harness.event(eframe::egui::Event::ModifiersChanged(Modifiers::SHIFT));
    harness.drag_at(distant);
    harness.run_steps(2);
    assert_eq!(
        value(harness.state(), P::Gp),
        before,
        "fine: no jump to the pointer"
    );
    harness.event(eframe::egui::Event::ModifiersChanged(Modifiers::SHIFT));
    harness.hover_at(distant + vec2(0.1 * rect.width(), 0.0));
    harness.step();
    let moved = value(harness.state(), P::Gp) - before;
    // A tenth of a tenth of 180 um.
    assert!((moved - 1.8e-6).abs() < 0.4e-6, "{moved}");
}

#[test]
fn a_tap_within_one_frame_moves_the_slider_and_focuses_it() {
    use eframe::egui::{Event, PointerButton};
    let mut harness = harness(state());
    let pos = track(&harness, "alpha").rect().center();
    harness.hover_at(pos);
    harness.run_steps(2);
    for pressed in [true, false] {
        harness.input_mut().events.push(Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }
    harness.step();
    assert!((value(harness.state(), P::Alpha) - 0.5).abs() < 0.01);
    harness.run_steps(2);
    assert!(track(&harness, "alpha").is_focused());
}

#[test]
fn arrow_keys_and_screen_readers_move_the_slider() {
    let mut harness = harness(state());
    let before = value(harness.state(), P::Alpha);
    track(&harness, "alpha").focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    let step = value(harness.state(), P::Alpha) - before;
    assert!((step - 0.01).abs() < 1e-3, "{step}");
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowLeft);
    harness.run_steps(2);
    let fine = value(harness.state(), P::Alpha) - before - step;
    assert!((fine + 0.001).abs() < 3e-4, "{fine}");
    track(&harness, "alpha").set_value_accesskit(0.25);
    harness.run_steps(2);
    assert_eq!(value(harness.state(), P::Alpha), 0.25);
    assert_eq!(
        track(&harness, "alpha").accesskit_node().numeric_value(),
        Some(0.25)
    );
    assert_eq!(track(&harness, "gp").value().as_deref(), Some("70 µm"));
    harness.key_press(Key::Backspace);
    harness.run_steps(2);
    assert_eq!(value(harness.state(), P::Alpha), 0.378, "Backspace resets");
}

#[test]
fn typed_quantities_are_accepted_and_invalid_ones_explained() {
    let mut harness = harness(state());
    type_into(&mut harness, "gp value", "85 um");
    assert!((value(harness.state(), P::Gp) - 85e-6).abs() < 1e-15);
    type_into(&mut harness, "Cs value", "2e-21");
    assert_eq!(value(harness.state(), P::Cs), 2e-21);
    type_into(&mut harness, "Ca0 value", "27 nN");
    assert!((value(harness.state(), P::Ca0) - 27e-9).abs() < 1e-18);
    type_into(&mut harness, "gp value", "3 ms");
    assert!((value(harness.state(), P::Gp) - 85e-6).abs() < 1e-15);
    assert!(says(&harness, "is not a unit of this quantity"));
    type_into(&mut harness, "alpha value", "1.5");
    assert_eq!(value(harness.state(), P::Alpha), 0.378);
    assert!(says(&harness, "alpha = 1.5 is above 1"));
}

#[test]
fn values_outside_the_track_can_be_typed() {
    let mut harness = harness(state());
    type_into(&mut harness, "gp value", "500 um");
    assert!((value(harness.state(), P::Gp) - 500e-6).abs() < 1e-15);
    assert_eq!(track(&harness, "gp").value().as_deref(), Some("500 µm"));
}

#[test]
fn escape_discards_what_was_typed() {
    let mut harness = harness(state());
    harness.get_by_label("gp value").click();
    harness.run_steps(3);
    harness.get_by_label("gp value").type_text("99 um");
    harness.run_steps(2);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert_eq!(value(harness.state(), P::Gp), 70e-6);
    assert!(!says(&harness, "99"));
}

#[test]
fn reset_icon_and_double_click_restore_the_default() {
    let mut harness = harness(full());
    harness.get_by_label("reset Cs").click();
    harness.run_steps(3);
    assert_eq!(value(harness.state(), P::Cs), 1.747e-21);
    assert!(harness.query_by_label("reset Cs").is_none());
    for _ in 0..2 {
        track(&harness, "alpha").click();
        harness.run_steps(4);
    }
    harness.run_steps(2);
    assert_eq!(value(harness.state(), P::Alpha), 0.378);
}

#[test]
fn a_locked_slider_does_not_move() {
    let mut harness = harness(state());
    harness.get_by_label("lock Cs").click();
    harness.run_steps(3);
    assert!(harness.state().setup.locked.contains("Cs"));
    let before = value(harness.state(), P::Cs);
    let rect = track(&harness, "Cs").rect();
    harness.drag_at(rect.right_center() - vec2(20.0, 0.0));
    harness.run_steps(2);
    harness.drop_at(rect.right_center() - vec2(20.0, 0.0));
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    assert_eq!(value(harness.state(), P::Cs), before);
    harness.get_by_label("lock Cs").click();
    harness.run_steps(3);
    assert!(!harness.state().setup.locked.contains("Cs"));
}

#[test]
fn an_invalid_combination_is_shown_at_the_slider() {
    let mut state = state();
    state.setup.preset.model.parameters.set(P::Dp, 90e-6);
    let harness = harness(state);
    assert!(says(&harness, "gp = 70 µm must exceed dp = 90 µm"));
    assert!(says(&harness, "last valid one"));
}

#[test]
fn a_refusal_of_the_simulator_is_shown() {
    let mut state = state();
    state.refusal = Some(Refusal {
        parameter: "alpha".to_owned(),
        message: "gave up after 1000000 events".to_owned(),
    });
    let harness = harness(state);
    assert!(says(&harness, "gave up after 1000000 events"));
}

#[test]
fn parameters_the_device_lacks_are_hidden() {
    let mut state = state();
    choose_preset(&mut state.setup, &Preset::embedded("oscillator").unwrap());
    let harness = harness(state);
    assert!(has_track(&harness, "zeta1"));
    for id in ["Cs", "gp", "Ca", "Ca0", "alpha", "eta", "dp", "zeta2"] {
        assert!(!has_track(&harness, id), "{id}");
    }
}
