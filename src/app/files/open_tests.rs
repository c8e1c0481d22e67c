use std::path::Path;
use std::sync::atomic::AtomicUsize;

use crate::app::files::open::*;
use crate::app::files::{built_in, recent, session};
use crate::app::setup::current_setup::Setup;
use crate::app::setup::view::View;
use crate::model::preset::Preset;

const UNAMBIGUOUS_CSV: &str = "t [s], V [V], xp [um]\n0, 8, 1\n0.001, 8, 2\n0.002, 8, 3\n";
const AMBIGUOUS_CSV: &str = "time, a, b\n0, 8, 1\n0.001, 8, 2\n0.002, 8, 3\n";

/// The outcomes of the requested work.
fn events(ask: impl FnOnce(&Files)) -> Vec<FileEvent> {
    let calls = Arc::new(AtomicUsize::new(0));
    let of_files = Arc::clone(&calls);
    let files = Files::new(move || {
        of_files.fetch_add(1, Ordering::Relaxed);
    });
    ask(&files);
    let until = Instant::now() + Duration::from_secs(30);
    while files.pending() > 0 {
        assert!(Instant::now() < until, "{:?}", files.working());
        std::thread::sleep(Duration::from_millis(2));
    }
    while calls.load(Ordering::Relaxed) == 0 {
        assert!(Instant::now() < until, "no repaint was asked for");
        std::thread::sleep(Duration::from_millis(2));
    }
    files.poll()
}

fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn setup() -> Setup {
    built_in::from_preset(Preset::default())
}

#[test]
fn a_recording_with_unambiguous_columns_is_imported_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "a.csv", UNAMBIGUOUS_CSV);
    let found = events(|files| files.open(path.clone()));
    assert!(
        matches!(&found[..], [FileEvent::Recording { path: p, recording, .. }]
            if *p == path && recording.len() == 3 && recording.path.as_ref() == Some(&path)),
        "{found:?}"
    );
}

#[test]
fn two_columns_of_one_quantity_are_asked_about_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = "t [s], xp [um], xp [nm]\n0, 1, 900\n1e-5, 2, 1900\n2e-5, 3, 2900\n";
    let path = write(folder.path(), "a.csv", text);
    let found = events(|files| files.open(path.clone()));
    let [FileEvent::Ask { preview, .. }] = &found[..] else {
        panic!("{found:?}");
    };
    let asked = preview.problem().unwrap().to_string();
    for part in ["2 (\"xp [um]\")", "3 (\"xp [nm]\")", "--column xp="] {
        assert!(asked.contains(part), "{asked}");
    }
    // The answer is stored: the second time nothing is asked.
    let settings = preview.settings.clone();
    recent::remember(&path, Some(&settings));
    let found = events(|files| files.open(path.clone()));
    let [FileEvent::Recording { recording, .. }] = &found[..] else {
        panic!("{found:?}");
    };
    assert!((recording.proof_mass[2] - 3e-6).abs() < 1e-18);
}

#[test]
fn an_ambiguous_recording_asks_and_its_settings_are_stored() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "a.csv", AMBIGUOUS_CSV);
    let found = events(|files| files.open(path.clone()));
    let [FileEvent::Ask { preview, .. }] = &found[..] else {
        panic!("{found:?}");
    };
    let column = |index, unit: &str| Some(crate::recording::csv::ColumnChoice::new(index, unit));
    let settings = ImportSettings {
        time: column(0, "s"),
        proof_mass: column(2, "um"),
        ..preview.settings.clone()
    };
    recent::remember(&path, Some(&settings));
    let found = events(|files| files.open(path.clone()));
    assert!(
        matches!(&found[..], [FileEvent::Recording { settings: s, .. }] if **s == settings),
        "{found:?}"
    );
    // Saved again with fewer columns, it asks again and gives the reason.
    write(folder.path(), "a.csv", "time, a\n0, 8\n0.001, 8\n");
    let found = events(|files| files.open(path.clone()));
    assert!(
        matches!(&found[..], [FileEvent::Ask { preview, .. }]
            if preview.ambiguities.iter().any(|line| line.contains("no longer"))),
        "{found:?}"
    );
}

#[test]
fn the_sensitivity_of_an_instrument_is_asked_once_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let text = "t [s], V [V], xp [V]\n0, 8, 1\n0.001, 8, 2\n0.002, -8, 4\n";
    let first = write(folder.path(), "a.csv", text);
    let found = events(|files| files.open(first.clone()));
    let [FileEvent::Ask { preview, .. }] = &found[..] else {
        panic!("{found:?}");
    };
    let mut settings = preview.settings.clone();
    settings.proof_mass.as_mut().unwrap().scale = Some("0.5um/V".to_owned());
    let found = events(|files| files.import(first.clone(), settings, None));
    assert!(
        matches!(&found[..], [FileEvent::Recording { .. }]),
        "{found:?}"
    );
    // The next one of the folder is read without a question, and says so.
    let second = write(folder.path(), "b.csv", &text.replace("-8", "8"));
    let found = events(|files| files.open(second.clone()));
    let [FileEvent::Recording { recording, .. }] = &found[..] else {
        panic!("{found:?}");
    };
    assert!((recording.proof_mass[2] - 2e-6).abs() < 1e-18);
    let said = |w: &crate::recording::ImportWarning| w.message.contains("0.5um/V is taken");
    assert!(
        recording.warnings.iter().any(said),
        "{:?}",
        recording.warnings
    );
    // Another folder asks.
    let other = tempfile::tempdir().unwrap();
    let third = write(other.path(), "a.csv", text);
    let found = events(|files| files.open(third.clone()));
    assert!(matches!(&found[..], [FileEvent::Ask { .. }]), "{found:?}");
}

#[test]
fn the_kind_of_a_file_is_found_from_its_content() {
    let folder = tempfile::tempdir().unwrap();
    let session = folder.path().join("mine.toml");
    session::save(&session, &setup(), &View::default(), &[]).unwrap();
    let found = events(|files| files.open(session));
    assert!(
        matches!(&found[..], [FileEvent::Session { .. }]),
        "{found:?}"
    );
    let preset = write(folder.path(), "p.toml", &Preset::default().to_toml());
    let found = events(|files| files.open(preset));
    assert!(
        matches!(&found[..], [FileEvent::Preset { .. }]),
        "{found:?}"
    );
    let foreign = write(
        folder.path(),
        "f.impactscope.toml",
        "impactscope_session = 9",
    );
    let found = events(|files| files.open(foreign));
    assert!(
        matches!(&found[..], [FileEvent::Failed { message }] if message.contains("format 9")),
        "{found:?}"
    );
}

#[test]
fn missing_and_changed_recordings_are_reported_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "a.csv", UNAMBIGUOUS_CSV);
    let settings = preview(&path).unwrap().settings;
    let entry = RecordingEntry {
        id: 4,
        path: Some(path.clone()),
        relative: None,
        sha256: Some("another".to_owned()),
        made_up: false,
        role: None,
        name: None,
        import: settings.clone(),
        alignment: Default::default(),
        drive: None,
        estimates: Default::default(),
        visible: true,
        color: 0,
    };
    let import = || {
        let (path, settings, entry) = (path.clone(), settings.clone(), entry.clone());
        events(move |files| files.import(path, settings, Some(entry)))
    };
    let found = import();
    assert!(
        matches!(&found[..], [FileEvent::Failed { message }]
            if message.contains("has changed") && message.contains("Open it again")),
        "{found:?}"
    );
    std::fs::remove_file(&path).unwrap();
    let found = import();
    assert!(
        matches!(&found[..], [FileEvent::Lost { message, .. }] if message.contains("check the path")),
        "{found:?}"
    );
}

#[test]
fn a_panic_becomes_text_and_a_cancelled_import_nothing() {
    let found = events(|files| files.spawn(PathBuf::from("x.csv"), |_| panic!("oh dear")));
    assert!(
        matches!(&found[..], [FileEvent::Failed { message }]
            if message.contains("oh dear") && message.contains("x.csv")),
        "{found:?}"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "a.csv", UNAMBIGUOUS_CSV);
    let settings = preview(&path).unwrap().settings;
    let found = events(|files| {
        files.spawn(path.clone(), move |context| {
            context.job.cancel();
            import_with(path, settings, Vec::new(), None, context)
        });
    });
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn work_in_progress_is_shown_and_can_be_cancelled() {
    let files = Files::new(|| {});
    let (go, wait) = channel::<()>();
    files.spawn(PathBuf::from("/data/long.csv"), move |context| {
        let mut share = 0.0;
        while context.progress(share) {
            share = 0.5;
            let _ = wait.recv_timeout(Duration::from_millis(2));
        }
        None
    });
    let until = Instant::now() + Duration::from_secs(30);
    while files.working().first().is_none_or(|w| w.fraction != 0.5) {
        assert!(Instant::now() < until);
        std::thread::sleep(Duration::from_millis(1));
    }
    let work = &files.working()[0];
    assert_eq!(work.path, Path::new("/data/long.csv"));
    assert!(work.can_cancel);
    files.cancel();
    while files.pending() > 0 {
        assert!(Instant::now() < until);
        std::thread::sleep(Duration::from_millis(1));
    }
    drop(go);
    assert!(files.poll().is_empty());
    // Work that never asks whether to continue cannot be cancelled.
    let (go, wait) = channel::<()>();
    files.work("saving", PathBuf::from("/data/a.csv"), move |_| {
        let _ = wait.recv();
        None
    });
    assert!(!files.working()[0].can_cancel);
    drop(go);
}
