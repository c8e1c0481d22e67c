//! Recordings as they are named on the command line.

pub mod inspect;
mod options;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::anyhow;

pub use self::options::ReadingArguments;
use super::{Failure, terminal, wrong_command};
use crate::fit::Part;
use crate::recording::Recording;
use crate::recording::import::import_chosen;

/// Reads recordings as their headers and `reading` say. What the reader skipped or guessed goes to standard
/// error.
///
/// # Errors
/// The first file's that cannot be read; a recording that is named twice.
pub fn read(paths: &[PathBuf], reading: &ReadingArguments) -> Result<Vec<Arc<Recording>>, Failure> {
    let choices = reading.choices()?;
    let mut recordings: Vec<Arc<Recording>> = Vec::with_capacity(paths.len());
    for path in paths {
        let recording = import_chosen(path, &choices, None)?;
        for warning in &recording.warnings {
            terminal::warning(format_args!("{}: {}", path.display(), warning.message));
        }
        if let Some(first) = recordings.iter().find(|first| alike(first, &recording)) {
            return Err(wrong_command(anyhow!(
                "{} and {} are the same recording; it would count twice: name it once",
                described(first),
                described(&recording)
            )));
        }
        recordings.push(Arc::new(recording));
    }
    Ok(recordings)
}

/// Reads training and held-out recordings; without the latter, the last third of each recording is
/// held out.
///
/// # Errors
/// Those of [`read`]; a recording that is on both sides.
pub fn both_sides(
    train: &[PathBuf],
    held_out: &[PathBuf],
    reading: &ReadingArguments,
) -> Result<(Vec<Part>, Vec<Part>), Failure> {
    let recordings = read(train, reading)?;
    if held_out.is_empty() {
        return Ok(Part::sides(recordings, Vec::new()));
    }
    let held_out = read(held_out, reading)?;
    for (own, other) in recordings
        .iter()
        .flat_map(|r| held_out.iter().map(move |h| (r, h)))
    {
        if alike(own, other) {
            return Err(wrong_command(anyhow!(
                "--held-out {} is the same recording as {}, which is used for fitting; the check needs a recording that the fit has not seen",
                described(other),
                described(own)
            )));
        }
    }
    Ok(Part::sides(recordings, held_out))
}

/// Whether two files have the same bytes, whatever their names.
fn alike(a: &Recording, b: &Recording) -> bool {
    a.sha256.is_some() && a.sha256 == b.sha256
}

fn described(recording: &Recording) -> String {
    let path = recording.path.as_ref();
    path.map_or_else(|| recording.name.clone(), |p| p.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_counts_once() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let text = "t [s],xp [um]\n0,1\n1,2\n2,4\n3,1\n";
        let (a, copy) = (write("a.csv", text), write("copy.csv", text));
        let other = write("other.csv", "t [s],xp [um]\n0,1\n1,2\n2,4\n3,2\n");
        let as_they_are = ReadingArguments::default();
        let failure = read(&[a.clone(), copy.clone()], &as_they_are).unwrap_err();
        assert_eq!(failure.code, 2);
        assert!(failure.error.to_string().contains("copy.csv"));
        let Err(failure) = both_sides(&[other.clone(), a.clone()], &[copy], &as_they_are) else {
            panic!("fitted to a held-out recording");
        };
        assert_eq!(failure.code, 2);
        assert!(failure.error.to_string().contains("has not seen"));
        let (train, held_out) =
            both_sides(std::slice::from_ref(&a), &[other], &as_they_are).unwrap();
        assert_eq!((train[0].samples.len(), held_out[0].samples.len()), (4, 4));
        let (train, held_out) = both_sides(&[a], &[], &as_they_are).unwrap();
        assert_eq!((train[0].samples.len(), held_out[0].samples.len()), (2, 2));
    }
}
