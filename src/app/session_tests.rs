use super::*;
use crate::model::effects::{self, ActiveEffect};
use crate::model::parameter::ParameterId;

fn setup() -> Setup {
    let mut setup = first_start::setup();
    setup.preset.model.parameters.set(ParameterId::Cs, 2.5e-21);
    setup.locked.insert("Cs".to_owned());
    let drag = effects::find("quadratic_drag").unwrap();
    setup.preset.model.effects.push(ActiveEffect::new(drag));
    setup.overlays[0].alignment.time_shift = 1.5e-3;
    setup.overlays[0].visible = false;
    setup
}

#[test]
fn comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    let table = VoltageTable::new("edited", vec![0.0, 0.1, 0.2], vec![0.0, 8.0, 8.0], 0.0).unwrap();
    let drives = [
        DriveChoice::Waveform(Waveform::parse("ramped:5Hz:8V:0.25", 0.4).unwrap()),
        DriveChoice::Waveform(Waveform::parse("chirp:5Hz:80Hz:8V", 0.7).unwrap()),
        DriveChoice::Waveform(Waveform::Table(Arc::new(table))),
        DriveChoice::Recorded(1),
    ];
    for drive in drives {
        let setup = Setup { drive, ..setup() };
        let view = View {
            slow_down: 0.003,
            ..View::default()
        };
        save(&path, &setup, &view).unwrap();
        assert!(is_session(&path));
        let loaded = load(&path).unwrap();
        assert_eq!(loaded.setup, setup);
        assert_eq!(loaded.view, view);
        assert!(loaded.recordings.is_empty());
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "no temporary file is left");
}

#[test]
fn damage_is_named_and_the_file_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.impactscope.toml");
    save(&path, &setup(), &View::default()).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let damaged = [
        text[..text.len() / 2].to_owned(),
        text.replace("impactscope_session = 1", "impactscope_session = 99"),
        text.replace("gp = 0.00007", "gp = 0.00001"),
        String::from("hello"),
    ];
    for (i, damaged) in damaged.iter().enumerate() {
        assert_ne!(damaged, &text, "{i}");
        std::fs::write(&path, damaged).unwrap();
        let error = load(&path).unwrap_err().to_string();
        assert!(error.contains("a.impactscope.toml"), "{error}");
        let kept = keep_unreadable(&path).unwrap();
        assert!(
            kept.to_string_lossy()
                .ends_with(&format!("unreadable-{}", i + 1))
        );
        assert_eq!(&std::fs::read_to_string(kept).unwrap(), damaged);
    }
    let missing = folder.path().join("no/such/folder/x.toml");
    assert!(save(&missing, &setup(), &View::default()).is_err());
    assert!(load(&missing).is_err());
}
