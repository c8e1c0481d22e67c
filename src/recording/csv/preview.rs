//! What was understood of a file, for a dialog or at once for the import.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::columns::names::Role;
use super::columns::sample::ColumnSample;
use super::columns::{Question, Topic, several};
use super::settings::{ColumnChoice, ImportSettings};
use super::sniff::look;
use super::{read, text};
use crate::recording::error::{ImportError, ImportWarning};

/// Bytes looked at from the beginning of a file.
const HEAD_BYTES: usize = 256 << 10;
/// Bytes looked at in the middle and at the end, where the first comma of a decimal
/// number may be.
const PROBE_BYTES: usize = 16 << 10;

/// One of several recordings in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// What it is called in the file, or the lines where it stands.
    pub name: String,
    /// Its columns t, V, xp, xc, where recordings stand side by side.
    pub(super) columns: Option<[Option<ColumnChoice>; 4]>,
}

/// What was understood of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// File name or the name given for the bytes.
    pub name: String,
    /// Size of the file \[bytes\].
    pub size: u64,
    /// The instrument or program whose form the header has.
    pub written_by: Option<String>,
    /// Comments and free text before the header.
    pub comments: Vec<String>,
    /// Column names as written (with units); empty if there is no header.
    pub header: Vec<String>,
    /// Number of columns.
    pub columns: usize,
    /// The first rows of numbers, as text; at most 20.
    pub rows: Vec<Vec<String>>,
    /// The import that suggests itself. `time` and `proof_mass` are `None` where the
    /// user has to choose.
    pub settings: ImportSettings,
    /// What a user should confirm; empty if the file is clear.
    pub ambiguities: Vec<String>,
    /// What is worth saying if the import goes ahead as suggested.
    pub warnings: Vec<ImportWarning>,
    /// The recordings in the file, if it is known to hold several; empty if there is one.
    pub trials: Vec<Trial>,
    /// Whether the file itself is the text, so that delimiter and encoding can be chosen.
    pub is_text: bool,
    /// What must be decided before the import.
    pub(super) questions: Vec<Question>,
    /// What the columns look like.
    pub(super) samples: Vec<ColumnSample>,
}

impl Preview {
    /// Whether the file leaves a choice to the user.
    #[must_use]
    pub fn needs_dialog(&self) -> bool {
        !self.questions.is_empty() || !self.ambiguities.is_empty()
    }

    /// Why the file cannot be read as suggested, if so.
    #[must_use]
    pub fn problem(&self) -> Option<&ImportError> {
        self.questions.first().map(|question| &question.error)
    }

    /// Everything that must be decided before the file is read.
    pub fn problems(&self) -> impl Iterator<Item = &ImportError> {
        self.questions.iter().map(|question| &question.error)
    }

    /// Takes recording `number` (from 1) of those in the file.
    ///
    /// # Errors
    /// [`ImportError::NoSuchTrial`].
    pub fn choose_trial(&mut self, number: usize) -> Result<(), ImportError> {
        let count = self.trials.len();
        let chosen = number.checked_sub(1).and_then(|i| self.trials.get(i));
        if count > 0 {
            let trial = chosen.ok_or_else(|| ImportError::NoSuchTrial {
                file: self.name.clone().into(),
                trial: number,
                count,
            })?;
            if let Some(columns) = trial.columns.clone() {
                for (role, choice) in Role::ALL.into_iter().zip(columns) {
                    role.set(&mut self.settings, choice);
                }
            }
        }
        self.settings.trial = Some(number);
        self.settle(Topic::Trial);
        Ok(())
    }

    /// Whether a displacement or another motion was recognised.
    #[must_use]
    pub fn has_motion(&self) -> bool {
        self.settings.proof_mass.is_some() || !self.trials.is_empty()
    }

    /// Asks which of the recordings of a file with several is meant.
    pub(in crate::recording) fn offer_trials(&mut self, file: &str, names: Vec<String>) {
        let shown: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = several(file, &shown);
        self.ambiguities
            .push(format!("there are {} recordings in the file", names.len()));
        self.settle(Topic::Trial);
        let question = Question {
            topic: Topic::Trial,
            error,
        };
        self.questions.insert(0, question);
        let trial = |name| Trial {
            name,
            columns: None,
        };
        self.trials = names.into_iter().map(trial).collect();
    }

    /// Forgets the questions about a topic.
    pub(super) fn settle(&mut self, topic: Topic) {
        self.questions.retain(|question| question.topic != topic);
    }

    /// Looks for recordings below each other in the whole file, where nothing else is open.
    fn find_stacked(&mut self, file: &str, bytes: &[u8]) {
        if !self.questions.is_empty() {
            return;
        }
        let Ok(names) = read::stacked(file, bytes, &self.settings) else {
            return;
        };
        if names.len() < 2 {
            return;
        }
        let shown: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = several(file, &shown);
        self.ambiguities.push(format!(
            "there are {} recordings below each other",
            names.len()
        ));
        self.questions.push(Question {
            topic: Topic::Trial,
            error,
        });
        let trial = |name| Trial {
            name,
            columns: None,
        };
        self.trials = names.into_iter().map(trial).collect();
    }
}

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
        preview.find_stacked(&file, &head);
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
        preview.find_stacked(name, bytes);
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
        preview.find_stacked(name, bytes);
    }
    if preview.trials.is_empty() {
        preview.trials.push(Trial {
            name: preview.name.clone(),
            columns: None,
        });
    }
    Ok(preview.trials)
}
