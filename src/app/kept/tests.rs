//! Results through a session's text and back.

use std::sync::Arc;

use proptest::prelude::*;

use super::content::{Content, bytes, value};
use super::*;
use crate::app::actions::diagnosis::poll;
use crate::app::analysis::diagnosis_answer::Asked;
use crate::app::analysis::fit;
use crate::app::analysis::sealed_trial::{Draw, Guess, Level};
use crate::app::files::{built_in, session, session_text};
use crate::app::flows::sealed_trial::{begin, end, open};
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::{OverlayId, Role};
use crate::app::setup::view::View;
use crate::app::state::State;
use crate::diagnose::Diagnosis;
use crate::diagnose::findings::{Finding, FindingKind, Remark};
use crate::diagnose::report::fixture;
use crate::fit::uncertainty::identifiability::tests::made_up;
use crate::fit::{FitOptions, ProfilePoint};
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::trial::{Case, Class, Mix, Settings};

/// A state with nine recordings by the names of the fixtures' diagnoses.
fn state() -> State {
    let mut setup = built_in::from_preset(Preset::default());
    for (id, proof) in (1..).zip(&fixture::drag().proof) {
        let time: Vec<f64> = (0..200).map(|i| 2e-5 * f64::from(i)).collect();
        let data = Recording::new(&proof.recording, time.clone(), None, time, None);
        let mut overlay = built_in::unread(id, Arc::new(data.unwrap()));
        overlay.made_up = false;
        let held_out = proof.held_out;
        overlay.role = Some(if held_out { Role::HeldOut } else { Role::Train });
        setup.overlays.push(overlay);
    }
    State::new(setup, View::default())
}

/// Another window's state with the same setup, and what it was told.
fn reopened(state: &State) -> (State, Option<String>) {
    let setup = crate::app::flows::sealed_trial::own_setup(state).clone();
    restored(setup, &Kept::of(state).text(&Memo::default()))
}

fn restored(setup: Setup, text: &str) -> (State, Option<String>) {
    let mut new = State::new(setup, View::default());
    let lost = restore(&mut new, text);
    (new, lost)
}

/// A state with a fit, its profile, a diagnosis and a view of it.
fn with_results() -> State {
    let mut state = state();
    let options = FitOptions::for_model(&state.setup.preset.model);
    let asked = Arc::new(fit::Asked::of(&state.setup, options, None));
    let result = Arc::new(made_up());
    state.fitting.adopt(fit::Finished { result, asked });
    state.fitting.open = true;
    let point = |value, rise| ProfilePoint { value, rise };
    let points = vec![point(1e-21, f64::NAN), point(2e-21, f64::INFINITY)];
    state.fitting.profile.result = Some(("Cs".to_owned(), Ok(points)));
    let asked = Asked::of(&state.setup, None);
    state.diagnosing.adopt(fixture::drag(), asked);
    state.diagnosing.pick("gravity", true);
    state.diagnosing.look.window = Some((0.01, 0.02));
    // The results are those of this device.
    state.identification.collect(&state.setup);
    let failed = Err("no slow cycle".to_owned());
    state
        .identification
        .findings
        .insert(Step::Drive.id(), failed);
    state.identification.chosen = Some(Step::Film);
    state
}

fn assert_same<T: serde::Serialize + serde::de::DeserializeOwned + std::fmt::Debug>(whole: &T) {
    let written = bytes(whole).unwrap();
    let read: T = value(&written).unwrap();
    // The bytes hold all bits of each number; the text says which differ.
    assert_eq!(format!("{read:?}"), format!("{whole:?}"));
    assert_eq!(bytes(&read).unwrap(), written);
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(-0.0),
        Just(5e-324),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn numbers_come_back_to_the_last_bit(numbers in prop::collection::vec(any_number(), 9)) {
        let written = bytes(&numbers).unwrap();
        let read: Vec<f64> = value(&written).unwrap();
        let bits = |all: &[f64]| all.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&read), bits(&numbers));
    }

    #[test]
    fn a_fit_comes_back_whole(numbers in prop::collection::vec(any_number(), 9)) {
        let mut result = made_up();
        for (parameter, pair) in result.parameters.iter_mut().zip(numbers.chunks(3)) {
            (parameter.value, parameter.std_error, parameter.start) = (pair[0], pair[1], pair[2]);
        }
        result.fisher_values.clone_from_slice(&numbers[..3]);
        result.correlations.copy_from_slice(&numbers);
        result.remarks.push("Ca is not determined".to_owned());
        (result.train.0.rms, result.train.0.chi2) = (numbers[3], numbers[4]);
        result.held_out = Some((result.train.0.clone(), vec![result.train.0.clone()]));
        result.cancelled = numbers[5] > 0.0;
        assert_same(&result);
    }

    #[test]
    fn a_diagnosis_comes_back_whole(
        numbers in prop::collection::vec(any_number(), 6),
        which in 0..4_usize,
    ) {
        let all = [fixture::drag, fixture::adequate, fixture::partly, fixture::unexplained];
        let mut d = all[which]();
        d.noise = numbers[0];
        d.train.after.chi2 = numbers[1];
        for strip in &mut d.strips {
            strip.before[0] = numbers[2];
            strip.samples_before = numbers.iter().map(|x| [*x, numbers[3]]).collect();
        }
        d.findings.push(Finding {
            kind: FindingKind::TooSmallShare { effects: vec!["gravity"], of_segments: numbers[4] },
            statistic: numbers[5],
        });
        d.remarks.push(Remark::FewSamples(7));
        assert_same(&d);
    }

    /// Whatever stands in a part, nothing panics.
    #[test]
    fn bytes_of_chance_are_refused(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        at in any::<prop::sample::Index>(),
    ) {
        let mut whole = bytes_of_a_fit();
        let from = at.index(whole.len());
        whole.splice(from..(from + bytes.len() / 8).min(whole.len()), bytes.clone());
        for content in [bytes, whole] {
            let all: Vec<String> =
                Part::all().map(|part| lines::line(part.id(), &content)).collect();
            restored(built_in::setup(), &lines::joined(&all));
        }
    }
}

fn bytes_of_a_fit() -> Vec<u8> {
    Content::Fit(with_results().fitting.finished().unwrap())
        .bytes()
        .unwrap()
}

#[test]
fn a_reopened_session_shows_the_same_results() {
    let before = with_results();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let text = Kept::of(&before).text(&Memo::default());
    session::save_with_results(&path, &before.setup, &before.view, &[], &text).unwrap();
    let loaded = session::load(&path).unwrap();
    let (mut after, lost) = restored(before.setup.clone(), &loaded.results);
    assert_eq!(lost, None);
    let fit = |state: &State| format!("{:?}", state.fitting.result);
    assert_eq!(fit(&after), fit(&before));
    assert!(after.fitting.open);
    let profile = |state: &State| format!("{:?}", state.fitting.profile.result);
    assert_eq!(profile(&after), profile(&before));
    assert_eq!(after.fitting.differences(&after.setup), None);
    // Its recordings are open: a profile can be computed.
    assert_eq!(after.fitting.profile_obstacle(&after.setup), None);
    let answer = |state: &State| format!("{:?}", state.diagnosing.shown().unwrap().diagnosis);
    assert_eq!(answer(&after), answer(&before));
    let asked = |state: &State| {
        let asked = &state.diagnosing.shown().unwrap().asked;
        let used = asked.recordings.iter();
        used.map(|u| (u.id, u.recording.name.clone(), u.role))
            .collect::<Vec<_>>()
    };
    assert_eq!(asked(&after), asked(&before));
    assert_eq!(after.diagnosing.picked(), before.diagnosing.picked());
    assert_eq!(after.diagnosing.look.window, Some((0.01, 0.02)));
    assert!(!after.diagnosing.is_stale(&after.setup));
    after.identification.collect(&after.setup);
    assert_eq!(after.identification.chosen, Some(Step::Film));
    let drive = &after.identification.findings[Step::Drive.id()];
    assert_eq!(drive.as_ref().unwrap_err(), "no slow cycle");
    // And once more.
    assert_eq!(Kept::of(&after).text(&Memo::default()), text);
}

#[test]
fn a_result_of_recordings_that_are_gone_says_so_and_is_shown() {
    let before = with_results();
    let mut setup = before.setup.clone();
    let gone = setup.overlays.remove(0);
    let text = Kept::of(&before).text(&Memo::default());
    let (mut after, lost) = restored(setup, &text);
    assert_eq!(lost, None);
    let name = &gone.recording.name;
    for said in [
        after.fitting.differences(&after.setup),
        after.diagnosing.differences(&after.setup),
    ] {
        let said = said.unwrap();
        assert!(said.contains(&format!("{name} is not open")), "{said}");
    }
    assert!(after.fitting.profile_obstacle(&after.setup).is_some());
    assert!(after.diagnosing.shown().unwrap().asked.find(name).is_none());
    // It is read later.
    after.setup.overlays.push(gone.clone());
    after.diagnosing.complete(&after.setup);
    assert!(after.diagnosing.shown().unwrap().asked.find(name).is_some());
    assert!(!after.diagnosing.is_stale(&after.setup));
}

#[test]
fn a_session_without_results_opens_as_before() {
    let (state, lost) = restored(built_in::setup(), "");
    assert_eq!(lost, None);
    assert!(state.fitting.result.is_none() && state.diagnosing.shown().is_none());
}

#[test]
fn a_damaged_result_costs_neither_the_setup_nor_the_others() {
    let before = with_results();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let text = Kept::of(&before).text(&Memo::default());
    session::save_with_results(&path, &before.setup, &before.view, &[], &text).unwrap();
    let mut file = std::fs::read(&path).unwrap();
    // A byte that is no text, in the middle of the diagnosis.
    let mark = b"\n#@ diagnosis ";
    let start = file.windows(mark.len()).position(|w| w == mark).unwrap();
    file[start + 1000] = 0xff;
    std::fs::write(&path, file).unwrap();
    let loaded = session::load(&path).unwrap();
    assert_eq!(loaded.setup.preset, before.setup.preset);
    let (after, lost) = restored(before.setup.clone(), &loaded.results);
    let lost = lost.unwrap();
    assert!(
        lost.contains("the diagnosis cannot be read: the file is damaged"),
        "{lost}"
    );
    assert!(after.diagnosing.shown().is_none() && after.fitting.result.is_some());
    // Cut off in the results.
    let whole = session::text(&path, &before.setup, &before.view, &[]).unwrap() + "\n" + &text;
    let cut = &whole[..whole.len() - text.len() / 2];
    let loaded = session::parse(&path, cut).unwrap();
    let (_, lost) = restored(before.setup.clone(), &loaded.results);
    assert!(lost.unwrap().contains("damaged"));
}

#[test]
fn a_result_of_another_version_is_dropped_with_a_word() {
    let before = with_results();
    let text = Kept::of(&before).text(&Memo::default());
    let written: Vec<String> = text
        .lines()
        .skip(1)
        .map(|line| match line.starts_with("#@ fit ") {
            true => lines::line("fit", &bytes(&("another", 1)).unwrap()),
            false => line.to_owned(),
        })
        .collect();
    let (after, lost) = restored(before.setup.clone(), &lines::joined(&written));
    let lost = lost.unwrap();
    assert!(
        lost.contains("the fit cannot be read: another version"),
        "{lost}"
    );
    assert!(after.fitting.result.is_none() && after.diagnosing.shown().is_some());
}

#[test]
fn large_results_are_written_once() {
    let mut state = with_results();
    let memo = Memo::default();
    let addresses = |memo: &Memo| {
        let known = memo.0.lock().unwrap();
        known
            .iter()
            .map(|(_, data)| data.as_ptr())
            .collect::<Vec<_>>()
    };
    let first = Kept::of(&state);
    let text = first.text(&memo);
    let before = addresses(&memo);
    assert_eq!(before.len(), 2, "a fit and an answer");
    // A slider is dragged, and a view changes.
    state.setup.duration = 0.7;
    assert_eq!(Kept::of(&state), first);
    state.diagnosing.look.window = None;
    let second = Kept::of(&state);
    assert_ne!(second, first);
    assert_ne!(second.text(&memo), text);
    assert_eq!(addresses(&memo), before);
    state.fitting.discard();
    assert_ne!(Kept::of(&state), second);
}

/// A diagnosis with `count` residuals as noise gives them.
fn long(count: usize) -> Diagnosis {
    let mut d = fixture::drag();
    let strips = d.strips.len();
    for (k, strip) in d.strips.iter_mut().enumerate() {
        let noise = |seed: f64| -> Vec<[f64; 2]> {
            let value = |i: usize| 3e-8 * ((i as f64 + seed) * 12.9898).sin() * 1.3;
            let points = (0..count / strips / 2).map(|i| [4e-5 * i as f64, value(i)]);
            points.collect()
        };
        strip.samples_before = noise(k as f64);
        strip.samples_after = noise(0.5 + k as f64);
    }
    d
}

#[test]
fn a_long_diagnosis_stays_small() {
    let size = |count: usize| {
        let mut state = state();
        let asked = Asked::of(&state.setup, None);
        state.diagnosing.adopt(long(count), asked);
        let (after, lost) = reopened(&state);
        assert_eq!(lost, None);
        let is_thinned = after.diagnosing.shown().unwrap().is_thinned;
        (Kept::of(&state).text(&Memo::default()).len(), is_thinned)
    };
    // The example has so many.
    let (bytes, is_thinned) = size(80_000);
    assert!(bytes < 1_200_000 && !is_thinned, "{bytes}");
    let (bytes, is_thinned) = size(2_000_000);
    assert!(bytes < 2_600_000 && is_thinned, "{bytes}");
}

/// A state with a trial of seed 11, and what it conceals.
fn on_trial(last: &mut OverlayId) -> (State, Case) {
    let draw = Draw {
        seed: 11,
        level: Level::One,
        beam: false,
        noise: Settings::default().noise,
    };
    let settings = Settings {
        mix: Mix::Only(Class::One),
        ..Settings::default()
    };
    let case = Case::draw(draw.seed, &settings).unwrap();
    let (recordings, envelope) = case.clone().into_parts();
    let mut state = with_results();
    begin(&mut state, (recordings, envelope, draw), last);
    (state, case)
}

/// Draws the trial of a reopened session again.
fn resumed(state: &mut State, last: &mut OverlayId) {
    let context = eframe::egui::Context::default();
    for _ in 0..12_000 {
        state.diagnosing.trial.resume(&context);
        poll(state, last);
        if !state.diagnosing.trial.has_begun() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("it is not drawn again");
}

#[test]
fn a_sealed_trial_goes_on_and_stays_sealed() {
    let (mut state, case) = on_trial(&mut 100);
    let secret = case.truth().effects[0].clone();
    let sealed = state.diagnosing.trial.sealed.as_mut().unwrap();
    sealed.guess = Some(Guess::Nothing);
    state.setup.duration = 0.123;
    state.setup.overlays[1].role = Some(Role::Unused);
    let asked = Asked::of(&state.setup, None);
    state.diagnosing.adopt(fixture::adequate(), asked);
    // Nothing of the truth is in the file, packed or not.
    let text = Kept::of(&state).text(&Memo::default());
    let (read, _) = lines::read(&text);
    let contents = read.iter().map(|line| line.bytes.as_deref().unwrap());
    for part in contents.chain([text.as_bytes()]) {
        let part = String::from_utf8_lossy(part);
        assert!(!part.contains(&secret.formulation));
        assert!(!part.contains("times_smallest_visible"));
    }
    let (after, lost) = reopened(&state);
    assert_eq!(lost, None);
    // The person's own setup and answer are there at once.
    assert!(!after.diagnosing.trial.open && after.diagnosing.trial.sealed.is_none());
    assert!(after.diagnosing.shown().unwrap().diagnosis.named.len() == 1);
    // Saved again before it is drawn: nothing is lost.
    let (mut after, _) = reopened(&after);
    resumed(&mut after, &mut 200);
    let sealed = after.diagnosing.trial.sealed.as_ref().unwrap();
    assert_eq!(sealed.guess, Some(Guess::Nothing));
    assert!(sealed.opened.is_none());
    assert_eq!(after.setup.duration, 0.123);
    assert_eq!(after.setup.overlays[1].role, Some(Role::Unused));
    let data = |state: &State| state.setup.overlays[0].recording.proof_mass.clone();
    assert_eq!(data(&after), data(&state));
    let shown = after.diagnosing.shown().unwrap();
    assert!(shown.diagnosis.named.is_empty() && !shown.asked.recordings.is_empty());
    // Its envelope is opened, and the score is there after another reopening.
    open(&mut after);
    let marks = |state: &State| {
        let opened = state
            .diagnosing
            .trial
            .sealed
            .as_ref()
            .unwrap()
            .opened
            .clone();
        opened.map(|o| (o.tool, o.person, o.seal_holds, o.truth.effects))
    };
    let scored = marks(&after);
    assert_eq!(scored.as_ref().unwrap().3, case.truth().effects);
    let (mut again, _) = reopened(&after);
    resumed(&mut again, &mut 300);
    assert_eq!(marks(&again), scored);
    assert_eq!(again.diagnosing.trial.tally, after.diagnosing.trial.tally);
    // The own setup and answer come back at its end.
    end(&mut again);
    assert_eq!(again.setup.overlays.len(), 9);
    assert_eq!(again.diagnosing.shown().unwrap().diagnosis.named.len(), 1);
}

#[test]
fn a_trial_that_this_version_draws_in_another_way_ends_with_a_word() {
    let (state, _) = on_trial(&mut 100);
    let (mut after, _) = reopened(&state);
    let suspended = after.diagnosing.trial.suspended.as_mut().unwrap();
    suspended.seal = "0".repeat(64);
    resumed(&mut after, &mut 200);
    assert!(after.diagnosing.trial.sealed.is_none());
    assert!(
        after
            .notices
            .iter()
            .any(|n| n.text.contains("seed 11 cannot go on"))
    );
    assert_eq!(after.setup.overlays.len(), 9);
}

#[test]
fn the_fit_before_a_running_one_is_saved() {
    let mut state = with_results();
    let before = format!("{:?}", state.fitting.result);
    let context = eframe::egui::Context::default();
    state.fitting.start(&state.setup, &context);
    if let Some(job) = &state.fitting.job {
        job.cancel();
    }
    let (after, _) = reopened(&state);
    assert_eq!(format!("{:?}", after.fitting.result), before);
}

/// The text of a session with results is one that older readers of the setup understand.
#[test]
fn results_are_comments() {
    let state = with_results();
    let text = Kept::of(&state).text(&Memo::default());
    assert!(text.lines().all(|line| line.starts_with('#')));
    let setup = session_text::to_text(&state.setup, &state.view, &[], std::path::Path::new("/a"));
    let whole = setup.unwrap() + "\n" + &text;
    assert!(toml::from_str::<toml::Table>(&whole).is_ok());
}
