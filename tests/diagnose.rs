//! The diagnosis on sealed recordings: made by the trial's own model and solver, with a rig
//! that is slightly off, and an effect of which the diagnosis knows nothing.

use std::sync::atomic::AtomicBool;

use impactscope::diagnose::trial::{Case, Class, Mix, Settings};
use impactscope::diagnose::{
    DiagnoseControl, DiagnoseError, DiagnoseOptions, Diagnosis, Verdict, diagnose,
};
use impactscope::fit::Part;
use impactscope::model::preset::Preset;

/// Diagnoses a few recordings of a trial, for the sake of time.
fn ask(seed: u64, mix: Mix, cancelled: bool) -> Result<Diagnosis, DiagnoseError> {
    let settings = Settings {
        rate: 25e3,
        mix,
        ..Settings::default()
    };
    // The first from this seed on in which what is concealed can be seen.
    let sized = |seed| {
        let case = Case::draw(seed, &settings).expect("a trial");
        let sizes = case
            .truth()
            .effects
            .iter()
            .map(|e| e.times_smallest_visible);
        (sizes.fold(f64::INFINITY, f64::min) > 10.0).then_some(case)
    };
    let case = (seed..seed + 20).find_map(sized).expect("a visible one");
    let parts = |all: &[std::sync::Arc<impactscope::recording::Recording>], which: &[usize]| {
        let pick = |&i: &usize| Part::whole(all[i].clone());
        which.iter().map(pick).collect::<Vec<Part>>()
    };
    let recordings = case.recordings();
    let train = parts(&recordings.train, &[1, 2, 3]);
    let held_out = parts(&recordings.held_out, &[2]);
    let model = Preset::embedded("paper").expect("a preset").model;
    let cancel = AtomicBool::new(cancelled);
    let quiet = |_: &impactscope::diagnose::DiagnoseProgress| {};
    let control = DiagnoseControl {
        cancel: &cancel,
        progress: &quiet,
    };
    let options = DiagnoseOptions::default();
    diagnose(&model, &train, &held_out, &options, &control)
}

#[test]
fn a_concealed_drag_is_named_and_proved() {
    let found = ask(31, Mix::Effect("quadratic_drag".to_owned()), false).unwrap();
    assert_eq!(found.verdict, Verdict::MissingPhysics, "{:?}", found.named);
    let names: Vec<&str> = found.named.iter().map(|n| n.id.as_str()).collect();
    assert_eq!(names, ["quadratic_drag"]);
    let held = &found.held_out;
    assert!(held.after.rms < held.before.rms, "{held:?}");
    assert!(held.after.rms < 1.3 * found.noise, "{held:?}");
}

#[test]
fn where_nothing_was_left_out_nothing_is_named() {
    let found = ask(32, Mix::Only(Class::Nothing), false).unwrap();
    assert_eq!(found.verdict, Verdict::Adequate, "{:?}", found.remarks);
    assert!(found.named.is_empty());
}

#[test]
fn cancelled_it_still_answers_and_names_nothing() {
    let found = ask(31, Mix::Effect("quadratic_drag".to_owned()), true).unwrap();
    assert!(found.cancelled);
    assert!(found.named.is_empty());
}

#[test]
fn senseless_questions_are_refused() {
    let model = Preset::embedded("paper").unwrap().model;
    let cancel = AtomicBool::new(false);
    let quiet = |_: &impactscope::diagnose::DiagnoseProgress| {};
    let control = DiagnoseControl {
        cancel: &cancel,
        progress: &quiet,
    };
    let options = DiagnoseOptions::default();
    let none = diagnose(&model, &[], &[], &options, &control);
    assert!(matches!(none, Err(DiagnoseError::NoRecording)));
    let options = DiagnoseOptions {
        candidates: vec!["nonsense".to_owned()],
        ..options
    };
    let unknown = diagnose(&model, &[], &[], &options, &control);
    let text = unknown.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(
        text.contains("nonsense") && text.contains("quadratic_drag"),
        "{text}"
    );
}
