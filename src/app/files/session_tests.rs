use std::sync::Arc;

use proptest::prelude::*;

use crate::app::files::atomic_write::keep_unreadable;
use crate::app::files::built_in;
use crate::app::files::session::*;
use crate::app::files::session_text::{TextError, from_text, to_text};
use crate::app::setup::current_setup::ParameterChoice;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::kept_curve::{KeptCurve, RunOrigin, of_session};
use crate::app::setup::overlay::{Overlay, Role};
use crate::app::setup::view::{RecordingLayout, ResidualUnit};
use crate::model::drive::{DriveReading, VoltageTable, Waveform};
use crate::model::effects;
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::preset::known_value::KnownValue;
use crate::recording::csv::{import, preview};

const CSV: &str = "t [s], V [V], xp [um]\n0, 8, 1\n0.001, 8, 2\n0.002, 8, 3\n0.003, -8, 2\n";

/// A device with an effect and a lock, without recordings.
fn setup() -> Setup {
    let mut setup = built_in::from_preset(Preset::default());
    setup.preset.model.parameters.set(ParameterId::Cs, 2.5e-21);
    setup.locked.insert("Cs".to_owned());
    let drag = effects::find("quadratic_drag").unwrap();
    setup.preset.model.effects.push(ActiveEffect::new(drag));
    setup
}

/// A recording written to `path` and imported from there.
fn overlay(id: u64, path: &Path) -> Overlay {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, CSV).unwrap();
    let settings = preview(path).unwrap().settings;
    let mut overlay = Overlay {
        id,
        recording: Arc::new(import(path, &settings, None).unwrap()),
        import: settings,
        alignment: Default::default(),
        drive: Default::default(),
        estimates: Default::default(),
        visible: false,
        color: 3,
        made_up: false,
        role: Some(Role::HeldOut),
    };
    overlay.alignment.time_shift = 1.5e-3;
    overlay
}

#[test]
fn a_saved_session_is_restored_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let table = VoltageTable::new("edited", vec![0.0, 0.1, 0.2], vec![0.0, 8.0, 8.0]).unwrap();
    let drives = [
        DriveChoice::Waveform(Waveform::Rest),
        DriveChoice::Waveform(Waveform::parse("ramped:5Hz:8V:0.25", 0.4).unwrap()),
        DriveChoice::Waveform(Waveform::parse("chirp:5Hz:80Hz:8V", 0.7).unwrap()),
        DriveChoice::Waveform(Waveform::Table(Arc::new(table))),
        DriveChoice::Waveform(Waveform::parse("square:15Hz:8V:duty=30%:burst=2/3", 0.4).unwrap()),
        DriveChoice::Waveform(Waveform::parse("drawn:15Hz:smooth:0/-8,0.3/8", 0.4).unwrap()),
        DriveChoice::Recorded(7),
    ];
    for drive in drives {
        let setup = Setup { drive, ..setup() };
        let view = View {
            slow_down: 0.003,
            time_range: Some((0.01, 0.02)),
            value_ranges: [("Phase portrait".to_owned(), (-1e-6, 2e-6))].into(),
            fixed_scales: ["Phase portrait".to_owned()].into(),
            residual_unit: ResidualUnit::Noise,
            recording_layout: RecordingLayout::SmallMultiples,
            own_value_scales: true,
            common_time: true,
            shown_alone: Some(7),
            workspace: "diagnose".to_owned(),
            ..View::default()
        };
        save(&path, &setup, &view, &[]).unwrap();
        assert!(is_session(&path));
        let loaded = load(&path).unwrap();
        assert_eq!(loaded.setup, setup);
        assert_eq!(loaded.view, view);
        assert!(loaded.recordings.is_empty() && loaded.missing.is_empty());
    }
    let entries: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(entries.len(), 1, "no temporary file remains");
}

#[test]
fn recordings_are_restored_by_path_hash_and_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let mut setup = setup();
    let shown = overlay(41, &folder.path().join("data/one.csv"));
    setup.overlays.push(shown.clone());
    setup.drive = DriveChoice::Recorded(41);
    save(&path, &setup, &View::default(), &[]).unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!(loaded.setup.drive, DriveChoice::Recorded(41));
    assert_eq!(loaded.last_id(), 41);
    let entry = &loaded.recordings[0];
    assert_eq!(entry.path, shown.recording.path);
    assert_eq!(entry.relative.as_deref(), Some(Path::new("data/one.csv")));
    assert_eq!(entry.sha256, shown.recording.sha256);
    assert!(entry.sha256.is_some());
    assert_eq!(entry.import, shown.import);
    assert_eq!(entry.alignment, shown.alignment);
    assert_eq!((entry.color, entry.visible), (3, false));
    assert_eq!(entry.role, Some(Role::HeldOut));
}

#[test]
fn the_built_in_recording_needs_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let Some(mut built_in_overlay) = built_in::made_up(5) else {
        return; // This build has none.
    };
    built_in_overlay.alignment.time_shift = 2e-3;
    built_in_overlay.visible = false;
    let mut setup = setup();
    setup.overlays.push(built_in_overlay);
    save(&path, &setup, &View::default(), &[]).unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!(loaded.setup, setup);
    assert!(loaded.setup.overlays[0].made_up);
}

#[test]
fn the_example_is_restored_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let mut setup = setup();
    let mut built_in_overlay = built_in::shipped(Some("held-out-2"), 8).unwrap();
    built_in_overlay.role = Some(Role::HeldOut);
    setup.overlays.push(built_in_overlay);
    setup.overlays.extend(built_in::made_up(9));
    save(&path, &setup, &View::default(), &[]).unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!(loaded.setup, setup);
    let names = loaded
        .setup
        .overlays
        .iter()
        .map(|o| o.recording.name.clone());
    assert_eq!(
        names.collect::<Vec<_>>(),
        ["held-out-2", built_in::MADE_UP_NAME]
    );
}

#[test]
fn a_moved_session_finds_its_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let (old, new) = (folder.path().join("old"), folder.path().join("new"));
    let mut setup = setup();
    setup.overlays.push(overlay(1, &old.join("data/one.csv")));
    setup.overlays.push(overlay(2, &old.join("data/two.csv")));
    setup.overlays.push(overlay(3, &old.join("data/three.csv")));
    save(
        &old.join("a.impactscope.toml"),
        &setup,
        &View::default(),
        &[],
    )
    .unwrap();
    std::fs::rename(&old, &new).unwrap();
    // One lies next to the session now, one is missing.
    std::fs::rename(new.join("data/two.csv"), new.join("two.csv")).unwrap();
    std::fs::remove_file(new.join("data/three.csv")).unwrap();
    let loaded = load(&new.join("a.impactscope.toml")).unwrap();
    let places: Vec<_> = loaded.recordings.iter().map(|e| e.path.clone()).collect();
    assert_eq!(places[0], Some(new.join("data/one.csv")));
    assert_eq!(places[1], Some(new.join("two.csv")));
    assert_eq!(places[2], Some(old.join("data/three.csv")));
    let gone = import(
        places[2].as_ref().unwrap(),
        &loaded.recordings[2].import,
        None,
    );
    assert!(gone.unwrap_err().to_string().contains("does not exist"));
}

#[test]
fn damage_is_reported_and_a_copy_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    save(&path, &setup(), &View::default(), &[]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let damaged = [
        text[..text.len() / 2].to_owned(),
        text.replace("gp = 0.00007", "gp = 0.00001"),
        text.replace("slow_down = 0.01", "slow_down = nan"),
        text.replace("duration = ", "duration = -"),
        String::from("hello"),
        String::from("# nothing\n"),
        String::new(),
    ];
    for (i, damaged) in damaged.iter().enumerate() {
        assert_ne!(damaged, &text, "{i}");
        std::fs::write(&path, damaged).unwrap();
        let error = load(&path).unwrap_err();
        assert!(matches!(error, SessionError::Unreadable { .. }), "{error}");
        assert!(error.to_string().contains("a.impactscope.toml"), "{error}");
        let copy = keep_unreadable(&path).unwrap();
        assert!(
            copy.to_string_lossy()
                .ends_with(&format!("unreadable-{}", i + 1))
        );
        assert_eq!(&std::fs::read_to_string(copy).unwrap(), damaged);
    }
    std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    assert!(load(&path).unwrap_err().to_string().contains("UTF-8"));
}

#[cfg(unix)]
#[test]
fn a_copy_that_fails_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // A folder can be opened, but not read: the copy is made, and fails.
    let path = folder.path().join("folder");
    std::fs::create_dir(&path).unwrap();
    assert!(keep_unreadable(&path).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_truncated_session_gives_an_error_and_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let mut setup = setup();
    setup
        .overlays
        .push(overlay(1, &folder.path().join("one.csv")));
    save(&path, &setup, &View::default(), &[]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
        if let Ok(loaded) = crate::app::files::session_text::from_text(&text[..end]) {
            // Only entries with a default may be missing.
            assert_eq!(loaded.setup.preset, setup.preset, "cut at {end}");
            assert_eq!(loaded.setup.locked, setup.locked, "cut at {end}");
            assert_eq!(loaded.recordings.len(), 1, "cut at {end}");
        }
    }
}

#[test]
fn another_version_is_distinguished_from_damage() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    for text in [
        "impactscope_session = 99\nnew_key = 3\n",
        "impactscope_session = 0",
    ] {
        std::fs::write(&path, text).unwrap();
        let error = load(&path).unwrap_err();
        assert!(
            matches!(error, SessionError::ForeignVersion { .. }),
            "{error}"
        );
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}

#[test]
fn two_recordings_with_the_same_number_are_renumbered() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let mut setup = setup();
    for (id, name) in [(1, "one.csv"), (1, "two.csv"), (2, "three.csv")] {
        setup.overlays.push(overlay(id, &folder.path().join(name)));
    }
    setup.drive = DriveChoice::Recorded(1);
    save(&path, &setup, &View::default(), &[]).unwrap();
    let loaded = load(&path).unwrap();
    let ids: Vec<_> = loaded.recordings.iter().map(|entry| entry.id).collect();
    assert_eq!(ids, [1, 3, 2]);
    assert_eq!(loaded.setup.drive, DriveChoice::Recorded(1));
}

#[test]
fn a_failed_save_leaves_the_earlier_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no/such/folder/x.toml");
    assert!(save(&missing, &setup(), &View::default(), &[]).is_err());
    assert!(load(&missing).is_err());
    // A folder with this name cannot be replaced by a file.
    let taken = folder.path().join("taken.impactscope.toml");
    std::fs::create_dir_all(taken.join("inside")).unwrap();
    assert!(save(&taken, &setup(), &View::default(), &[]).is_err());
    let entries: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(entries.len(), 1, "{entries:?}");
}

/// A kept curve of the oscillator.
fn kept(name: &str, color: usize, drive: DriveChoice) -> KeptCurve {
    KeptCurve {
        name: name.to_owned(),
        color,
        visible: color != 1,
        origin: Arc::new(RunOrigin {
            preset: Preset::embedded("oscillator").unwrap(),
            drive,
            shift: 1.5e-3,
            reading: Default::default(),
            duration: 0.3,
            live: None,
        }),
    }
}

#[test]
fn kept_curves_are_saved_with_names_colours_and_ticks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let mut setup = setup();
    setup
        .overlays
        .push(overlay(7, &folder.path().join("one.csv")));
    save(&path, &setup, &View::default(), &[]).unwrap();
    let none = std::fs::read_to_string(&path).unwrap();
    assert!(!none.contains("kept"), "{none}");
    assert_eq!(load(&path).unwrap().setup.kept, []);
    let table = VoltageTable::new("edited", vec![0.0, 0.1, 0.2], vec![0.0, 8.0, 8.0]).unwrap();
    let chirp = Waveform::parse("chirp:5Hz:80Hz:8V", 0.7).unwrap();
    setup.kept = vec![
        kept("Cs 2.1e-21, gp 30 nm", 0, DriveChoice::Waveform(chirp)),
        kept(
            "\"soft\" film = \u{b5}m \\ #1",
            1,
            DriveChoice::Waveform(Waveform::Table(Arc::new(table))),
        ),
        kept("kept 1", 11, DriveChoice::Recorded(7)),
    ];
    // Its curve does not change with how the recording's voltage is read later.
    Arc::make_mut(&mut setup.kept[2].origin).reading = DriveReading::PointByPoint;
    save(&path, &setup, &View::default(), &[]).unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!(loaded.setup.kept, setup.kept);
    assert_eq!(loaded.recordings.len(), 1);
    // A live run cannot be computed again.
    let live = RunOrigin {
        live: Some(3),
        ..(*setup.kept[0].origin).clone()
    };
    setup.kept[0].origin = Arc::new(live);
    save(&path, &setup, &View::default(), &[]).unwrap();
    assert_eq!(load(&path).unwrap().setup.kept, setup.kept[1..]);
    let text = std::fs::read_to_string(&path).unwrap();
    let broken = text.replace("duration = 0.3", "duration = -0.3");
    assert_ne!(broken, text);
    std::fs::write(&path, broken).unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(
        error.contains("kept curve") && error.contains("-0.3 s"),
        "{error}"
    );
}

#[test]
fn the_curve_of_an_older_session_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    save(&path, &setup(), &View::default(), &[]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    // As an earlier version wrote it, with a key of the view that is no longer used.
    let preset = Preset::embedded("oscillator").unwrap().to_toml();
    assert!(!preset.contains("'''"));
    let older = text.replace("[view]\n", "[view]\nshow_events = false\n")
        + &format!(
            "\n[view.kept]\nduration = 0.3\nshift = 0.0015\npreset = '''\n{preset}'''\n\n[view.kept.drive]\nrecorded = 7\n"
        );
    assert!(older.contains("show_events"));
    std::fs::write(&path, older).unwrap();
    let loaded = load(&path).unwrap();
    let expected = kept("kept 1", 0, DriveChoice::Recorded(7));
    assert_eq!(loaded.setup.kept, [expected]);
    assert_eq!(loaded.view, View::default());
    // Written again, it is a session of this version.
    save(&path, &loaded.setup, &loaded.view, &[]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.contains("[[kept]]") && !text.contains("view.kept"),
        "{text}"
    );
    assert_eq!(load(&path).unwrap().setup.kept, loaded.setup.kept);
}

fn any_kept() -> impl Strategy<Value = KeptCurve> {
    let values = (-1e-3..1e-3f64, 1e-6..10.0f64, 1e-22..1e-20f64, 0.1..0.9f64);
    (
        "\\PC{1,40}",
        0..40usize,
        any::<bool>(),
        values,
        1.0..90.0f64,
    )
        .prop_map(
            |(name, color, visible, (shift, duration, cs, alpha), frequency)| {
                let mut preset = Preset::default();
                preset.model.parameters.set(ParameterId::Cs, cs);
                preset.model.parameters.set(ParameterId::Alpha, alpha);
                KeptCurve {
                    name,
                    color,
                    visible,
                    origin: Arc::new(RunOrigin {
                        preset,
                        drive: DriveChoice::Waveform(Waveform::Sine {
                            frequency,
                            amplitude: 8.0,
                        }),
                        shift,
                        reading: Default::default(),
                        duration,
                        live: None,
                    }),
                }
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_kept_curves_are_restored_to_the_last_bit(
        curves in prop::collection::vec(any_kept(), 0..5)
    ) {
        // Names are distinct and not blank, as the window makes them.
        let curves = of_session(curves).unwrap();
        let setup = Setup { kept: curves, ..setup() };
        let path = Path::new("a.impactscope.toml");
        let written = text(path, &setup, &View::default(), &[]).unwrap();
        let loaded = parse(path, &written).unwrap();
        prop_assert_eq!(&loaded.setup.kept, &setup.kept);
    }
}

#[test]
fn what_a_diagnosis_is_asked_comes_back() {
    let mut setup = setup();
    let text = |setup: &Setup| to_text(setup, &View::default(), &[], Path::new("/a")).unwrap();
    assert!(!text(&setup).contains("diagnosis"));
    setup.diagnosis.longest = Some(30.0);
    setup.diagnosis.skipped.insert("gravity".to_owned());
    let known = ParameterChoice::Known {
        value: 1.7e-21,
        std_error: 2e-22,
    };
    let all = &mut setup.diagnosis.parameters;
    all.insert("Cs".to_owned(), known);
    all.insert("f1".to_owned(), ParameterChoice::Held);
    all.insert("quadratic_drag.cd".to_owned(), ParameterChoice::Free);
    let own = KnownValue::new(&setup.preset.model, "zeta1", (0.026, 1e-3)).unwrap();
    setup.preset.known.push(own);
    let written = text(&setup);
    let read = from_text(&written).unwrap().setup;
    assert_eq!(read.diagnosis, setup.diagnosis);
    assert_eq!(read.preset.known, setup.preset.known);
    let bad = written.replacen("longest = 30.0", "longest = -30.0", 1);
    assert_ne!(bad, written);
    let Err(TextError::Damaged(said)) = from_text(&bad) else {
        panic!("it was read");
    };
    assert!(said.contains("-30 s is invalid"), "{said}");
}
