//! Why a lesson cannot be used.

use thiserror::Error;

use super::super::text::TextError;
use crate::model::preset::toml_fault::short_reason;

/// A lesson that cannot be used, with the place to mend.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{file}, line {line}, column {column}: {reason}")]
pub struct LessonError {
    /// The file as it was named.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong, and what to do.
    pub reason: String,
}

/// A text being read, for errors that name their place.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// The error of what begins at byte `start`.
    pub(super) fn fault(&self, start: usize, reason: impl Into<String>) -> LessonError {
        let start = start.min(self.text.len());
        // A span begins at a character, but nothing relies on it.
        let is_start = |i: &usize| self.text.is_char_boundary(*i);
        let start = (0..=start).rev().find(is_start).unwrap_or(0);
        let before = self.text.get(..start).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let in_line = before.get(line_start..).unwrap_or_default();
        LessonError {
            file: self.file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: in_line.chars().count() + 1,
            reason: short_reason(&reason.into()),
        }
    }

    /// The error of a text that begins at byte `start`.
    pub(super) fn text_fault(&self, start: usize, error: &TextError) -> LessonError {
        self.fault(start, error.to_string())
    }
}
