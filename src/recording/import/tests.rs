//! The door on wrapped, binary and plain files.

use std::io::Write;
use std::path::PathBuf;

use super::*;
use crate::recording::Channel;

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
