//! The sealed trial: the truth must not be visible before the envelope is opened.

use std::sync::Arc;

use eframe::egui::Context;
use eframe::egui::accesskit::Role as Kind;
use egui_kittest::kittest::{NodeT, Queryable};

use super::support::with;
use super::{harness_of, press, says};
use crate::app::analysis::diagnosis_answer::{Answer, Asked};
use crate::app::analysis::sealed_trial::{Guess, Tally};
use crate::app::flows::sealed_trial::own_setup;
use crate::app::state::State;
use crate::diagnose::Verdict;
use crate::diagnose::report::fixture;
use crate::trial::{Case, Class, Mix, Settings};

/// A state with a running trial, prepared by the background thread.
fn on_trial() -> State {
    let mut state = with(&["mine.csv"]);
    state.diagnosing.trial.open = true;
    state.diagnosing.trial.seed = "11".to_owned();
    let context = Context::default();
    state.diagnosing.trial.conceal(&context);
    let mut last = 1;
    for _ in 0..12_000 {
        crate::app::actions::diagnosis::poll(&mut state, &mut last);
        if state.diagnosing.trial.sealed.is_some() {
            return state;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("no trial was made: {:?}", state.diagnosing.trial.error);
}

#[test]
fn the_truth_is_hidden_until_the_envelope_is_open() {
    let state = on_trial();
    // The same trial is drawn here, to know what must stay hidden.
    let settings = Settings {
        mix: Mix::Only(Class::One),
        ..Settings::default()
    };
    let case = Case::draw(11, &settings).unwrap();
    let secret = case.truth().effects[0].formulation.clone();
    let seal = case.seal().to_owned();
    let sealed = state.diagnosing.trial.sealed.as_ref().unwrap();
    assert_eq!(sealed.seal, seal, "it is the same trial");
    // The person's own recordings are set aside; a session saves those.
    assert!(state.setup.overlays.len() > 2);
    assert!(
        state
            .setup
            .overlays
            .iter()
            .all(|o| o.recording.name != "mine.csv")
    );
    assert_eq!(own_setup(&state).overlays.len(), 1);
    // The diagnosis gets the recordings and nothing else.
    let asked = Asked::of(&state.setup, None);
    assert!(!asked.split && format!("{asked:?}").len() > 10);
    assert!(state.setup.preset.model.effects.is_empty());

    ends_without_its_recordings(state.clone());

    let mut harness = harness_of(state, [1440.0, 1300.0]);
    assert!(says(&harness, &seal[..32]));
    press(&mut harness, "Open the envelope");
    assert!(
        !says(&harness, "smallest visible"),
        "not before the diagnosis"
    );
    harness
        .get_by_role_and_label(Kind::CheckBox, "quadratic drag")
        .click();
    harness.run_steps(4);
    let sealed = harness.state().diagnosing.trial.sealed.as_ref().unwrap();
    assert!(matches!(&sealed.guess, Some(Guess::Effects(ids)) if ids.contains("quadratic_drag")));
    for partly in [true, false] {
        press(&mut harness, "not in the list");
        let sealed = harness.state().diagnosing.trial.sealed.as_ref().unwrap();
        let guess = sealed.guess.as_ref().unwrap();
        assert_eq!(guess.is_unknown_in_part(), partly);
        assert!(guess.effects().contains("quadratic_drag"));
    }
    let asked = Asked::of(&harness.state().setup, None);
    harness
        .state_mut()
        .diagnosing
        .adopt(fixture::adequate(), asked);
    harness.run_steps(4);
    let shown = |harness: &egui_kittest::Harness<'_, State>| {
        let all = harness.root().children_recursive().collect::<Vec<_>>();
        let text = |n: &egui_kittest::Node<'_>| {
            let node = n.accesskit_node();
            [node.label(), node.value()]
                .into_iter()
                .flatten()
                .collect::<Vec<_>>()
        };
        all.iter().flat_map(text).collect::<Vec<_>>().join("\n")
    };
    let before = shown(&harness);
    assert!(!before.contains(&secret), "{secret}");
    assert!(!before.contains("smallest visible"));
    press(&mut harness, "Open the envelope");
    let after = shown(&harness);
    assert!(after.contains(&secret) && after.contains("smallest visible"));
    assert!(says(&harness, "The seal holds"));
    assert!(says(&harness, "The diagnosis: abstained"));
    let tally = harness.state().diagnosing.trial.tally;
    assert_eq!((tally.tool, tally.person.1), ((0, 1), 1));
    // The person's own recordings come back.
    press(&mut harness, "Close the trial");
    let state = harness.state();
    assert_eq!(state.setup.overlays[0].recording.name, "mine.csv");
    assert!(state.diagnosing.automatic.is_none());
    assert_eq!(state.diagnosing.trial.tally, tally);
    assert_ne!(tally, Tally::default());
}

/// Checks that a trial ends with its recordings, and that the person's own answer comes back.
fn ends_without_its_recordings(mut state: State) {
    let asked = Asked::of(own_setup(&state), None);
    let sealed = state.diagnosing.trial.sealed.as_mut().unwrap();
    sealed.own.automatic = Some(Arc::new(Answer::new(fixture::drag(), asked)));
    let asked = Asked::of(&state.setup, None);
    state.diagnosing.adopt(fixture::adequate(), asked);
    // Undo brings the own setup back; recordings can also be removed one by one.
    let mut undone = state.clone();
    undone.setup = own_setup(&state).clone();
    let mut removed = state.clone();
    removed.setup.overlays.clear();
    for mut ended in [undone, removed] {
        crate::app::actions::diagnosis::poll(&mut ended, &mut 100);
        assert!(ended.diagnosing.trial.sealed.is_none());
        assert_eq!(ended.setup.overlays[0].recording.name, "mine.csv");
        let shown = ended.diagnosing.shown().unwrap();
        assert_eq!(shown.diagnosis.verdict, Verdict::MissingPhysics);
    }
}

#[test]
fn a_seed_that_is_no_number_is_refused() {
    let mut state = with(&[]);
    state.diagnosing.trial.seed = "seven".to_owned();
    state.diagnosing.trial.conceal(&Context::default());
    assert!(state.diagnosing.trial.making.is_none());
    assert!(
        state
            .diagnosing
            .trial
            .error
            .unwrap()
            .contains("whole number")
    );
}
