//! The residual's unit and scale.

use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Modifiers, PointerButton, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::support::{compared, simulate_again};
use super::{harness, pictures, says, type_into};
use crate::app::setup::view::ResidualUnit;
use crate::app::state::State;
use crate::model::parameter::ParameterId;

const LIMITS: &str = "limits of the residual";

/// The limits of the residual's scale as its field shows them.
fn limits(harness: &Harness<'_, State>) -> String {
    let field = harness.get_by_role_and_label(Role::TextInput, LIMITS);
    field.accesskit_node().value().unwrap_or_default()
}

fn set_eta(harness: &mut Harness<'_, State>, factor: f64) {
    let state = harness.state_mut();
    let eta = ParameterId::Eta.spec().default;
    let parameters = &mut state.setup.preset.model.parameters;
    parameters.set(ParameterId::Eta, factor * eta);
    simulate_again(state);
    harness.run_steps(3);
}

#[test]
fn the_residual_says_its_direction_and_is_shown_in_units_of_the_noise() {
    let mut harness = harness(compared(1, 1.01));
    let name = &pictures(&harness, "Residual")[0];
    let direction = "Residual: simulation \u{2212} recording [";
    assert!(name.starts_with(direction), "{name}");
    harness.get_by_label("x noise").click();
    harness.run_steps(3);
    let unit = harness.state().view.residual_unit;
    assert_eq!(unit, ResidualUnit::Noise);
    let name = &pictures(&harness, "Residual")[0];
    assert!(name.contains("recording [x noise]"), "{name}");
    assert!(
        limits(&harness).ends_with("x noise"),
        "{}",
        limits(&harness)
    );
    harness.get_by_label("\u{b5}m").click();
    harness.run_steps(3);
    assert_eq!(harness.state().view.residual_unit, ResidualUnit::Length);
}

#[test]
fn a_fixed_scale_stays_whatever_the_residual_does_and_is_given_up_on_purpose() {
    let mut harness = harness(compared(1, 1.01));
    harness.get_by_label("\u{b1}5 x noise").click();
    harness.run_steps(3);
    let scale = ResidualUnit::Noise.scale_name();
    let fixed = |harness: &Harness<'_, State>| {
        let view = &harness.state().view;
        view.value_ranges.get(scale).copied()
    };
    assert_eq!(fixed(&harness), Some((-5.0, 5.0)));
    assert_eq!(limits(&harness), "5 x noise");
    for factor in [1.2, 1.01] {
        set_eta(&mut harness, factor);
        assert_eq!(limits(&harness), "5 x noise");
    }
    harness.state_mut().view.zoom_out_values();
    assert_eq!(fixed(&harness), Some((-5.0, 5.0)));
    // The other unit has a scale of its own.
    harness.get_by_label("\u{b5}m").click();
    harness.run_steps(3);
    type_into(&mut harness, LIMITS, "2 um");
    let length = ResidualUnit::Length.scale_name();
    let range = harness.state().view.value_ranges[length];
    assert!((range.0 + 2e-6).abs() < 1e-15 && (range.1 - 2e-6).abs() < 1e-15);
    type_into(&mut harness, LIMITS, "-1 um");
    assert_eq!(harness.state().view.value_ranges[length], range);
    harness.get_by_label("automatic").click();
    harness.run_steps(3);
    assert!(!harness.state().view.value_ranges.contains_key(length));
    assert_eq!(fixed(&harness), Some((-5.0, 5.0)));
}

#[test]
fn an_automatic_scale_grows_at_once_and_shrinks_after_the_drag() {
    let mut harness = harness(compared(1, 1.01));
    harness.get_by_label("x noise").click();
    harness.run_steps(3);
    let number = |harness: &Harness<'_, State>| -> f64 {
        let text = limits(harness);
        let number = text.split(' ').next().unwrap_or_default();
        number.parse().unwrap()
    };
    let before = number(&harness);
    let held = |harness: &mut Harness<'_, State>, pressed: bool| {
        // Beside all controls.
        let pos = pos2(2.0, 700.0);
        harness.event(Event::PointerMoved(pos));
        harness.event(Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        harness.run_steps(2);
    };
    held(&mut harness, true);
    set_eta(&mut harness, 1.1);
    let grown = number(&harness);
    assert!(grown > 2.0 * before, "{before}, {grown}");
    set_eta(&mut harness, 1.01);
    assert_eq!(number(&harness), grown, "it shrinks during the drag");
    held(&mut harness, false);
    let after = number(&harness);
    assert!(after < 0.5 * grown, "{grown}, {after}");
}

#[test]
fn a_recording_without_noise_is_named_and_drawn_as_a_length() {
    let mut state = compared(2, 1.01);
    let mut snapshot = state.snapshot.as_ref().unwrap().as_ref().clone();
    snapshot.comparisons[1].noise = None;
    state.snapshot = Some(std::sync::Arc::new(snapshot));
    let mut harness = harness(state);
    assert!(!says(&harness, "rec-1.csv has no noise"));
    harness.get_by_label("x noise").click();
    harness.run_steps(3);
    assert!(says(&harness, "rec-1.csv has no noise"));
    assert_eq!(pictures(&harness, "Residual").len(), 1);
}
