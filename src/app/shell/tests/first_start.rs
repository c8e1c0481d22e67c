//! What a new user does: the hint of the first start followed to its end, and the guided
//! identification from its beginning to its end.

use std::time::Duration;

use eframe::egui::Key;
use eframe::egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::super::window::Shell;
use super::{harness, preset, wait};
use crate::app::analysis::identification::Course;
use crate::app::files::built_in;
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::model::parameter::ParameterId;

/// What the recordings of the first start were made with: see their first lines.
const TRUTH: [(ParameterId, f64); 4] = [
    (ParameterId::Cs, 2.4e-21),
    (ParameterId::Alpha, 0.3),
    (ParameterId::Ca0, 36e-9),
    (ParameterId::Ca, 1.2e-6),
];
/// Largest misfit of whole runs that is called the noise.
const AT_THE_NOISE: f64 = 1.05;

/// The window at its first start.
fn first_start() -> Harness<'static, Shell> {
    let mut harness = harness(preset("paper"));
    harness.state_mut().services.state.ask(Command::ResetAll);
    harness.run_steps(3);
    harness
}

fn state<'a>(harness: &'a Harness<'_, Shell>) -> &'a State {
    &harness.state().services.state
}

fn says(harness: &Harness<'_, Shell>, part: &str) -> bool {
    harness.query_all_by_label_contains(part).next().is_some()
}

/// Draws until the state is as wanted, at most some minutes.
fn until(harness: &mut Harness<'_, Shell>, what: &str, done: impl Fn(&State) -> bool) {
    for _ in 0..15_000 {
        if done(state(harness)) {
            return harness.run_steps(3);
        }
        std::thread::sleep(Duration::from_millis(20));
        harness.run_steps(1);
    }
    panic!("{what} never came");
}

/// Presses the lowest button of that name: tabs are above what they show.
fn press(harness: &mut Harness<'_, Shell>, label: &str) {
    let all = harness.get_all_by_role_and_label(Role::Button, label);
    let lowest = all.max_by(|a, b| a.rect().top().total_cmp(&b.rect().top()));
    lowest
        .unwrap_or_else(|| panic!("no button {label}"))
        .click();
    harness.run_steps(3);
}

fn is_near_the_truth(state: &State, share: f64) {
    for (id, truth) in TRUTH {
        let value = state.setup.preset.model.parameters[id];
        assert!(
            (value / truth - 1.0).abs() < share,
            "{}: {value:e} of {truth:e}",
            id.spec().id
        );
    }
}

#[test]
fn the_first_hint_can_be_followed_to_its_end() {
    let mut harness = first_start();
    let [first, ..] = built_in::first_start_hint();
    assert!(says(&harness, &first), "the hint is shown");
    // Each parameter that it names has a slider; moved to the truth they leave the noise.
    wait(&mut harness, |shown| {
        shown.total_misfit().is_some_and(|m| m > 5.0)
    });
    for (id, truth) in TRUTH {
        assert!(first.contains(id.spec().id), "{first}");
        let parameters = &mut harness
            .state_mut()
            .services
            .state
            .setup
            .preset
            .model
            .parameters;
        parameters.set(id, truth);
        harness.run_steps(2);
    }
    wait(&mut harness, |shown| {
        shown.total_misfit().is_some_and(|m| m < AT_THE_NOISE)
    });
    // The other way: F, Fit, Apply.
    harness.state_mut().services.state.ask(Command::ResetAll);
    harness.run_steps(3);
    wait(&mut harness, |shown| {
        shown.total_misfit().is_some_and(|m| m > 5.0)
    });
    harness.key_press(Key::F);
    harness.run_steps(3);
    assert!(state(&harness).fitting.open && first.contains("press F"));
    press(&mut harness, "Fit");
    until(&mut harness, "the result", |state| {
        state.fitting.result.is_some()
    });
    let result = state(&harness).fitting.result.clone().expect("it is there");
    for p in &result.parameters {
        assert!(p.std_error.is_finite(), "{} is not determined", p.id);
    }
    for (id, truth) in TRUTH {
        let found = result.parameters.iter().find(|p| p.id == id.spec().id);
        let found = found.expect("it is free");
        let off = (found.value - truth).abs() / found.std_error;
        assert!(off < 4.0, "{}: {off:.1} standard errors off", found.id);
    }
    let all = &result.train.0;
    assert!(all.rms < AT_THE_NOISE * all.noise, "{all:?}");
    press(&mut harness, "Apply");
    wait(&mut harness, |shown| {
        shown.total_misfit().is_some_and(|m| m < AT_THE_NOISE)
    });
}

#[test]
fn the_guided_identification_comes_to_its_end_on_the_recordings_of_the_first_start() {
    let mut harness = first_start();
    harness.key_press(Key::I);
    harness.run_steps(3);
    until(&mut harness, "the guide", |state| {
        state.identification.has_looked() && state.identification.job.is_none()
    });
    // Releases cannot be read with the preset's values: it says what is freed, and does so.
    assert!(says(&harness, "Freed: "));
    press(&mut harness, "Fit the whole device");
    until(&mut harness, "the fit and the second look", |state| {
        let guide = &state.identification;
        guide.course == Course::ByHand && guide.whole.is_some() && guide.has_looked()
    });
    until(&mut harness, "the end of the look", |state| {
        state.identification.job.is_none()
    });
    assert!(!says(&harness, "Freed: "), "nothing more has to be freed");
    press(&mut harness, "Take all steps");
    until(&mut harness, "the end", |state| {
        state.identification.is_at_its_end()
    });
    assert!(says(&harness, "The identification is at its end"));
    for value in ["alpha = ", "Ca = ", "Ca0 = ", "Cs = ", "gp = "] {
        assert!(says(&harness, value), "{value}");
    }
    // What could not be told, and the recording that would tell it.
    assert!(says(&harness, "Not identified, drive"));
    assert!(says(&harness, "Record whole slow cycles"));
    is_near_the_truth(state(&harness), 0.05);
    wait(&mut harness, |shown| {
        shown.total_misfit().is_some_and(|m| m < AT_THE_NOISE)
    });
}
