//! The rows of a segment, in parallel.

use rayon::prelude::*;

use super::super::lines::Lines;
use super::header::{FileHeader, Role, SegmentHeader, number};
use crate::recording::error::visible;

/// Longest text of a cell in a note \[bytes\].
const MAX_CELL_BYTES: usize = 40;
/// Most comments kept for a note.
const MAX_COMMENTS: usize = 3;
/// Bytes of text that are one piece of work: enough that starting a thread does not count.
const PIECE_BYTES: usize = 1 << 20;

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
    /// The first of them.
    first_bad: Option<BadCell<'a>>,
}

/// A cell that is no number.
#[derive(Debug, Clone, Copy)]
struct BadCell<'a> {
    /// Lines before it in its piece; at last, its line from 1.
    line: usize,
    column: usize,
    text: &'a [u8],
}

/// How rows are split into cells.
#[derive(Debug, Clone, Copy)]
struct Cells<'h> {
    separator: u8,
    decimal: u8,
    roles: &'h [Role],
}

/// Reads rows up to the next header, which is left to be read.
pub(super) fn read_rows<'a>(
    file: &FileHeader,
    header: &SegmentHeader,
    lines: &mut Lines<'a>,
) -> Rows<'a> {
    let roles: Vec<Role> = header.columns.iter().map(|column| column.role).collect();
    let cells = Cells {
        separator: file.separator,
        decimal: file.decimal.unwrap_or(b'.'),
        roles: &roles,
    };
    let rest = lines.rest();
    let (end, count) = cells.end_of_rows(rest);
    let first_line = lines.number() + 1;
    lines.skip_over(end, count);
    let pieces = pieces(rest.get(..end).unwrap_or_default());
    let read: Vec<Rows> = pieces.par_iter().map(|piece| cells.read(piece)).collect();
    joined(read, &pieces, first_line, roles.len())
}

/// The bytes in pieces of whole lines.
fn pieces(block: &[u8]) -> Vec<&[u8]> {
    let mut pieces = Vec::new();
    let mut rest = block;
    while !rest.is_empty() {
        let after = rest.get(PIECE_BYTES..).unwrap_or_default();
        let end = after.iter().position(|b| *b == b'\n');
        let end = end.map_or(rest.len(), |end| PIECE_BYTES + end + 1);
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
    }
    pieces
}

/// All pieces as one; a column at a time, so that the numbers are not held twice.
fn joined<'a>(
    mut read: Vec<Rows<'a>>,
    pieces: &[&[u8]],
    first_line: usize,
    columns: usize,
) -> Rows<'a> {
    let mut all = Rows::new(columns);
    let mut line = first_line;
    for (rows, piece) in read.iter().zip(pieces) {
        all.comments += rows.comments;
        all.first_comments.extend(&rows.first_comments);
        all.first_comments.truncate(MAX_COMMENTS);
        all.bad += rows.bad;
        if let (None, Some(bad)) = (all.first_bad, rows.first_bad) {
            all.first_bad = Some(BadCell {
                line: line + bad.line,
                ..bad
            });
        }
        if all.first_bad.is_none() {
            line += piece.iter().filter(|b| **b == b'\n').count();
        }
    }
    for (index, column) in all.columns.iter_mut().enumerate() {
        let parts = read
            .iter_mut()
            .filter_map(|rows| rows.columns.get_mut(index));
        let parts: Vec<Vec<f64>> = parts.map(std::mem::take).collect();
        column.reserve_exact(parts.iter().map(Vec::len).sum());
        parts.iter().for_each(|part| column.extend_from_slice(part));
    }
    all
}

impl Cells<'_> {
    /// Where the rows end, and how many lines they are. A header begins with a word; rows begin with
    /// a number or an empty cell.
    fn end_of_rows(&self, rest: &[u8]) -> (usize, usize) {
        let (mut at, mut count) = (0, 0);
        while let Some(line) = rest.get(at..).filter(|line| !line.is_empty()) {
            let starts = |b: &u8| b.is_ascii_alphabetic() || *b == b'*';
            if line.first().is_some_and(starts) {
                let first = line.split(|b| *b == self.separator || *b == b'\n').next();
                if number(first.unwrap_or_default(), self.decimal).is_none() {
                    break;
                }
            }
            count += 1;
            match line.iter().position(|b| *b == b'\n') {
                Some(end) => at += end + 1,
                None => at = rest.len(),
            }
        }
        (at, count)
    }

    fn read<'a>(&self, piece: &'a [u8]) -> Rows<'a> {
        let mut rows = Rows::new(self.roles.len());
        for (index, line) in Lines::new(piece).enumerate() {
            if !line.is_empty() && line != [self.separator] {
                self.add(&mut rows, line, index);
            }
        }
        rows
    }

    fn add<'a>(&self, rows: &mut Rows<'a>, line: &'a [u8], index: usize) {
        let mut cells = line.split(|b| *b == self.separator);
        let columns = self.roles.iter().zip(&mut rows.columns).enumerate();
        for (place, (role, column)) in columns {
            let cell = cells.next().unwrap_or_default();
            if *role == Role::Comment {
                if !cell.is_empty() {
                    rows.comments += 1;
                    if rows.first_comments.len() < MAX_COMMENTS {
                        rows.first_comments.push(cell);
                    }
                }
                continue;
            }
            let value = match number(cell, self.decimal) {
                Some(value) if value.is_finite() => value,
                // LabVIEW writes NaN itself.
                Some(value) if value.is_nan() => f64::NAN,
                _ if cell.trim_ascii().is_empty() => f64::NAN,
                _ => {
                    rows.bad += 1;
                    rows.first_bad.get_or_insert(BadCell {
                        line: index,
                        column: place + 1,
                        text: cell.get(..MAX_CELL_BYTES).unwrap_or(cell),
                    });
                    f64::NAN
                }
            };
            column.push(value);
        }
    }
}

impl Rows<'_> {
    fn new(columns: usize) -> Self {
        Self {
            columns: vec![Vec::new(); columns],
            comments: 0,
            first_comments: Vec::new(),
            bad: 0,
            first_bad: None,
        }
    }

    /// What was left out.
    pub fn notes(&self, header: &SegmentHeader) -> Option<String> {
        let BadCell { line, column, text } = self.first_bad?;
        let name = header
            .columns
            .get(column - 1)
            .map_or("", |c| c.name.as_str());
        Some(format!(
            "{} cells are no numbers (first: \"{}\" of \"{name}\", line {line}, column {column}); they are missing values.",
            self.bad,
            visible(&String::from_utf8_lossy(text))
        ))
    }
}
