//! Effects, presets, drive editor, recordings, readouts, transport.

use std::sync::Arc;

use eframe::egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

use super::support::{full, live, overlay, recording, state};
use super::{harness, has_track, says, type_into};
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::choose_preset;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::workspaces::tune::recordings::remove as remove_recording;
use crate::model::drive::Waveform;
use crate::model::effects::CATALOGUE;
use crate::model::preset::Preset;

#[test]
fn an_effect_is_switched_on_and_shows_its_sliders() {
    let mut harness = harness(state());
    harness.get_by_label("Effects").scroll_to_me();
    harness.run_steps(60);
    harness.get_by_label("Effects").click();
    harness.run_steps(30);
    harness.get_by_label(CATALOGUE[0].name).scroll_to_me();
    harness.run_steps(60);
    let effect = CATALOGUE[0];
    assert!(!says(&harness, effect.law));
    harness.get_by_label(effect.name).click();
    harness.run_steps(5);
    assert_eq!(harness.state().setup.preset.model.effects[0].spec, effect);
    let id = format!("{}.{}", effect.id, effect.parameters[0].id);
    assert!(has_track(&harness, &id));
    assert!(says(&harness, effect.law) && says(&harness, effect.source));
    let field = format!("{id} value");
    harness.get_by_label(&field).scroll_to_me();
    harness.run_steps(60);
    let text = format!("{:e}", 2.0 * effect.parameters[0].default);
    type_into(&mut harness, &field, &text);
    let set = harness.state().setup.preset.model.effects[0].values[0];
    assert!((set / effect.parameters[0].default - 2.0).abs() < 1e-9);
    harness.get_by_label(effect.name).click();
    harness.run_steps(5);
    assert!(harness.state().setup.preset.model.effects.is_empty());
}

#[test]
fn a_preset_changes_the_device_but_keeps_recordings_and_a_valid_drive() {
    let mut state = full();
    state.setup.drive = DriveChoice::Waveform(Waveform::Sine {
        frequency: 7.0,
        amplitude: 6.0,
    });
    choose_preset(
        &mut state.setup,
        &Preset::embedded("paper-as-printed").unwrap(),
    );
    assert_eq!(state.setup.overlays.len(), 2);
    assert!(matches!(
        &state.setup.drive,
        DriveChoice::Waveform(Waveform::Sine { .. })
    ));
    choose_preset(&mut state.setup, &Preset::embedded("oscillator").unwrap());
    assert_eq!(state.setup.overlays.len(), 2);
    assert_eq!(state.setup.drive, DriveChoice::Waveform(Waveform::Rest));
    assert_eq!(state.setup.duration, 30.0);
}

#[test]
fn reset_all_works_when_something_changed() {
    let mut harness = harness(full());
    harness.get_by_label("Reset all").click();
    harness.run_steps(3);
    assert_eq!(harness.state().commands, [Command::ResetParameters]);
}

#[test]
fn the_drive_can_be_edited_and_invalid_values_are_refused() {
    let mut harness = harness(state());
    type_into(&mut harness, "frequency value", "40 Hz");
    let square = |frequency, amplitude| {
        DriveChoice::Waveform(Waveform::Square {
            frequency,
            amplitude,
        })
    };
    assert_eq!(harness.state().setup.drive, square(40.0, 8.0));
    type_into(&mut harness, "amplitude value", "6V");
    assert_eq!(harness.state().setup.drive, square(40.0, 6.0));
    type_into(&mut harness, "frequency value", "-5");
    assert_eq!(
        harness.state().setup.drive,
        square(40.0, 6.0),
        "the last valid drive stays"
    );
    assert!(says(&harness, "is below"));
}

#[test]
fn a_drive_beyond_what_was_measured_is_said_at_its_slider() {
    let mut harness = harness(state());
    assert!(!says(&harness, "this is extrapolated"));
    type_into(&mut harness, "amplitude value", "9 V");
    assert!(says(&harness, "measured up to 8 V: this is extrapolated"));
    type_into(&mut harness, "amplitude value", "8 V");
    assert!(!says(&harness, "this is extrapolated"));
    type_into(&mut harness, "frequency value", "150 Hz");
    assert!(says(
        &harness,
        "measured up to 100 Hz: this is extrapolated"
    ));
}

#[test]
fn the_drive_editor_opens_beside_the_plots_and_edits_a_table() {
    let mut state = state();
    state.setup.drive =
        crate::app::workspaces::tune::drive::editor::of_kind(&state.setup, "table").unwrap();
    state.drive_editor_open = true;
    let mut harness = harness(state);
    assert!(says(&harness, "Drive editor"));
    let points = |harness: &egui_kittest::Harness<'_, crate::app::state::State>| match &harness
        .state()
        .setup
        .drive
    {
        DriveChoice::Waveform(Waveform::Table(table)) => table.points().unwrap().0.len(),
        other => panic!("{other:?}"),
    };
    assert_eq!(points(&harness), 5);
    let button = harness.get_all_by_label("Add point").last().unwrap();
    button.click();
    harness.run_steps(3);
    assert_eq!(points(&harness), 6);
}

#[test]
fn recordings_are_listed_selected_hidden_and_removed() {
    let mut harness = harness(full());
    assert!(says(&harness, "synthetic"));
    assert!(says(&harness, "100 ms at 50 kHz"));
    harness
        .get_by_label("show tapping-15Hz-8V-made-up.csv")
        .click();
    harness.run_steps(3);
    assert!(!harness.state().setup.overlays[0].visible);
    harness.get_by_label("Auto-align").click();
    harness.run_steps(3);
    assert_eq!(harness.state().commands, [Command::AutoAlign]);
    harness.get_by_label("Use its voltage as drive").click();
    harness.run_steps(3);
    assert_eq!(harness.state().setup.drive, DriveChoice::Recorded(0));
    harness
        .get_by_label("remove tapping-15Hz-8V-made-up.csv")
        .click();
    harness.run_steps(3);
    assert_eq!(harness.state().setup.overlays.len(), 1);
    assert!(matches!(
        harness.state().setup.drive,
        DriveChoice::Waveform(Waveform::Square { .. })
    ));
}

#[test]
fn removing_a_recording_clears_the_selection() {
    let mut state = full();
    remove_recording(&mut state, 0);
    assert_eq!(state.selected, None);
    remove_recording(&mut state, 77);
    assert_eq!(state.setup.overlays.len(), 1);
}

#[test]
fn an_oscillator_starts_from_its_recording() {
    let mut state = state();
    choose_preset(&mut state.setup, &Preset::embedded("oscillator").unwrap());
    state.setup.overlays = vec![overlay(3, recording("ring.csv", 0.1), false)];
    state.selected = Some(3);
    let mut harness = harness(state);
    harness.get_by_label("Start from its first samples").click();
    harness.run_steps(3);
    let parameters = &harness.state().setup.preset.model.parameters;
    assert_ne!(parameters[crate::model::parameter::ParameterId::V0], 0.0);
}

#[test]
fn readouts_show_their_numbers() {
    let harness = harness(full());
    for part in [
        "rms 1.25 µm",
        "NRMSE 1.4 %",
        "51.9 % better than kept 1 (2.6 µm)",
        "212 (+41)",
        "31.4",
        "1 impact, 1 stick, 1 release",
        "1.747e-21 N m^2 s",
        "15 Hz, 8 V, square",
        "264",
    ] {
        assert!(says(&harness, part), "{part}");
    }
}

#[test]
fn transport_sets_the_span() {
    let mut harness = harness(full());
    type_into(&mut harness, "span", "0.5 s");
    assert_eq!(harness.state().setup.duration, 0.5);
    type_into(&mut harness, "span", "-1 s");
    assert_eq!(harness.state().setup.duration, 0.5);
    assert!(says(&harness, "the span must lie between"));
    harness.get_by_label("Match recording length").click();
    harness.run_steps(3);
    assert!((harness.state().setup.duration - 0.09998).abs() < 1e-9);
    harness.get_by_label("Live").click();
    harness.run_steps(3);
    assert_eq!(harness.state().commands, [Command::SetMode(Mode::Live)]);
}

#[test]
fn transport_runs_scrubs_and_follows() {
    let mut harness = harness(live());
    assert!(says(&harness, "1/100, reached 1/101"));
    harness.get_by_label("pause").click();
    harness.run_steps(3);
    assert_eq!(harness.state().commands, [Command::TogglePause]);
    let bar = harness.get_by_label("history").rect();
    harness.drag_at(bar.center());
    harness.run_steps(2);
    harness.drop_at(bar.center());
    harness.run_steps(2);
    let scrub = harness.state().scrub.unwrap();
    assert!((scrub - 0.717).abs() < 0.03, "{scrub}");
    harness.get_by_label("Follow").click();
    harness.run_steps(3);
    assert_eq!(harness.state().scrub, None);
}

#[test]
fn why_there_is_no_number_between_impacts_is_said() {
    let mut state = full();
    let shown = Arc::make_mut(state.snapshot.as_mut().unwrap());
    shown.comparisons[0].stretches = Some(Err("it is too short".to_owned()));
    assert!(says(&harness(state), "between impacts: it is too short"));
}

#[test]
fn the_side_panel_can_be_hidden() {
    let mut harness = harness(full());
    assert!(says(&harness, "NRMSE 1.4"));
    harness
        .get_by_role_and_label(Role::Button, "Recordings")
        .click();
    harness.run_steps(40);
    assert!(!says(&harness, "NRMSE 1.4"));
    // The misfit itself stays in view.
    assert!(says(&harness, "misfit 62.5 x noise"));
}
