//! The sensitivity tool computes, suggests and sets a slider.

use std::time::Duration;

use eframe::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::support::{compared, simulate_again, state};
use super::{harness, pictures, says};
use crate::app::analysis::sensitivity::probes;
use crate::app::state::State;
use crate::model::effects;
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;

fn eta(harness: &Harness<'_, State>) -> f64 {
    harness.state().setup.preset.model.parameters[ParameterId::Eta]
}

/// Draws until there is a result for what is shown.
fn wait(harness: &mut Harness<'_, State>) {
    for _ in 0..6000 {
        harness.run_steps(1);
        let state = harness.state();
        let snapshot = state.snapshot.as_ref().unwrap();
        if state.sensing.found_for(snapshot).is_some() && state.sensing.progress().is_none() {
            harness.run_steps(3);
            return;
        }
        assert_eq!(state.sensing.error, None);
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("it does not come to an end");
}

#[test]
fn the_slider_that_is_off_is_suggested_tried_and_has_nothing_left_to_gain() {
    // So near that impacts keep their order: columns say nothing beyond.
    let mut state = compared(2, 1.000_05);
    state.sensing.open = true;
    let truth = 1.000_05 * ParameterId::Eta.spec().default;
    let mut harness = harness(state);
    wait(&mut harness);
    let found = harness.state().sensing.found().unwrap().clone();
    assert_eq!(found.overlays, [0, 1]);
    let of_eta = |harness: &Harness<'_, State>| {
        let found = harness.state().sensing.found().unwrap();
        let all = &found.sensitivity.influences;
        all.iter().find(|i| i.id == "eta").unwrap().clone()
    };
    let before = of_eta(&harness);
    assert!(before.steps_to_best > 0.0 && before.gain > 100.0);
    assert_eq!(pictures(&harness, "raise eta: ").len(), 1);
    let suggested = before.suggestion.unwrap().value;
    let start = eta(&harness);
    let share = (suggested - start) / (truth - start);
    assert!((share - 1.0).abs() < 0.5, "{share} of the way");
    // Its part of the residual is drawn where a person looks for it.
    assert!(!says(&harness, "part by eta"));
    // The slider itself has its symbol too, as a text.
    let symbol = |harness: &mut Harness<'_, State>, press: bool| {
        let button = harness.get_by_role_and_label(Role::Button, "\u{3b7}");
        if press {
            button.click();
        } else {
            button.scroll_to_me();
        }
        harness.run_steps(60);
    };
    symbol(&mut harness, false);
    symbol(&mut harness, true);
    assert_eq!(harness.state().sensing.selected.as_deref(), Some("eta"));
    assert!(says(&harness, "part by eta rec-0"));
    harness.get_by_label_contains("try eta ").click();
    harness.run_steps(3);
    assert_eq!(eta(&harness), suggested);
    // What was computed for the value before is no suggestion for this one.
    let button = harness.get_by_label_contains("try eta ");
    assert!(button.accesskit_node().is_disabled());
    simulate_again(harness.state_mut());
    wait(&mut harness);
    let after = of_eta(&harness);
    assert!(
        after.gain < 0.3 * before.gain,
        "{} {}",
        before.gain,
        after.gain
    );
}

#[test]
fn a_locked_slider_is_not_set_and_a_closed_tool_computes_nothing() {
    let mut state = compared(1, 1.001);
    state.setup.locked.insert("eta".to_owned());
    let mut harness = harness(state);
    harness.run_steps(5);
    assert!(harness.state().sensing.progress().is_none());
    harness.state_mut().sensing.open = true;
    wait(&mut harness);
    let button = harness.get_by_label_contains("try eta ");
    assert!(button.accesskit_node().is_disabled());
    harness.state_mut().sensing.open = false;
    harness.run_steps(3);
    let state = harness.state();
    let snapshot = state.snapshot.as_ref().unwrap();
    assert!(state.sensing.found_for(snapshot).is_none());
}

#[test]
fn a_newer_change_gives_up_what_is_being_computed() {
    let mut state = compared(1, 1.001);
    state.sensing.open = true;
    let mut harness = harness(state);
    wait(&mut harness);
    let parameters = &mut harness.state_mut().setup.preset.model.parameters;
    parameters.set(ParameterId::Alpha, 0.4);
    harness.run_steps(2);
    // The run is that of the value before: nothing is computed for it.
    assert!(harness.state().sensing.progress().is_none());
    simulate_again(harness.state_mut());
    wait(&mut harness);
    let found = harness.state().sensing.found().unwrap();
    assert_eq!(found.model.parameters[ParameterId::Alpha], 0.4);
}

#[test]
fn without_a_recording_it_says_so_and_effects_have_rows_of_their_own() {
    let mut state = state();
    state.sensing.open = true;
    let harness = harness(state);
    assert!(says(&harness, "Open a recording first"));
    let mut state = compared(1, 1.0);
    let spec = effects::CATALOGUE[0];
    let mut effect = ActiveEffect::new(spec);
    effect.values[0] = spec.parameters[0].range.1;
    state.setup.preset.model.effects.push(effect);
    let all = probes(&state.setup);
    let own = format!("{}.{}", spec.id, spec.parameters[0].id);
    assert!(all.iter().any(|probe| probe.id == own));
    assert!(all.iter().all(|probe| probe.step > 0.0));
    let eta = all.iter().find(|probe| probe.id == "eta").unwrap();
    let value = state.setup.preset.model.parameters[ParameterId::Eta];
    assert!((eta.step - 0.01 * value).abs() < 1e-12 * value);
    let alpha = all.iter().find(|probe| probe.id == "alpha").unwrap();
    assert!((alpha.step - 0.01).abs() < 1e-12);
}
