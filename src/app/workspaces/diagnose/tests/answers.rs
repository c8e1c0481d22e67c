//! What the workspace shows without an answer, and for answers written by hand.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use eframe::egui::accesskit::Role as Kind;
use egui_kittest::kittest::Queryable;

use super::support::{answered, empty, with};
use super::{harness, harness_of, press, says};
use crate::app::analysis::diagnosis::{obstacle, options};
use crate::app::analysis::diagnosis_answer::Asked;
use crate::app::analysis::diagnosis_view::{EventPlot, Evidence};
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::{ParameterChoice, choose_preset};
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::Role;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::diagnose::report::fixture;
use crate::fit::ParameterChoices;
use crate::model::effects::{ActiveEffect, find};
use crate::model::preset::Preset;

#[test]
fn without_recordings_it_says_what_to_do() {
    let mut harness = harness(empty());
    assert!(says(&harness, "CSV files on the window"));
    press(&mut harness, "Diagnose");
    assert!(harness.state().commands.is_empty(), "it is disabled");
    press(&mut harness, "Try the example");
    assert_eq!(harness.state().commands, [Command::Example]);
}

#[test]
fn recordings_named_held_out_are_held_out_by_default() {
    let harness = harness(with(&["held-out-1.csv", "a.csv", "b.csv"]));
    assert!(says(&harness, "Recordings named \"held-out\" are held out"));
    let asked = Asked::of(&harness.state().setup, None);
    assert_eq!(asked.find("held-out-1.csv").unwrap().role, Role::HeldOut);
    assert_eq!(asked.find("b.csv").unwrap().role, Role::Train);
}

#[test]
fn options_are_chosen_by_name_and_reach_the_diagnosis() {
    let mut state = with(&["a.csv", "b.csv"]);
    let gravity = find("gravity").unwrap();
    state
        .setup
        .preset
        .model
        .effects
        .push(ActiveEffect::new(gravity));
    let mut harness = harness(state);
    let usual = options(&harness.state().setup, None).unwrap();
    assert!(usual.candidates.is_empty() && usual.budget.is_none());
    assert_eq!(usual.choices, ParameterChoices::default());
    // By name alone, as from a keyboard or a screen reader.
    let mut choose = |names: &[&str]| {
        for name in names {
            harness.get_by_label(name).click_accesskit();
            harness.run_steps(20);
        }
        options(&harness.state().setup, None)
    };
    let nothing = choose(&[
        "Options",
        "limit the time",
        "Effects compared: all",
        "compare no effect",
    ]);
    assert!(nothing.unwrap_err().contains("Tick one"));
    let asked = choose(&[
        "dry friction",
        "Parameters: as usual",
        "Cs: held",
        "f1: known",
        "gravity.g: free",
    ]);
    let asked = asked.unwrap();
    assert!(says(&harness, "Options (5 chosen)"));
    assert_eq!(asked.candidates, ["dry_friction"]);
    assert_eq!(asked.budget, Some(Duration::from_secs(60)));
    assert!(asked.choices.is_fixed("Cs"));
    assert_eq!(asked.choices.also_free, ["gravity.g"]);
    let known = &asked.choices.known[0];
    assert_eq!((known.id.as_str(), known.value), ("f1", 623.0));
    assert!((known.std_error - 6.23).abs() < 1e-9);
    // An answer to other options is out of date.
    let mut state = answered(fixture::drag());
    assert_eq!(state.diagnosing.differences(&state.setup), None);
    state.setup.diagnosis.longest = Some(5.0);
    let said = state.diagnosing.differences(&state.setup).unwrap();
    assert!(said.contains("options have changed"), "{said}");
}

#[test]
fn what_the_preset_knows_and_what_is_locked_reach_the_diagnosis() {
    let faller = Preset::embedded("faller").unwrap();
    let mut state = with(&["a.csv"]);
    choose_preset(&mut state.setup, &faller);
    let asked = options(&state.setup, None).unwrap();
    assert_eq!(asked.choices.known, faller.known);
    state.setup.locked.insert("gravity.g".to_owned());
    let asked = options(&state.setup, None).unwrap();
    assert!(asked.choices.known.is_empty() && asked.choices.is_fixed("gravity.g"));
    // A bad error is refused in words.
    let bad = ParameterChoice::Known {
        value: 9.81,
        std_error: 0.0,
    };
    let all = &mut state.setup.diagnosis.parameters;
    all.insert("gravity.g".to_owned(), bad);
    let said = options(&state.setup, None).unwrap_err();
    assert!(
        said.contains("gravity.g") && said.contains("above 0"),
        "{said}"
    );
}

#[test]
fn two_recordings_are_ready_at_once() {
    let mut harness = harness(with(&["a.csv", "b.csv"]));
    assert!(says(&harness, "The last quarter is held out"));
    press(&mut harness, "Diagnose");
    assert_eq!(harness.state().commands, [Command::Diagnose]);
    let asked = Asked::of(&harness.state().setup, None);
    assert!(!asked.split);
    assert_eq!(asked.find("b.csv").unwrap().role, Role::HeldOut);
    // A click changes it.
    harness.get_all_by_label("ignore").last().unwrap().click();
    harness.run_steps(4);
    let asked = Asked::of(&harness.state().setup, None);
    assert!(asked.split && asked.find("b.csv").is_none());
    assert!(says(&harness, "No recording is held out"));
    press(&mut harness, "Choose for me");
    assert!(!Asked::of(&harness.state().setup, None).split);
}

#[test]
fn recordings_of_the_same_name_get_numbers() {
    let state = with(&["a.csv", "a.csv", "a.csv"]);
    let names = Asked::of(&state.setup, None).recordings;
    let names: Vec<_> = names.iter().map(|u| u.recording.name.as_str()).collect();
    assert_eq!(names, ["a.csv", "a.csv (2)", "a.csv (3)"]);
}

#[test]
fn one_without_voltage_is_named() {
    let mut state = with(&["a.csv", "b.csv"]);
    let mut silent = state.setup.overlays[1].recording.as_ref().clone();
    silent.voltage = None;
    state.setup.overlays[1].recording = silent.into();
    // It is under the drive of the simulation, unless it has to supply that itself.
    assert_eq!(obstacle(&state.setup), None);
    state.setup.drive = DriveChoice::Recorded(state.setup.overlays[1].id);
    let text = obstacle(&state.setup).unwrap();
    assert!(text.starts_with("b.csv has no voltage"), "{text}");
    state.setup.overlays[1].role = Some(Role::Unused);
    assert_eq!(obstacle(&state.setup), None);
}

#[test]
fn an_answer_is_stated_in_a_sentence_and_opens_its_plots() {
    for size in [[1280.0, 690.0], [1920.0, 1050.0]] {
        let mut harness = harness_of(answered(fixture::drag()), size);
        assert!(says(&harness, "Left out: quadratic drag (99.9 %)"));
        assert!(says(&harness, "falls from 438 nm to 20.4 nm"));
        assert!(says(&harness, "noise 20 nm"));
        assert!(says(&harness, "Nothing left out"));
        assert!(says(&harness, "Unknown: not in the catalogue"));
        assert!(says(
            &harness,
            "cannot distinguish it from compressible film"
        ));
        // The named effect is opened with the plot that shows it best.
        assert_eq!(harness.state().diagnosing.look.evidence, Evidence::Force);
        assert!(says(&harness, "missing force [nN] against velocity"));
        press(&mut harness, "force balance");
        assert!(says(
            &harness,
            "missing force in flight [nN] against velocity"
        ));
        assert!(says(&harness, "A force over xp' is missing in flight"));
        assert!(says(&harness, "Drawn without its mean and its slope"));
        for tab in ["Over time", "Residual against", "Ground events"] {
            press(&mut harness, tab);
        }
        assert!(says(&harness, "restitution against speed of approach"));
        press(&mut harness, "pull-off force (18)");
        let look = &harness.state().diagnosing.look;
        assert_eq!(look.events, EventPlot::Adhesion);
        let strip = "residuals along square 300 8, held out";
        harness.get_by_label(strip).scroll_to_me();
        harness.run_steps(60);
        press(&mut harness, strip);
        let look = &harness.state().diagnosing.look;
        assert_eq!(look.evidence, Evidence::Zoom);
        assert_eq!(look.recording, Some(("square 300 8".to_owned(), true)));
        assert!(says(&harness, "rms residual"));
    }
}

#[test]
fn every_kind_of_answer_is_drawn_light_and_dark() {
    for diagnosis in [
        fixture::drag(),
        fixture::partly(),
        fixture::adequate(),
        fixture::unexplained(),
    ] {
        for dark in [true, false] {
            let mut state = answered(diagnosis.clone());
            state.view.dark = dark;
            let mut harness = harness(state);
            let ctx = harness.ctx.clone();
            crate::app::theme::apply(&ctx, dark);
            for tab in Evidence::ALL {
                harness.state_mut().diagnosing.look.evidence = tab;
                harness.state_mut().diagnosing.look.all_candidates = true;
                harness.run_steps(3);
            }
        }
    }
    let adequate = harness(answered(fixture::adequate()));
    assert!(says(&adequate, "Nothing is missing"));
    assert!(says(
        &adequate,
        "Effects too small for these recordings cannot be ruled out"
    ));
    let unexplained = harness(answered(fixture::unexplained()));
    assert!(says(&unexplained, "Something is missing that no effect"));
}

#[test]
fn a_part_is_an_answer_with_what_is_left_of_it() {
    let harness = harness_of(answered(fixture::partly()), [1920.0, 1600.0]);
    for part in [
        "Left out: quadratic drag (99.9 %), 82 % of the mismatch between contacts",
        "The rest is not explained.",
        "Unknown: not in the catalogue",
        "Quadratic drag leaves 18 % of the mismatch between contacts in single stretches",
        "depends on the displacement xp",
    ] {
        assert!(says(&harness, part), "{part}");
    }
}

#[test]
fn an_interval_of_mismatch_can_be_zoomed() {
    let d = fixture::drag();
    let worst = d.mismatch[0].clone();
    let mut harness = harness_of(answered(d), [1920.0, 1600.0]);
    let button = format!("1: {}", crate::diagnose::report::words::time_span(&worst));
    harness.get_by_label(&button).scroll_to_me();
    harness.run_steps(40);
    press(&mut harness, &button);
    let look = &harness.state().diagnosing.look;
    let (from, to) = look.window.unwrap();
    assert!(from < worst.start && worst.end < to);
    assert_eq!(look.recording.as_ref().unwrap().0, worst.recording);
    press(&mut harness, "Whole recording");
    assert_eq!(harness.state().diagnosing.look.window, None);
}

#[test]
fn effects_are_added_by_hand_and_compared() {
    let mut harness = harness(answered(fixture::drag()));
    press(&mut harness, "Test ticked effects");
    assert!(harness.state().commands.is_empty(), "nothing was changed");
    harness
        .get_by_role_and_label(Kind::CheckBox, "include dry friction")
        .click();
    harness.run_steps(4);
    assert!(says(&harness, "By hand: dry friction and quadratic drag"));
    press(&mut harness, "Test ticked effects");
    assert_eq!(harness.state().commands, [Command::DiagnoseByHand]);
    // With both results present they can be compared.
    let state = harness.state_mut();
    let picked: BTreeSet<String> = state.diagnosing.picked();
    let asked = Asked::of(&state.setup, Some(picked));
    state.diagnosing.adopt(fixture::unexplained(), asked);
    harness.run_steps(4);
    assert!(says(
        &harness,
        "search: held out 21.9 x noise to 1.02 x noise"
    ));
    assert!(says(
        &harness,
        "By hand, with dry friction and quadratic drag."
    ));
    assert!(
        says(&harness, "Candidates"),
        "with the numbers of the search"
    );
    press(&mut harness, "found by the search");
    assert!(says(&harness, "Left out: quadratic drag"));
}

#[test]
fn the_answer_is_used() {
    let mut harness = harness(answered(fixture::drag()));
    for (button, command) in [
        ("Apply to the device", Command::AcceptDiagnosis),
        ("Export report...", Command::ExportReport),
        ("Save as preset...", Command::SaveDiagnosed),
        ("Export JSON...", Command::ExportDiagnosis),
    ] {
        harness.state_mut().commands.clear();
        press(&mut harness, button);
        assert_eq!(harness.state().commands, [command]);
    }
    harness.state_mut().commands.clear();
    harness.get_by_label("Load this drive").scroll_to_me();
    harness.run_steps(60);
    press(&mut harness, "Load this drive");
    assert_eq!(
        harness.state().commands,
        [Command::Workspace(WorkspaceId::Tune)]
    );
    let DriveChoice::Waveform(drive) = &harness.state().setup.drive else {
        panic!("no waveform");
    };
    assert_eq!(drive.to_string(), "square:220Hz:8V");
}

#[test]
fn an_answer_is_applied_to_the_device_that_was_diagnosed() {
    let mut state = answered(fixture::drag());
    let oscillator = Preset::embedded("oscillator").unwrap();
    choose_preset(&mut state.setup, &oscillator);
    let why_not = state.diagnosing.why_not_applied(&state.setup);
    assert!(why_not.is_some_and(|text| text.contains("not the one that was diagnosed")));
    let mut harness = harness(state);
    press(&mut harness, "Apply to the device");
    assert!(harness.state().commands.is_empty(), "it is disabled");
}

#[test]
fn an_answer_for_other_recordings_is_marked_as_old() {
    let mut state = answered(fixture::drag());
    assert!(!state.diagnosing.is_stale(&state.setup));
    state.setup.overlays.pop();
    let harness = harness(state);
    assert!(says(&harness, "have changed since"));
}

#[test]
fn an_answer_without_its_recordings_shows_its_residuals() {
    let mut state = answered(fixture::drag());
    // As after a session was opened whose files are gone.
    state.setup.overlays.clear();
    let answer = state.diagnosing.automatic.as_mut().unwrap();
    let answer = Arc::make_mut(answer);
    answer.asked.recordings.clear();
    answer.is_thinned = true;
    let mut harness = harness(state);
    press(&mut harness, "Over time");
    assert!(says(&harness, "only its residual is shown"));
    assert!(says(&harness, "not every sample"));
    assert!(says(&harness, "have changed since: diagnose again"));
}

#[test]
fn an_error_is_shown_in_place_of_the_answer() {
    let mut state = with(&["a.csv"]);
    state.diagnosing.error = Some("a.csv has no contact".to_owned());
    let harness = harness(state);
    assert!(says(&harness, "The diagnosis failed: a.csv has no contact"));
}

#[test]
fn the_layout_is_stable_over_time() {
    let mut harness = harness(answered(fixture::drag()));
    for tab in [
        "Over time",
        "Missing force",
        "Residual against",
        "Ground events",
    ] {
        press(&mut harness, tab);
        let before = harness.get_by_label(tab).rect();
        harness.run_steps(30);
        assert_eq!(harness.get_by_label(tab).rect(), before, "{tab}");
    }
}
