//! Rows of numbers, parsed in parallel pieces.

pub(in crate::recording::csv) mod layout;
pub(in crate::recording::csv) mod order;
mod parse;
pub(super) mod truncated_line;
mod widths;

use std::ops::Range;

use rayon::prelude::*;

use self::layout::{Layout, TIME_SLOT};
use self::parse::{MAX_MARKED_COLUMNS, Parsed, parse_piece};
use self::widths::Widths;
use crate::recording::csv::line::{cells, is_skipped, show};
use crate::recording::csv::number::marks::Evidence;
use crate::recording::csv::number::relative_time::{self, Zero};
use crate::recording::csv::text::{Progress, READ_SHARE, Text};
use crate::recording::error::ImportError;
use crate::recording::times::exact_time::ExactTime;
use crate::recording::times::rounding::Printed;

/// Size of one piece of text \[bytes\]: large against a line, small against a file.
const PIECE_BYTES: usize = 2 << 20;
/// One parsed piece: where it lies and how many rows it gave.
#[derive(Debug)]
struct Piece {
    range: Range<usize>,
    first_line: usize,
    first_row: usize,
}

/// All rows: columns t, V, xp, xc (`None` where not asked for).
#[derive(Debug)]
pub(in crate::recording::csv) struct Table {
    pub columns: [Option<Vec<f64>>; 4],
    /// Number of rows.
    pub rows: usize,
    /// Number of the line after the last one read.
    pub next_line: usize,
    /// How the times were written.
    pub printed: Printed,
    /// Cells of each slot that say that the reading was out of range.
    pub overrange: [usize; 4],
    /// Rows without a time that are text rather than numbers (headers, footers), the first of them.
    pub text_rows: Vec<usize>,
    /// Numbers of cells in the rows.
    pub widths: Widths,
    pieces: Vec<Piece>,
}

/// The rows to parse.
#[derive(Clone)]
pub(in crate::recording::csv) struct Part {
    /// Bytes of the text.
    pub range: Range<usize>,
    /// Number of the first line.
    pub first_line: usize,
}

impl Table {
    /// Parses a part of the text. Times count from `zero`.
    pub(in crate::recording::csv) fn parse(
        file: &str,
        text: &Text,
        part: Part,
        layout: &Layout,
        zero: &Zero,
        progress: Option<&Progress>,
    ) -> Result<Self, ImportError> {
        let Part { range, first_line } = part;
        let total = range.len().max(1);
        let ranges = split(text, range.clone());
        let time = layout.slots[TIME_SLOT];
        let mut table = Table {
            columns: layout.present.map(|wanted| wanted.then(Vec::new)),
            rows: 0,
            next_line: first_line,
            printed: Printed {
                unit: time.shift,
                factor: time.factor,
                ..Printed::NONE
            },
            overrange: [0; 4],
            text_rows: Vec::new(),
            widths: Widths::default(),
            pieces: Vec::with_capacity(ranges.len()),
        };
        // In batches, so that progress and cancelling stay with the caller's thread.
        for batch in ranges.chunks(4 * rayon::current_num_threads().max(1)) {
            let parsed: Vec<(Parsed, Result<(), ImportError>)> = batch
                .par_iter()
                .map(|piece| {
                    let parsed =
                        parse_piece(&text.bytes[piece.clone()], text.newline, layout, zero);
                    (parsed, text.check(file, piece.clone(), 1))
                })
                .collect();
            for (piece, (parsed, check)) in batch.iter().zip(parsed) {
                if check.is_err() {
                    // Again, now that the line number is known.
                    text.check(file, piece.clone(), table.next_line)?;
                }
                table.add(piece, parsed, total);
            }
            let done = batch.last().map_or(range.end, |piece| piece.end) - range.start;
            let share = READ_SHARE + (0.95 - READ_SHARE) * (done as f32 / total as f32);
            if progress.is_some_and(|go_on| !go_on(share)) {
                return Err(ImportError::Cancelled { file: file.into() });
            }
        }
        Ok(table)
    }

    fn add(&mut self, range: &Range<usize>, parsed: Parsed, total: usize) {
        let first_row = self.rows;
        self.pieces.push(Piece {
            range: range.clone(),
            first_line: self.next_line,
            first_row,
        });
        if first_row == 0 && parsed.rows > 0 {
            // The first piece says how many rows there will be.
            let expected = parsed.rows as f64 * total as f64 / range.len().max(1) as f64;
            for column in self.columns.iter_mut().flatten() {
                // A wrong guess or a lack of memory only costs copies later.
                let _ = column.try_reserve((expected * 1.02) as usize);
            }
        }
        self.rows += parsed.rows;
        self.printed.join(&parsed.printed);
        self.next_line += parsed.lines;
        self.widths.join(&parsed.widths, first_row);
        let text_rows = parsed.text_rows.iter().map(|row| first_row + row);
        self.text_rows.extend(text_rows);
        for (all, own) in self.overrange.iter_mut().zip(parsed.overrange) {
            *all += own;
        }
        for (all, own) in self.columns.iter_mut().zip(&parsed.columns) {
            if let Some(all) = all {
                all.extend_from_slice(own);
            }
        }
    }

    /// The text of the line that gave `row`, with its number.
    fn find<'t>(&self, text: &Text<'t>, layout: &Layout, row: usize) -> Option<(usize, &'t [u8])> {
        let at = self
            .pieces
            .partition_point(|piece| piece.first_row <= row)
            .checked_sub(1)?;
        let piece = self.pieces.get(at)?;
        text.split(&text.bytes[piece.range.clone()])
            .enumerate()
            .filter(|(_, line)| !is_skipped(line, layout.delimiter))
            .nth(row - piece.first_row)
            .map(|(i, line)| (piece.first_line + i, line))
    }

    /// Number of the line that gave `row`.
    pub(in crate::recording::csv) fn line_of(
        &self,
        text: &Text,
        layout: &Layout,
        row: usize,
    ) -> usize {
        self.find(text, layout, row)
            .map_or(self.next_line, |(line, _)| line)
    }

    /// Where the line of `row` starts in the text, and its number.
    pub(in crate::recording::csv) fn start_of(
        &self,
        text: &Text,
        layout: &Layout,
        row: usize,
    ) -> Option<(usize, usize)> {
        let (number, line) = self.find(text, layout, row)?;
        let offset = (line.as_ptr() as usize).checked_sub(text.bytes.as_ptr() as usize)?;
        Some((offset, number))
    }

    /// The time of a row with all its digits, in the file's unit.
    pub(in crate::recording::csv) fn exact_time_of(
        &self,
        text: &Text,
        layout: &Layout,
        row: usize,
    ) -> Option<ExactTime> {
        exact_time(self.find(text, layout, row)?.1, layout)
    }

    /// Number of cells of the line that gave `row`.
    pub(in crate::recording::csv) fn cells_of(
        &self,
        text: &Text,
        layout: &Layout,
        row: usize,
    ) -> usize {
        self.find(text, layout, row)
            .map_or(0, |(_, line)| cells(line, layout.delimiter).count())
    }

    /// Text of a cell, for a message.
    pub(in crate::recording::csv) fn cell_of(
        &self,
        text: &Text,
        layout: &Layout,
        row: usize,
        column: usize,
    ) -> String {
        self.find(text, layout, row)
            .and_then(|(_, line)| cells(line, layout.delimiter).nth(column).map(show))
            .unwrap_or_default()
    }
}

/// The first time in `rows` with all its digits, in the file's unit; `None` if there is none.
pub(in crate::recording::csv) fn first_time(
    rows: &[u8],
    text: &Text,
    layout: &Layout,
) -> Option<ExactTime> {
    text.split(rows)
        .filter(|line| !is_skipped(line, layout.delimiter))
        .find_map(|line| exact_time(line, layout))
}

/// The time in a line with all its digits, in the file's unit.
fn exact_time(line: &[u8], layout: &Layout) -> Option<ExactTime> {
    let column = layout.time?;
    let cell = cells(line, layout.delimiter).nth(column)?;
    let date = layout
        .date
        .and_then(|date| cells(line, layout.delimiter).nth(date));
    let unit = layout.slots[TIME_SLOT].shift;
    if layout.is_plain {
        return relative_time::exact_cell(cell, layout.comma, unit);
    }
    let plain = layout.time_text(cell, date.unwrap_or_default())?;
    relative_time::exact_cell(&plain, false, unit)
}

/// What the marks of all columns of `range` show.
pub(in crate::recording::csv) fn evidence(
    text: &Text,
    range: Range<usize>,
    delimiter: u8,
) -> Vec<Evidence> {
    let pieces: Vec<Vec<Evidence>> = split(text, range)
        .par_iter()
        .map(|piece| {
            let mut own: Vec<Evidence> = Vec::new();
            let lines = text.split(&text.bytes[piece.clone()]);
            for line in lines.filter(|line| !is_skipped(line, delimiter)) {
                for (i, cell) in cells(line, delimiter).take(MAX_MARKED_COLUMNS).enumerate() {
                    if own.len() <= i {
                        own.push(Evidence::default());
                    }
                    if let Some(evidence) = own.get_mut(i) {
                        evidence.note(cell);
                    }
                }
            }
            own
        })
        .collect();
    let mut all: Vec<Evidence> = Vec::new();
    for own in pieces {
        if all.len() < own.len() {
            all.resize(own.len(), Evidence::default());
        }
        for (joined, own) in all.iter_mut().zip(&own) {
            joined.join(own);
        }
    }
    all
}

/// Pieces of about [`PIECE_BYTES`] bytes that end with lines.
fn split(text: &Text, range: Range<usize>) -> Vec<Range<usize>> {
    let mut pieces = Vec::with_capacity(range.len() / PIECE_BYTES + 1);
    let mut start = range.start;
    while start < range.end {
        let near = (start + PIECE_BYTES).min(range.end);
        let end = memchr::memchr(text.newline, &text.bytes[near..range.end])
            .map_or(range.end, |p| near + p + 1);
        pieces.push(start..end);
        start = end;
    }
    pieces
}
