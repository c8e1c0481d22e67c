//! Recordings as they are named on the command line.

mod combine;
pub mod inspect;
mod options;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::anyhow;

pub use self::options::ReadingArguments;
use super::{Failure, terminal, wrong_command};
use crate::fit::Part;
use crate::recording::Recording;

/// Reads recordings as their headers and `reading` say, put together where it says so. What the reader skipped
/// or guessed goes to standard error.
///
/// # Errors
/// The first file's that cannot be read; a recording that is named twice.
pub fn read(paths: &[PathBuf], reading: &ReadingArguments) -> Result<Vec<Arc<Recording>>, Failure> {
    let choices = reading.choices()?;
    let (combine, which) = reading.combine()?;
    for (i, path) in paths.iter().enumerate() {
        if let Some(first) = paths.iter().take(i).find(|first| same_bytes(first, path)) {
            return Err(wrong_command(anyhow!(
                "{} and {} are the same recording; it would count twice: name it once",
                first.display(),
                path.display()
            )));
        }
    }
    let mut all = Vec::with_capacity(paths.len());
    for group in combine.groups(paths).map_err(wrong_command)? {
        for recording in combine.read(&group, &choices, which)? {
            let label = match &group[..] {
                [path] => path.display().to_string(),
                _ => recording.name.clone(),
            };
            for warning in &recording.warnings {
                terminal::warning(format_args!("{label}: {}", warning.message));
            }
            all.push(Arc::new(recording));
        }
    }
    Ok(all)
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
    let others = read(held_out, reading)?;
    for (used, other) in train
        .iter()
        .flat_map(|own| held_out.iter().map(move |other| (own, other)))
    {
        if same_bytes(used, other) {
            return Err(wrong_command(anyhow!(
                "--held-out {} is the same recording as {}, which is used for fitting; the check needs a recording that the fit has not seen",
                other.display(),
                used.display()
            )));
        }
    }
    Ok(Part::sides(recordings, others))
}

/// Whether two files have the same bytes, whatever their names. A file that cannot be read is no other.
fn same_bytes(a: &Path, b: &Path) -> bool {
    let size = |path: &Path| std::fs::metadata(path).ok().map(|about| about.len());
    if size(a).is_none() || size(a) != size(b) {
        return false;
    }
    match (std::fs::read(a), std::fs::read(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
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
