//! A trial as files: recordings as CSV, and the truth in a file of its own.

use std::fs;
use std::path::{Path, PathBuf};

use super::draw::{Recordings, TrialError};
use super::truth::Envelope;
use crate::atomic_write::write_atomically;
use crate::recording::Recording;
use crate::recording::csv::write_recording;

/// The files of a trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CaseFiles {
    /// Recordings to fit.
    pub train: Vec<PathBuf>,
    /// Held-out recordings.
    pub held_out: Vec<PathBuf>,
}

fn failed(path: &Path, error: impl std::fmt::Display) -> TrialError {
    TrialError::Write {
        path: path.display().to_string(),
        reason: error.to_string(),
    }
}

/// Writes the recordings into `folder`, which is made: `train-1.csv` ...,
/// `held-out-1.csv` ....
///
/// # Errors
/// [`TrialError::Write`] with the file that could not be written.
pub fn write_case(folder: &Path, recordings: &Recordings) -> Result<CaseFiles, TrialError> {
    fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
    let write = |group: &str, list: &[std::sync::Arc<Recording>]| {
        let mut paths = Vec::with_capacity(list.len());
        for (i, recording) in list.iter().enumerate() {
            let path = folder.join(format!("{group}-{}.csv", i + 1));
            let mut bytes: Vec<u8> = Vec::new();
            write_recording(&mut bytes, recording).map_err(|e| failed(&path, e))?;
            write_atomically(&path, &bytes).map_err(|e| failed(&path, e))?;
            paths.push(path);
        }
        Ok::<_, TrialError>(paths)
    };
    Ok(CaseFiles {
        train: write("train", &recordings.train)?,
        held_out: write("held-out", &recordings.held_out)?,
    })
}

/// Writes the text of a preset into the file `path`.
///
/// # Errors
/// [`TrialError::Write`].
pub fn write_preset(path: &Path, text: &str) -> Result<(), TrialError> {
    write_atomically(path, text.as_bytes()).map_err(|e| failed(path, e))
}

/// Opens the envelope into the file `path`; its SHA-256 is the seal.
///
/// # Errors
/// [`TrialError::Write`].
pub fn write_truth(path: &Path, envelope: Envelope) -> Result<(), TrialError> {
    let (_, text) = envelope.open();
    write_atomically(path, text.as_bytes()).map_err(|e| failed(path, e))
}
