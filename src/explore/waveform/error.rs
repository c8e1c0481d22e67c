//! Why a waveform cannot be edited, varied, read or written.

use std::path::PathBuf;

use thiserror::Error;

use crate::model::drive::DriveError;

/// What is wrong, where, and what to do.
#[derive(Debug, Error)]
pub enum WaveformError {
    /// A value of the drive is out of range.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// A handle that does not exist, or cannot go.
    #[error("{0}")]
    Handle(String),
    /// A number that this drive does not have, or that cannot take this value.
    #[error("{drive} has no \"{id}\" that could be varied; it has {known}")]
    NoParameter {
        drive: String,
        id: String,
        known: String,
    },
    /// A drive that does not repeat.
    #[error(
        "{drive} has no period; {action} a sine, square, triangle, ramped or drawn waveform, or a table that repeats"
    )]
    NoPeriod { drive: String, action: &'static str },
    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        path: PathBuf,
        source: std::io::Error,
    },
    /// A file that is no waveform.
    #[error("{}: {reason}", path.display())]
    File { path: PathBuf, reason: String },
    /// What a function generator cannot take.
    #[error("{format}: {reason}")]
    Export {
        format: &'static str,
        reason: String,
    },
}

/// A drive in a message, in a few words.
pub(super) fn named(waveform: &crate::model::drive::Waveform) -> String {
    const SHOWN_CHARACTERS: usize = 40;
    let text = waveform.to_string();
    match text.char_indices().nth(SHOWN_CHARACTERS) {
        Some((end, _)) => format!("the drive {}...", &text[..end]),
        None => format!("the drive {text}"),
    }
}
