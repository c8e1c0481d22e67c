//! The autosave without a window: its times, the files of several windows, and what is left
//! when the process is killed.

mod kill;

use std::time::SystemTime;

use crate::app::analysis::diagnosis_answer::Asked;
use crate::app::files::built_in;
use crate::app::files::open::Files;
use crate::app::kept;
use crate::app::setup::current_setup::Setup;
use crate::app::shell::autosave::*;
use crate::diagnose::report::fixture;
use crate::model::preset::Preset;

/// The services behind a window that begins with a preset.
pub(super) fn services() -> Services {
    let setup: Setup = built_in::from_preset(Preset::default());
    Services::new(State::new(setup, View::default()), Files::new(|| {}))
}

/// A window's own file in `folder`.
fn slot(folder: &Path, start: Start) -> Slot {
    claim(folder, start).unwrap().slot
}

/// Waits until the thread that writes has done so.
fn wait_until_written(autosave: &Autosave) {
    let started = Instant::now();
    while autosave.written.try_lock().map_or(0, |written| written.0) < autosave.requested {
        assert!(
            started.elapsed() < Duration::from_secs(60),
            "nothing is written"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn duration_in(path: &Path) -> f64 {
    session::load(path).unwrap().setup.duration
}

#[test]
fn steady_editing_is_written_in_time() {
    let folder = tempfile::tempdir().unwrap();
    let mut services = services();
    let mut autosave = Autosave::new(&services.state, Some(slot(folder.path(), Start::Files)));
    let path = autosave.slot.as_ref().unwrap().path().to_owned();
    let begin = Instant::now();
    let mut written = 0;
    // One edit every 50 ms for 20 s, without a pause.
    for step in 1..=400 {
        let now = begin + Duration::from_millis(50 * step);
        services.state.setup.duration = step as f64;
        let wait = autosave.look(&mut services, now, || {});
        if autosave.requested > written {
            written = autosave.requested;
            wait_until_written(&autosave);
            assert_eq!(duration_in(&path), step as f64);
        } else {
            assert!(
                wait.is_some_and(|wait| wait <= MAX_UNSAVED_TIME),
                "{wait:?}"
            );
        }
        let saved = if written > 0 { duration_in(&path) } else { 0.0 };
        assert!((step as f64 - saved) * 0.05 < 3.2, "{step}: {saved}");
    }
    assert!((5..=8).contains(&written), "{written} times");
}

#[test]
fn a_change_is_written_after_a_quiet_time_and_only_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut services = services();
    let mut autosave = Autosave::new(&services.state, Some(slot(folder.path(), Start::Files)));
    let begin = Instant::now();
    assert_eq!(autosave.look(&mut services, begin, || {}), None);
    services.state.setup.duration = 7.0;
    let wait = autosave.look(&mut services, begin, || {});
    assert_eq!(wait, Some(QUIET_TIME));
    assert_eq!(autosave.requested, 0);
    assert_eq!(
        autosave.look(&mut services, begin + QUIET_TIME, || {}),
        None
    );
    assert_eq!(autosave.requested, 1);
    wait_until_written(&autosave);
    let later = begin + 10 * QUIET_TIME;
    assert_eq!(autosave.look(&mut services, later, || {}), None);
    assert_eq!(autosave.requested, 1);
}

#[test]
fn a_crash_keeps_results() {
    let folder = tempfile::tempdir().unwrap();
    let mut services = services();
    let mut autosave = Autosave::new(&services.state, Some(slot(folder.path(), Start::Files)));
    let path = autosave.slot.as_ref().unwrap().path().to_owned();
    let asked = Asked::of(&services.state.setup, None);
    services.state.diagnosing.adopt(fixture::drag(), asked);
    let begin = Instant::now();
    assert_eq!(autosave.look(&mut services, begin, || {}), Some(QUIET_TIME));
    autosave.look(&mut services, begin + QUIET_TIME, || {});
    wait_until_written(&autosave);
    // The process ends here; another window opens what is left.
    let loaded = session::load(&path).unwrap();
    let mut state = State::new(loaded.setup, loaded.view);
    assert_eq!(kept::restore(&mut state, &loaded.results), None);
    let answer = |state: &State| format!("{:?}", state.diagnosing.shown().unwrap().diagnosis);
    assert_eq!(answer(&state), answer(&services.state));
}

#[test]
fn what_could_not_be_written_is_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut services = services();
    let mut autosave = Autosave::new(&services.state, Some(slot(folder.path(), Start::Files)));
    let path = autosave.slot.as_ref().unwrap().path().to_owned();
    // A folder of this name cannot be replaced by a file.
    std::fs::create_dir_all(path.join("inside")).unwrap();
    services.state.setup.duration = 7.0;
    let begin = Instant::now();
    autosave.look(&mut services, begin, || {});
    let now = begin + QUIET_TIME;
    autosave.look(&mut services, now, || {});
    wait_until_written(&autosave);
    assert_eq!(autosave.look(&mut services, now, || {}), Some(RETRY_TIME));
    let said = &services.state.notices;
    assert!(
        said.iter()
            .any(|n| n.is_error && n.text.contains("Autosave failed"))
    );
    std::fs::remove_dir_all(&path).unwrap();
    assert_eq!(autosave.look(&mut services, now + RETRY_TIME, || {}), None);
    wait_until_written(&autosave);
    assert_eq!(duration_in(&path), 7.0);
}

#[test]
fn windows_open_at_once_have_files_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let first = claim(folder.path(), Start::LastSession).unwrap();
    assert_eq!(first.words, None);
    let second = claim(folder.path(), Start::LastSession).unwrap();
    let words = second.words.as_deref().unwrap_or_default();
    assert!(words.contains("Another window is open"), "{words}");
    assert_ne!(first.slot.path(), second.slot.path());
    for (slot, duration) in [(&first.slot, 1.0), (&second.slot, 2.0)] {
        let mut services = services();
        services.state.setup.duration = duration;
        let mut autosave = Autosave::new(&services.state, None);
        autosave.save_at_exit(&services);
        assert!(!slot.path().exists(), "a window without a file writes none");
        SessionParts::of(&services)
            .save(slot.path(), &Memo::default())
            .unwrap();
    }
    assert_eq!(duration_in(first.slot.path()), 1.0);
    assert_eq!(duration_in(second.slot.path()), 2.0);
    // Both are closed: the last one written comes back, and the other is kept.
    let [first, second] = [first, second].map(|window| window.slot.path().to_owned());
    let later = SystemTime::now() + Duration::from_secs(5);
    let file = std::fs::File::options().write(true).open(&second).unwrap();
    file.set_modified(later).unwrap();
    let next = slot(folder.path(), Start::LastSession);
    assert_eq!(next.path(), second);
    let mut notices = Vec::new();
    assert_eq!(restore(&next, &mut notices).unwrap().setup.duration, 2.0);
    assert_eq!(duration_in(&first), 1.0);
}

#[test]
fn a_window_opened_with_files_leaves_the_last_session_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut services = services();
    services.state.setup.duration = 3.0;
    let last = slot(folder.path(), Start::LastSession).path().to_owned();
    SessionParts::of(&services)
        .save(&last, &Memo::default())
        .unwrap();
    let own = slot(folder.path(), Start::Files);
    assert_ne!(own.path(), last);
    services.state.setup.duration = 4.0;
    let mut autosave = Autosave::new(&services.state, Some(own));
    autosave.save_at_exit(&services);
    assert_eq!(duration_in(&last), 3.0);
    assert_eq!(duration_in(autosave.slot.as_ref().unwrap().path()), 4.0);
}

#[test]
fn the_oldest_of_very_many_sessions_is_replaced_with_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let services = services();
    let mut taken = Vec::new();
    loop {
        let claimed = claim(folder.path(), Start::Files).unwrap();
        if let Some(words) = &claimed.words {
            assert!(words.contains("will be replaced"), "{words}");
            break;
        }
        let path = claimed.slot.path().to_owned();
        assert!(!taken.contains(&path), "{}", path.display());
        SessionParts::of(&services)
            .save(&path, &Memo::default())
            .unwrap();
        let age = Duration::from_secs(3600 - taken.len() as u64);
        let file = std::fs::File::options().write(true).open(&path).unwrap();
        file.set_modified(SystemTime::now() - age).unwrap();
        taken.push(path);
        assert!(taken.len() < 100);
    }
    assert_eq!(slot(folder.path(), Start::Files).path(), taken[0]);
    // All of them are open.
    let open: Vec<Slot> = taken
        .iter()
        .map(|_| slot(folder.path(), Start::Files))
        .collect();
    let refused = claim(folder.path(), Start::Files).unwrap_err();
    assert!(refused.contains("windows are open"), "{refused}");
    drop(open);
    assert!(claim(folder.path(), Start::Files).is_ok());
}

#[test]
fn what_an_interrupted_writing_left_is_swept_by_the_next_window() {
    let folder = tempfile::tempdir().unwrap();
    let path = slot(folder.path(), Start::LastSession).path().to_owned();
    let name = path.file_name().unwrap().to_str().unwrap();
    let part = folder.path().join(format!("{name}.4294967294-0.part"));
    let other = folder.path().join("mine.toml.4294967294-0.part");
    for file in [&part, &other] {
        std::fs::write(file, "ha").unwrap();
    }
    let _open = slot(folder.path(), Start::LastSession);
    assert!(!part.exists());
    assert!(other.exists(), "not the program's");
}

#[test]
fn a_folder_that_cannot_be_written_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no/such/folder");
    let refused = claim(&missing, Start::LastSession).unwrap_err();
    assert!(refused.contains("check that the folder"), "{refused}");
}
