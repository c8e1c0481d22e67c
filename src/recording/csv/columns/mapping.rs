//! What was made of a header, what is still open, and how it is said.

use super::names::Role;
use super::sample::ColumnSample;
use super::trials::TrialColumns;
use crate::recording::csv::settings::SampleClock;
use crate::recording::error::{ImportError, ImportWarning, WarningKind};

/// What a question is about, so that an answer is known for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording::csv) enum Topic {
    /// The column of a role.
    Column(Role),
    /// Its unit.
    Unit(Role),
    /// What a unit of another quantity stands for.
    Scale(Role),
    /// The sampling rate.
    Clock,
    /// Which recording of several.
    Trial,
    /// The decimal mark.
    Decimal,
}

/// Something that the file leaves open.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::recording::csv) struct Question {
    pub topic: Topic,
    pub error: ImportError,
    /// How it stands among the ambiguities, if it does.
    pub short: Option<String>,
}

/// What was made of a header.
#[derive(Debug, Default)]
pub(in crate::recording::csv) struct Mapping {
    pub warnings: Vec<ImportWarning>,
    /// What a person should confirm.
    pub ambiguities: Vec<String>,
    /// What must be decided before the file is read.
    pub questions: Vec<Question>,
    /// Recordings side by side; none if there is one.
    pub trials: Vec<TrialColumns>,
}

impl Mapping {
    pub(super) fn warn(&mut self, kind: WarningKind, line: Option<usize>, message: String) {
        self.warnings
            .push(ImportWarning::new(kind, 1, line, &message));
    }

    /// A guess that a person should confirm and that is said otherwise.
    pub(super) fn guess(&mut self, kind: WarningKind, line: usize, message: String) {
        self.ambiguities.push(message.clone());
        self.warn(kind, Some(line), message);
    }

    /// Something that must be decided.
    pub(in crate::recording::csv) fn ask(
        &mut self,
        topic: Topic,
        error: ImportError,
        short: String,
    ) {
        self.ambiguities.push(short.clone());
        self.questions.push(Question {
            topic,
            error,
            short: Some(short),
        });
    }
}

/// What is known of a table besides its names.
pub(in crate::recording::csv) struct TableFacts<'a> {
    pub file: &'a str,
    /// Line of the header, or of the first row.
    pub line: usize,
    pub samples: &'a [ColumnSample],
    /// Sampling clock that the lines above name.
    pub clock: Option<SampleClock>,
    /// Units of the header's second row that are unknown, with their columns.
    pub unknown_units: &'a [(usize, String)],
    /// Whether lengths and times without a unit are SI: the program that wrote the file says no units.
    pub is_si: bool,
}

/// Names shown in a message.
const MAX_SHOWN_NAMES: usize = 12;

/// The error for a file with several recordings.
pub fn several(file: &str, names: &[&str]) -> ImportError {
    let mut shown: Vec<String> = names
        .iter()
        .take(MAX_SHOWN_NAMES)
        .enumerate()
        .map(|(i, name)| format!("{}: {}", i + 1, shortened(name)))
        .collect();
    if names.len() > shown.len() {
        shown.push("...".to_owned());
    }
    ImportError::SeveralRecordings {
        file: file.into(),
        count: names.len(),
        names: shown.join(", ").into(),
    }
}

fn shortened(name: &str) -> String {
    name.trim().chars().take(40).collect()
}

/// The header as a sentence shows it, cut if it is long.
pub(in crate::recording::csv) fn found_names(cells: &[String]) -> String {
    let mut names: Vec<String> = cells
        .iter()
        .take(MAX_SHOWN_NAMES)
        .map(|cell| format!("\"{}\"", shortened(cell)))
        .collect();
    if cells.len() > names.len() {
        names.push("...".to_owned());
    }
    names.join(", ")
}
