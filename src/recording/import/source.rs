//! What is in a file: a text, tables of a known format, or files in an archive.

use std::borrow::Cow;

use super::raw_text::text_of;
use crate::recording::error::{ImportError, ImportWarning, WarningKind};
use crate::recording::formats::raw_table::RawTable;
use crate::recording::formats::{self, FormatContent, HEAD_BYTES};

/// Archives within archives that are opened.
const MAX_DEPTH: usize = 4;

/// A part of a file that may be a recording.
#[derive(Debug)]
pub struct Part {
    /// Path inside the file; empty where the file is the part.
    pub name: String,
    /// Name of the format, if it is not text.
    pub format: Option<&'static str>,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Text(Vec<u8>),
    Table(RawTable),
}

impl Part {
    /// As text with delimiters.
    pub fn text(&self) -> Cow<'_, [u8]> {
        match &self.content {
            Content::Text(bytes) => Cow::Borrowed(bytes),
            Content::Table(table) => Cow::Owned(text_of(table, usize::MAX)),
        }
    }

    /// Its first rows as text, enough to see what the columns are.
    pub fn head(&self, rows: usize) -> Cow<'_, [u8]> {
        match &self.content {
            Content::Text(bytes) => Cow::Borrowed(bytes),
            Content::Table(table) => Cow::Owned(text_of(table, rows)),
        }
    }

    /// What the format had to say.
    pub fn notes(&self) -> Vec<ImportWarning> {
        let Content::Table(table) = &self.content else {
            return Vec::new();
        };
        let notes = table.notes.iter();
        notes
            .map(|note| ImportWarning::new(WarningKind::FormatNote, 1, None, note))
            .collect()
    }
}

/// Whether a file with these first bytes is opened here rather than read as text.
pub fn is_known(head: &[u8], name: &str) -> bool {
    formats::recognise(head, name).is_some()
}

/// The parts of a file.
///
/// # Errors
/// [`ImportError::Format`]: what is wrong, where, and what to do.
pub fn parts_of(file: &str, name: &str, bytes: Vec<u8>) -> Result<Vec<Part>, ImportError> {
    let mut parts = Vec::new();
    gather(file, ("", name), bytes, MAX_DEPTH, &mut parts)?;
    Ok(parts)
}

fn gather(
    file: &str,
    (path, name): (&str, &str),
    bytes: Vec<u8>,
    depth: usize,
    parts: &mut Vec<Part>,
) -> Result<(), ImportError> {
    let head = bytes.get(..bytes.len().min(HEAD_BYTES)).unwrap_or_default();
    let Some(format) = formats::recognise(head, name) else {
        parts.push(Part {
            name: path.to_owned(),
            format: None,
            content: Content::Text(bytes),
        });
        return Ok(());
    };
    let inside = |inner: &str| {
        if path.is_empty() {
            inner.to_owned()
        } else {
            format!("{path}/{inner}")
        }
    };
    let content = format
        .read(file, &bytes)
        .map_err(|error| ImportError::Format(error.to_string().into()))?;
    drop(bytes);
    let too_deep = || {
        ImportError::Format(
        format!("{file}: archives lie within archives here more than {MAX_DEPTH} deep; unpack the file and open the recording in it").into(),
    )
    };
    match content {
        FormatContent::Tables(tables) => {
            for table in tables {
                parts.push(Part {
                    name: inside(&table.name),
                    format: Some(format.name()),
                    content: Content::Table(table),
                });
            }
        }
        FormatContent::Inner { name, bytes } => {
            let depth = depth.checked_sub(1).ok_or_else(too_deep)?;
            // A wrapped file is named by itself only where it needs a name.
            gather(file, (path, &name), bytes, depth, parts)?;
        }
        FormatContent::Several(files) => {
            let depth = depth.checked_sub(1).ok_or_else(too_deep)?;
            for (name, bytes) in files {
                gather(file, (&inside(&name), &name), bytes, depth, parts)?;
            }
        }
    }
    Ok(())
}
