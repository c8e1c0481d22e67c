//! Why a file of a known format could not be read.

use thiserror::Error;

use crate::recording::error::FileText;

/// Why a file of a known format could not be read. Each message names the file, the place and what
/// to do. Lines count from 1, bytes from 0.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs)] // The fields are the file, the place and the offending part.
pub enum FormatError {
    #[error(
        "{file}: the {format} file ends at byte {offset}, in the middle of {what}; copy or export it again"
    )]
    Truncated {
        file: FileText,
        format: &'static str,
        offset: usize,
        what: FileText,
    },
    #[error("{file}, byte {offset}: {what} of this {format} file is not valid; export it again")]
    Malformed {
        file: FileText,
        format: &'static str,
        offset: usize,
        what: FileText,
    },
    #[error("{file}, line {line}: {what}; export it again as {format}, or as CSV text")]
    MalformedLine {
        file: FileText,
        format: &'static str,
        line: usize,
        what: FileText,
    },
    #[error("{file}: the {format} file cannot be read ({reason}); export it again")]
    Unreadable {
        file: FileText,
        format: &'static str,
        reason: FileText,
    },
    #[error("{file}: {what}; {remedy}")]
    Unsupported {
        file: FileText,
        what: FileText,
        remedy: FileText,
    },
    #[error(
        "{file}: the {format} file has no column of numbers that could be a recording ({found}); save the recorded signals as plain arrays of numbers"
    )]
    NoNumbers {
        file: FileText,
        format: &'static str,
        found: FileText,
    },
    #[error(
        "{file}: the {format} file unpacks to more than {limit_mb} MB; unpack it and split the recording"
    )]
    TooLarge {
        file: FileText,
        format: &'static str,
        limit_mb: u64,
    },
}

/// The file and the format that errors name.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FileContext<'a> {
    /// The file, as the user knows it.
    pub file: &'a str,
    /// The format's name.
    pub format: &'static str,
}

impl FileContext<'_> {
    /// The bytes end inside `what`.
    pub fn truncated(&self, offset: usize, what: impl Into<String>) -> FormatError {
        FormatError::Truncated {
            file: self.file.into(),
            format: self.format,
            offset,
            what: what.into().into(),
        }
    }

    /// `what` at `offset` cannot be.
    pub fn malformed(&self, offset: usize, what: impl Into<String>) -> FormatError {
        FormatError::Malformed {
            file: self.file.into(),
            format: self.format,
            offset,
            what: what.into().into(),
        }
    }

    /// A line of text that does not fit; `what` is a clause.
    pub fn malformed_line(&self, line: usize, what: impl Into<String>) -> FormatError {
        FormatError::MalformedLine {
            file: self.file.into(),
            format: self.format,
            line,
            what: what.into().into(),
        }
    }

    /// Another library's reason.
    pub fn unreadable(&self, reason: impl std::fmt::Display) -> FormatError {
        FormatError::Unreadable {
            file: self.file.into(),
            format: self.format,
            reason: reason.to_string().into(),
        }
    }

    /// A valid file that holds something else than recordings.
    pub fn unsupported(&self, what: impl Into<String>, remedy: impl Into<String>) -> FormatError {
        FormatError::Unsupported {
            file: self.file.into(),
            what: what.into().into(),
            remedy: remedy.into().into(),
        }
    }

    /// No column of numbers; `found` says what there is.
    pub fn no_numbers(&self, found: impl Into<String>) -> FormatError {
        FormatError::NoNumbers {
            file: self.file.into(),
            format: self.format,
            found: found.into().into(),
        }
    }

    /// Unpacked bytes beyond `limit`.
    pub fn too_large(&self, limit: u64) -> FormatError {
        FormatError::TooLarge {
            file: self.file.into(),
            format: self.format,
            limit_mb: limit >> 20,
        }
    }
}
