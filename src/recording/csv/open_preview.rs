//! Looks at a file: what it seems to be, and the recordings in it.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::columns::{Question, Topic, several};
use super::preview::{Preview, Trial};
use super::sniff::look;
use super::{read, text};
use crate::recording::error::ImportError;

/// Bytes looked at from the beginning of a file.
const HEAD_BYTES: usize = 256 << 10;
/// Bytes looked at in the middle and at the end, where the first comma of a decimal
/// number may be.
const PROBE_BYTES: usize = 16 << 10;

/// Looks at a file's beginning, middle and end, however long it is. Recordings below each other are
/// found in short files; [`trials`] finds them in any.
///
/// # Errors
/// [`ImportError`] if it is not a file of text with rows of numbers.
pub fn preview(path: &Path) -> Result<Preview, ImportError> {
    let file = path.display().to_string();
    let (mut input, size) = text::open(path)?;
    let mut part = |from: u64, length: usize| {
        let mut bytes = Vec::new();
        input
            .seek(SeekFrom::Start(from))
            .and_then(|_| {
                Read::by_ref(&mut input)
                    .take(length as u64)
                    .read_to_end(&mut bytes)
            })
            .map(|_| bytes)
            .map_err(|error| ImportError::Unreadable {
                file: file.clone().into(),
                reason: error.to_string().into(),
            })
    };
    let head = part(0, HEAD_BYTES)?;
    let probes = if size > (HEAD_BYTES + 2 * PROBE_BYTES) as u64 {
        vec![
            part(size / 2, PROBE_BYTES)?,
            part(size - PROBE_BYTES as u64, PROBE_BYTES)?,
        ]
    } else {
        Vec::new()
    };
    let probes: Vec<&[u8]> = probes.iter().map(Vec::as_slice).collect();
    let is_whole = head.len() as u64 >= size;
    let mut preview = look(&file, &head, !is_whole, &probes)?;
    if is_whole {
        find_stacked(&mut preview, &file, &head);
    }
    preview.size = size;
    preview.name = text::short_name(path);
    Ok(preview)
}

/// [`preview`] of bytes in memory.
///
/// # Errors
/// As [`preview`].
pub fn preview_bytes(name: &str, bytes: &[u8]) -> Result<Preview, ImportError> {
    let mut preview = preview_head(name, bytes)?;
    if bytes.len() <= HEAD_BYTES {
        find_stacked(&mut preview, name, bytes);
    }
    Ok(preview)
}

/// [`preview_bytes`] without the search for recordings below each other, which the import does itself.
pub(super) fn preview_head(name: &str, bytes: &[u8]) -> Result<Preview, ImportError> {
    let n = bytes.len();
    let head = bytes.get(..n.min(HEAD_BYTES)).unwrap_or(bytes);
    let part = |from: usize| bytes.get(from..from + PROBE_BYTES).unwrap_or_default();
    let probes: Vec<&[u8]> = if n > HEAD_BYTES + 2 * PROBE_BYTES {
        vec![part(n / 2), part(n - PROBE_BYTES)]
    } else {
        Vec::new()
    };
    let mut preview = look(name, head, head.len() < n, &probes)?;
    preview.size = n as u64;
    Ok(preview)
}

/// The recordings in a file: side by side, or below each other. One if there is only one.
///
/// # Errors
/// As [`preview`], and if something else must be decided before the rows can be read.
pub fn trials(name: &str, bytes: &[u8]) -> Result<Vec<Trial>, ImportError> {
    let mut preview = preview_head(name, bytes)?;
    if preview.trials.is_empty() {
        if let Some(problem) = preview.problem() {
            return Err(problem.clone());
        }
        find_stacked(&mut preview, name, bytes);
    }
    if preview.trials.is_empty() {
        preview.trials.push(Trial {
            name: preview.name.clone(),
            columns: None,
        });
    }
    Ok(preview.trials)
}

/// Looks for recordings below each other in the whole file, where nothing else is open.
fn find_stacked(preview: &mut Preview, file: &str, bytes: &[u8]) {
    if !preview.questions.is_empty() {
        return;
    }
    let Ok(names) = read::stacked(file, bytes, &preview.settings) else {
        return;
    };
    if names.len() < 2 {
        return;
    }
    let shown: Vec<&str> = names.iter().map(String::as_str).collect();
    let error = several(file, &shown);
    let short = format!("there are {} recordings below each other", names.len());
    preview.ambiguities.push(short.clone());
    preview.questions.push(Question {
        topic: Topic::Trial,
        error,
        short: Some(short),
    });
    let trial = |name| Trial {
        name,
        columns: None,
    };
    preview.trials = names.into_iter().map(trial).collect();
}
