//! Real recordings, from the folder that `IMPACTSCOPE_RECORDINGS` names; skipped without.

use std::path::PathBuf;

use impactscope::recording::csv::{import_auto, preview};
use impactscope::recording::features::{FeatureOptions, recording_features};
use impactscope::recording::{Channel, ImportWarning, Recording, WarningKind};

fn real_files() -> Vec<PathBuf> {
    let Some(folder) = std::env::var_os("IMPACTSCOPE_RECORDINGS").map(PathBuf::from) else {
        println!("skipped: IMPACTSCOPE_RECORDINGS names no folder of recordings");
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            // What is expected below is known of these.
            name.ends_with(".csv") && (name.starts_with("faller") || name.starts_with("oscillator"))
        })
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no CSV in {}", folder.display());
    files
}

fn read(path: &std::path::Path) -> Recording {
    import_auto(path, None).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn real_files_read_without_a_dialog() {
    for path in real_files() {
        let seen = preview(&path).unwrap();
        assert!(
            !seen.needs_dialog(),
            "{}: {:?}",
            path.display(),
            seen.ambiguities
        );
        let r = read(&path);
        // Some begin at 1 s, which is said.
        let said = |w: &ImportWarning| w.kind == WarningKind::TimeOrigin;
        let as_read = r.warnings.iter().all(said);
        assert!(as_read, "{}: {:?}", r.name, r.warnings);
        assert_eq!(r.time[0], 0.0);
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        assert_eq!(r.len(), lines - 1, "{}", r.name);
        assert!(r.voltage.is_none() && r.cantilever.is_none());
        let rate = r.sampling_rate();
        let expected = if r.name.starts_with("faller") {
            15.0
        } else {
            100.0
        };
        assert!(
            (rate / expected - 1.0).abs() < 0.02,
            "{}: {rate} Hz",
            r.name
        );
        let (low, high) = r
            .proof_mass
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                (l.min(*x), h.max(*x))
            });
        assert!(
            low > 0.0 && high < 50.0 && high - low > 0.05,
            "{}: {low} to {high} m",
            r.name
        );
    }
}

#[test]
fn real_files_have_plausible_noise_and_no_invented_contact() {
    for path in real_files() {
        let r = read(&path);
        let noise = r.estimate_noise(Channel::ProofMass).unwrap();
        println!("{}: {noise:?}", r.name);
        let bounds = if r.name.starts_with("faller") {
            1e-3..0.3
        } else {
            2e-5..2e-3
        };
        assert!(bounds.contains(&noise.sigma), "{}: {noise:?}", r.name);
        let features = recording_features(&r, &FeatureOptions::default());
        assert!(
            features.contact_level.is_err(),
            "{}: {:?}",
            r.name,
            features.contact_level
        );
        assert!(features.steady.is_err());
        println!("{}: {}", r.name, features.contact_level.unwrap_err());
    }
}
