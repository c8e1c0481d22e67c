//! The rows of a segment.

use super::super::lines::Lines;
use super::header::{FileHeader, Role, SegmentHeader, number};
use crate::recording::error::visible;

/// Longest text of a cell in a note \[bytes\].
const MAX_CELL_BYTES: usize = 40;
/// Most comments kept for a note.
const MAX_COMMENTS: usize = 3;

/// Numbers of a segment, and what was no number.
#[derive(Debug)]
pub(super) struct Rows<'a> {
    /// One for each column of the header; those of text are empty. NaN where a cell is empty.
    pub columns: Vec<Vec<f64>>,
    /// Rows with a comment.
    pub comments: usize,
    /// The first of them.
    pub first_comments: Vec<&'a [u8]>,
    /// Cells of text where a number should be.
    bad: usize,
    /// The first: line, column, text.
    first_bad: Option<(usize, usize, &'a [u8])>,
}

/// Reads rows up to the next header, which is left to be read.
pub(super) fn read_rows<'a>(
    file: &FileHeader,
    header: &SegmentHeader,
    lines: &mut Lines<'a>,
) -> Rows<'a> {
    let roles: Vec<Role> = header.columns.iter().map(|column| column.role).collect();
    let decimal = file.decimal.unwrap_or(b'.');
    let mut rows = Rows {
        columns: vec![Vec::new(); roles.len()],
        comments: 0,
        first_comments: Vec::new(),
        bad: 0,
        first_bad: None,
    };
    while let Some(line) = lines.peek() {
        let first = line
            .split(|b| *b == file.separator)
            .next()
            .unwrap_or_default();
        // A header begins with a word; rows begin with a number or an empty cell.
        if first.first().is_some_and(u8::is_ascii_alphabetic) && number(first, decimal).is_none() {
            break;
        }
        if line.starts_with(b"***") {
            break;
        }
        lines.next();
        if !line.is_empty() && line != [file.separator] {
            rows.add(line, file.separator, decimal, &roles, lines.number());
        }
    }
    rows
}

impl<'a> Rows<'a> {
    fn add(
        &mut self,
        line: &'a [u8],
        separator: u8,
        decimal: u8,
        roles: &[Role],
        number_of: usize,
    ) {
        let mut cells = line.split(|b| *b == separator);
        for (index, (role, column)) in roles.iter().zip(&mut self.columns).enumerate() {
            let cell = cells.next().unwrap_or_default();
            if *role == Role::Comment {
                // A comment may hold the separator.
                if !cell.is_empty() {
                    self.comments += 1;
                    if self.first_comments.len() < MAX_COMMENTS {
                        self.first_comments.push(cell);
                    }
                }
                continue;
            }
            let value = match number(cell, decimal) {
                Some(value) if value.is_finite() => value,
                // LabVIEW writes NaN itself.
                Some(value) if value.is_nan() => f64::NAN,
                _ if cell.trim_ascii().is_empty() => f64::NAN,
                _ => {
                    self.bad += 1;
                    let shown = cell.get(..MAX_CELL_BYTES).unwrap_or(cell);
                    self.first_bad.get_or_insert((number_of, index + 1, shown));
                    f64::NAN
                }
            };
            column.push(value);
        }
    }

    /// What was left out.
    pub fn notes(&self, header: &SegmentHeader) -> Option<String> {
        let (line, column, cell) = self.first_bad?;
        let name = header
            .columns
            .get(column - 1)
            .map_or("", |c| c.name.as_str());
        Some(format!(
            "{} cells are no numbers (first: \"{}\" of \"{name}\", line {line}, column {column}); they are missing values.",
            self.bad,
            visible(&String::from_utf8_lossy(cell))
        ))
    }
}
