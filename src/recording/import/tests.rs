//! The door on wrapped, binary and plain files.

use std::io::Write;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::*;
use crate::recording::combine::{AverageOptions, Combination};
use crate::recording::csv::{self, DriftRemoval, ReadingChoices};
use crate::recording::{Channel, WarningKind};

const TEXT: &str = "t [ms],V [V],xp [um]\n0.0,7,1.5\n0.1,7,1.25\n0.2,-7,1.0\n0.3,-7,0.5\n";

fn write(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut out = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in files {
        let options = zip::write::SimpleFileOptions::default();
        out.start_file(*name, options).unwrap();
        out.write_all(bytes).unwrap();
    }
    out.finish().unwrap().into_inner()
}

fn read(path: &Path) -> Result<Recording, ImportError> {
    import_chosen(path, &ReadingChoices::default(), None)
}

#[test]
fn a_wrapped_text_is_read_as_the_text() {
    let folder = tempfile::tempdir().unwrap();
    let plain = read(&write(&folder, "a.csv", TEXT.as_bytes())).unwrap();
    let twice = gzip(&gzip(TEXT.as_bytes()));
    let in_zip = zipped(&[("run/a.csv", TEXT.as_bytes())]);
    for (name, bytes) in [
        ("a.csv.gz", gzip(TEXT.as_bytes())),
        ("a.csv.gz.gz", twice),
        ("a.zip", in_zip),
    ] {
        let path = write(&folder, name, &bytes);
        let found = read(&path).unwrap();
        assert_eq!(found.time, plain.time, "{name}");
        assert_eq!(found.proof_mass, plain.proof_mass);
        assert_eq!(found.voltage, plain.voltage);
        assert_eq!(
            (found.name.as_str(), found.path.as_deref()),
            (name, Some(&*path))
        );
        // The hash is of the file, so that a session knows it again.
        assert_eq!(found.sha256, Some(csv::hex(&Sha256::digest(&bytes))));
        let settings = preview(&path).unwrap().settings;
        assert_eq!(import(&path, &settings, None).unwrap().time, plain.time);
        let (times, volts) = import_voltage(&path).unwrap();
        assert_eq!((times.len(), volts[2]), (4, -7.0));
    }
}

#[test]
fn recordings_below_each_other_are_found_in_a_wrapper_too() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |first: &str| -> String {
        let rest = (1..40).map(|i| format!("{}.0,7,{}\n", i, f64::from(i) * 0.5));
        format!("0.0,7,{first}\n") + &rest.collect::<String>()
    };
    let text = format!("t [ms],V [V],xp [um]\n{}{}", rows("1.5"), rows("2.5"));
    let plain = write(&folder, "a.csv", text.as_bytes());
    let wrapped = write(&folder, "a.csv.gz", &gzip(text.as_bytes()));
    assert_eq!(trials(&plain).unwrap().len(), 2);
    assert_eq!(trials(&wrapped).unwrap(), trials(&plain).unwrap());
    assert!(preview(&wrapped).unwrap().needs_dialog());
    let second = ReadingChoices {
        trial: Some(2),
        ..ReadingChoices::default()
    };
    let found = import_chosen(&wrapped, &second, None).unwrap();
    assert!((found.proof_mass[0] / 2.5e-6 - 1.0).abs() < 1e-12);
}

#[test]
fn archives_within_archives_end() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = TEXT.as_bytes().to_vec();
    for _ in 0..6 {
        bytes = gzip(&bytes);
    }
    let error = read(&write(&folder, "deep.gz", &bytes))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("deep.gz") && error.contains("unpack"),
        "{error}"
    );
}

#[test]
fn one_of_several_recordings_is_chosen_by_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let other = TEXT.replace("1.25", "9.25");
    let files = [
        ("readme.txt", &b"made on a Tuesday\n"[..]),
        ("a.csv", TEXT.as_bytes()),
        ("b.csv", other.as_bytes()),
    ];
    let path = write(&folder, "two.zip", &zipped(&files));
    let error = read(&path).unwrap_err().to_string();
    for part in ["two.zip", "a.csv", "b.csv", "--trial"] {
        assert!(error.contains(part), "{error}");
    }
    assert_eq!(trials(&path).unwrap(), ["a.csv", "b.csv"]);
    let second = ReadingChoices {
        trial: Some(2),
        ..ReadingChoices::default()
    };
    let found = import_chosen(&path, &second, None).unwrap();
    assert!((found.channel(Channel::ProofMass).unwrap()[1] / 9.25e-6 - 1.0).abs() < 1e-12);
    assert_eq!(found.name, "two.zip: b.csv");
    // What the dialog shows of it, and what it stores, lead to the same.
    let shown = preview_chosen(&path, &second).unwrap();
    assert_eq!((shown.trials.len(), shown.settings.trial), (2, Some(2)));
    assert!(!shown.is_text && preview(&path).unwrap().needs_dialog());
    let again = import(&path, &shown.settings, None).unwrap();
    assert_eq!(again.proof_mass, found.proof_mass);
    let third = ReadingChoices {
        trial: Some(3),
        ..ReadingChoices::default()
    };
    let error = import_chosen(&path, &third, None).unwrap_err().to_string();
    assert!(error.contains('3') && error.contains('2'), "{error}");
}

#[test]
fn what_is_missing_is_said_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let error = read(&folder.path().join("none.csv")).unwrap_err();
    assert!(matches!(error, ImportError::NotFound { .. }), "{error}");
    let error = read(folder.path()).unwrap_err();
    assert!(matches!(error, ImportError::IsDirectory { .. }), "{error}");
    let path = write(&folder, "cut.gz", &gzip(TEXT.as_bytes())[..30]);
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("cut.gz"), "{error}");
    let empty = write(&folder, "empty.zip", &zipped(&[]));
    let error = read(&empty).unwrap_err().to_string();
    assert!(error.contains("empty.zip"), "{error}");
}

/// A sweep of 4 s: time, voltage and a displacement of `gain` for each volt, `late` seconds into it.
fn sweep(late: f64, point: &str, gain: f64, ripple: f64) -> String {
    let mut text = format!("t [s],V [V],{point} [um]\n");
    for i in 0..4000 {
        let t = 1e-3 * f64::from(i);
        let u = t + late;
        let v = 5.0 * (20.0 * u + 6.0 * u * u).sin();
        let x = gain * v + ripple * (f64::from(i) * 1.7 + 40.0 * late).sin();
        text += &format!("{t:.6},{v:.9},{x:.9}\n");
    }
    text
}

fn read_with(path: &Path, combine: Combination) -> Result<Recording, ImportError> {
    let settings = ImportSettings {
        combine: Some(combine),
        ..preview(path).unwrap().settings
    };
    // As it comes back from a session.
    let text = toml::to_string(&settings).unwrap();
    let stored: ImportSettings = toml::from_str(&text).unwrap();
    assert_eq!(stored, settings);
    import(path, &stored, None)
}

#[test]
fn runs_of_two_points_are_merged_by_settings_and_by_choices() {
    let folder = tempfile::tempdir().unwrap();
    let xp = write(&folder, "xp.csv", sweep(0.0, "xp", 1.0, 0.0).as_bytes());
    let xc = write(&folder, "xc.csv", sweep(0.0125, "xc", 0.3, 0.0).as_bytes());
    let check = |both: &Recording| {
        let own = both.cantilever.as_ref().unwrap();
        for (i, x) in own.iter().enumerate().skip(10).take(both.len() - 20) {
            assert!((x - 0.3 * both.proof_mass[i]).abs() < 2e-9, "{i}: {x}");
        }
        assert!(both.len() > 3900);
        assert!(both.warnings.iter().any(|w| w.kind == WarningKind::Merged));
    };
    check(&merge_files(&xp, &xc, &ReadingChoices::default(), None, None).unwrap());
    let points = |other: &Path, other_is_proof_mass| Combination::Points {
        other: other.to_owned(),
        other_is_proof_mass,
        lag: None,
    };
    check(&read_with(&xp, points(&xc, false)).unwrap());
    // Another header: read by its own, and said.
    let text = sweep(0.0125, "xc", 0.3, 0.0).replace("t [s],V [V]", "time [s],U [V]");
    let odd = write(&folder, "odd.csv", text.as_bytes());
    let both = read_with(&xp, points(&odd, false)).unwrap();
    check(&both);
    assert!(
        both.warnings
            .iter()
            .any(|w| w.message.contains("odd.csv differs"))
    );
    // The wrong order, and another drive.
    let error = merge_files(&xc, &xp, &ReadingChoices::default(), None, None).unwrap_err();
    assert!(error.to_string().contains("turn the order"), "{error}");
    let text = sweep(0.0, "xc", 0.3, 0.0).replace(",", ",-");
    let turned = write(
        &folder,
        "turned.csv",
        text.replace("--", "")
            .replace(",-V", ",V")
            .replace(",-xc", ",xc")
            .as_bytes(),
    );
    let error = merge_files(&xp, &turned, &ReadingChoices::default(), None, None).unwrap_err();
    assert!(error.to_string().contains("turned.csv"), "{error}");
    assert!(matches!(error, ImportError::Combine(_)));
}

#[test]
fn trials_of_a_file_and_of_several_files_are_averaged() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<PathBuf> = (0..3)
        .map(|i| {
            let late = 0.004 * f64::from(i);
            let text = sweep(late, "xp", 1.0, 0.02);
            write(&folder, &format!("{i}.csv"), text.as_bytes())
        })
        .collect();
    let choices = ReadingChoices::default();
    let options = AverageOptions::default();
    let mean = average_files(&files, None, &choices, options, None).unwrap();
    assert_eq!(mean.spread.as_ref().unwrap().trials, 3);
    assert_eq!(mean.name, "0.csv, mean of 3 trials");
    let combine = Combination::Average {
        trials: Vec::new(),
        files: files[1..].to_vec(),
        leave_out_misfits: false,
        match_zeros: false,
    };
    let by_settings = read_with(&files[0], combine).unwrap();
    assert_eq!(by_settings.proof_mass, mean.proof_mass);
    assert_eq!(by_settings.sha256, mean.sha256);
    assert_ne!(
        mean.sha256,
        import_chosen(&files[0], &choices, None).unwrap().sha256
    );
    // One recording is no average.
    let error = read_with(&files[0], Combination::average_of_all()).unwrap_err();
    assert!(error.to_string().contains("two recordings"), "{error}");

    // Below each other in one file, and side by side.
    let texts: Vec<String> = files
        .iter()
        .map(|f| std::fs::read_to_string(f).unwrap())
        .collect();
    let stacked = write(&folder, "stacked.csv", texts.concat().as_bytes());
    let rows: Vec<Vec<&str>> = texts.iter().map(|t| t.lines().collect()).collect();
    let beside: Vec<String> = (0..rows[0].len())
        .map(|i| [rows[0][i], rows[1][i], rows[2][i]].join(","))
        .collect();
    let beside = write(&folder, "beside.csv", beside.join("\n").as_bytes());
    for path in [&stacked, &beside] {
        let all = read_with(path, Combination::average_of_all()).unwrap();
        assert_eq!(all.proof_mass, mean.proof_mass, "{}", path.display());
        let two = average_files(
            std::slice::from_ref(path),
            Some(&[1, 3]),
            &choices,
            options,
            None,
        );
        assert_eq!(two.unwrap().spread.as_ref().unwrap().trials, 2);
    }
}

#[test]
fn the_drift_of_a_velocity_is_taken_out_by_choice_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "t [s],v [mm/s]\n".to_owned();
    let w = 20.0 * std::f64::consts::PI;
    for i in 0..=4000 {
        let t = 1e-3 * f64::from(i);
        text += &format!("{t:.3},{:.9}\n", 0.5 + (w * t).cos());
    }
    let path = write(&folder, "v.csv", text.as_bytes());
    let read = |drift| {
        let choices = ReadingChoices {
            drift,
            ..ReadingChoices::default()
        };
        import_chosen(&path, &choices, None).unwrap()
    };
    let said = |r: &Recording| {
        let all = r
            .warnings
            .iter()
            .filter(|w| w.kind == WarningKind::Integrated);
        all.map(|w| w.message.clone())
            .collect::<Vec<_>>()
            .join("; ")
    };
    let plain = read(DriftRemoval::None);
    assert!((plain.proof_mass[4000] - 2e-3).abs() < 5e-5);
    assert!(
        said(&plain).contains("no drift is taken out"),
        "{}",
        said(&plain)
    );
    for drift in [
        DriftRemoval::Mean,
        DriftRemoval::Line,
        DriftRemoval::HighPass { corner: None },
    ] {
        let r = read(drift);
        for (t, x) in r.time.iter().zip(&r.proof_mass).skip(400).take(3200) {
            let expected = (w * t).sin() / w * 1e-3;
            assert!((x - expected).abs() < 1e-6, "{drift:?} {t}: {x} {expected}");
        }
        assert!(
            said(&r).contains("taken out") && !said(&r).contains("no drift"),
            "{}",
            said(&r)
        );
    }
}
