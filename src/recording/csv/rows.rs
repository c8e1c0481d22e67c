//! Rows of numbers, parsed in parallel pieces.

use std::ops::Range;

use rayon::prelude::*;

use super::line::{cell_end, cells, is_skipped, show};
use super::names::unit_shift;
use super::number;
use super::settings::{Decimal, ImportSettings};
use super::text::{Progress, READ_SHARE, Text};
use crate::recording::error::ImportError;

/// Size of one piece of text \[bytes\]: large against a line, small against a file.
const PIECE_BYTES: usize = 2 << 20;

/// Which columns to read, and as what.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub delimiter: u8,
    /// Whether an unquoted number may have a decimal comma.
    pub comma: bool,
    /// For each column up to the last needed: its (slot, power of ten) pairs. Slots
    /// are t, V, xp, xc.
    columns: Vec<Vec<(usize, i32)>>,
    present: [bool; 4],
}

impl Layout {
    pub(super) fn new(file: &str, settings: &ImportSettings) -> Result<Self, ImportError> {
        let line = settings.skip_lines;
        let chosen = [
            (settings.time.as_ref(), "s", "time", "s, ms or us"),
            (settings.voltage.as_ref(), "V", "voltage", "V or mV"),
            (
                settings.proof_mass.as_ref(),
                "m",
                "displacement",
                "m, mm, um or nm",
            ),
            (
                settings.cantilever.as_ref(),
                "m",
                "displacement",
                "m, mm, um or nm",
            ),
        ];
        let found = || "the chosen columns".to_owned();
        if settings.time.is_none() {
            return Err(ImportError::NoTimeColumn {
                file: file.to_owned(),
                line: line.max(1),
                found: found(),
            });
        }
        if settings.proof_mass.is_none() {
            return Err(ImportError::NoPositionColumn {
                file: file.to_owned(),
                line: line.max(1),
                found: found(),
            });
        }
        let mut columns: Vec<Vec<(usize, i32)>> = Vec::new();
        let mut present = [false; 4];
        for (slot, (choice, base, quantity, expected)) in chosen.into_iter().enumerate() {
            let Some(choice) = choice else { continue };
            let shift = unit_shift(&choice.unit, base).ok_or_else(|| ImportError::UnknownUnit {
                file: file.to_owned(),
                line: line.max(1),
                column: choice.index.saturating_add(1),
                unit: choice.unit.clone(),
                quantity: quantity.to_owned(),
                expected: expected.to_owned(),
            })?;
            // A remembered setting may be nonsense; no file has so many columns.
            let index = choice.index.min(1 << 16);
            if columns.len() <= index {
                columns.resize(index + 1, Vec::new());
            }
            columns[index].push((slot, shift));
            present[slot] = true;
        }
        let delimiter = settings.delimiter.byte();
        Ok(Self {
            delimiter,
            comma: settings.decimal == Decimal::Comma && delimiter != b',',
            columns,
            present,
        })
    }
}

/// One parsed piece: where it lies and how many rows it gave.
#[derive(Debug)]
struct Piece {
    range: Range<usize>,
    first_line: usize,
    first_row: usize,
}

/// All rows: columns t, V, xp, xc (`None` where not asked for).
#[derive(Debug)]
pub(super) struct Table {
    pub columns: [Option<Vec<f64>>; 4],
    /// Number of the line after the last one read.
    pub next_line: usize,
    pieces: Vec<Piece>,
}

/// What a thread makes of one piece.
struct Parsed {
    columns: [Vec<f64>; 4],
    rows: usize,
    lines: usize,
}

impl Table {
    /// Parses `text.bytes[range]`, whose first line has the number `first_line`.
    pub(super) fn parse(
        file: &str,
        text: &Text,
        range: Range<usize>,
        first_line: usize,
        layout: &Layout,
        progress: Option<&Progress>,
    ) -> Result<Self, ImportError> {
        let total = range.len().max(1);
        let ranges = split(text, range.clone());
        let mut table = Table {
            columns: layout.present.map(|wanted| wanted.then(Vec::new)),
            next_line: first_line,
            pieces: Vec::with_capacity(ranges.len()),
        };
        let mut rows = 0;
        // In batches, so that progress and cancelling stay with the caller's thread.
        for batch in ranges.chunks(4 * rayon::current_num_threads().max(1)) {
            let parsed: Vec<(Parsed, Result<(), ImportError>)> = batch
                .par_iter()
                .map(|piece| {
                    let parsed = parse_piece(&text.bytes[piece.clone()], text.newline, layout);
                    (parsed, text.check(file, piece.clone(), 1))
                })
                .collect();
            for (piece, (parsed, check)) in batch.iter().zip(parsed) {
                if check.is_err() {
                    // Again, now that the line number is known.
                    text.check(file, piece.clone(), table.next_line)?;
                }
                table.pieces.push(Piece {
                    range: piece.clone(),
                    first_line: table.next_line,
                    first_row: rows,
                });
                if rows == 0 && parsed.rows > 0 {
                    // The first piece says how many rows there will be.
                    let expected = parsed.rows as f64 * total as f64 / piece.len().max(1) as f64;
                    for column in table.columns.iter_mut().flatten() {
                        // A wrong guess or a lack of memory only costs copies later.
                        let _ = column.try_reserve((expected * 1.02) as usize);
                    }
                }
                rows += parsed.rows;
                table.next_line += parsed.lines;
                for (all, own) in table.columns.iter_mut().zip(&parsed.columns) {
                    if let Some(all) = all {
                        all.extend_from_slice(own);
                    }
                }
            }
            let done = batch.last().map_or(range.end, |piece| piece.end) - range.start;
            let share = READ_SHARE + (0.95 - READ_SHARE) * (done as f32 / total as f32);
            if progress.is_some_and(|go_on| !go_on(share)) {
                return Err(ImportError::Cancelled {
                    file: file.to_owned(),
                });
            }
        }
        Ok(table)
    }

    /// The text of the line that gave `row`, with its number.
    fn find<'t>(&self, text: &Text<'t>, layout: &Layout, row: usize) -> Option<(usize, &'t [u8])> {
        let at = self
            .pieces
            .partition_point(|piece| piece.first_row <= row)
            .checked_sub(1)?;
        let piece = &self.pieces[at];
        text.split(&text.bytes[piece.range.clone()])
            .enumerate()
            .filter(|(_, line)| !is_skipped(line, layout.delimiter))
            .nth(row - piece.first_row)
            .map(|(i, line)| (piece.first_line + i, line))
    }

    /// Number of the line that gave `row`.
    pub(super) fn line_of(&self, text: &Text, layout: &Layout, row: usize) -> usize {
        self.find(text, layout, row)
            .map_or(self.next_line, |(line, _)| line)
    }

    /// Text of a cell, for a message.
    pub(super) fn cell_of(
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

/// Pieces of about [`PIECE_BYTES`] bytes that end with lines.
fn split(text: &Text, range: Range<usize>) -> Vec<Range<usize>> {
    let mut pieces = Vec::with_capacity(range.len() / PIECE_BYTES + 1);
    let mut start = range.start;
    while start < range.end {
        let near = (start + PIECE_BYTES).min(range.end);
        let end = text.bytes[near..range.end]
            .iter()
            .position(|b| *b == text.newline)
            .map_or(range.end, |p| near + p + 1);
        pieces.push(start..end);
        start = end;
    }
    pieces
}

/// One pass over the bytes: numbers are read where they stand, and only cells that
/// are not plain numbers are looked at twice.
fn parse_piece(text: &[u8], newline: u8, layout: &Layout) -> Parsed {
    let mut parsed = Parsed {
        columns: layout
            .present
            .map(|wanted| Vec::with_capacity(if wanted { text.len() / 24 } else { 0 })),
        rows: 0,
        lines: 0,
    };
    let line_end = |from: usize| {
        from + text[from..]
            .iter()
            .position(|b| *b == newline)
            .unwrap_or(text.len() - from)
    };
    let mut p = 0;
    while p < text.len() {
        parsed.lines += 1;
        if !matches!(text[p], b'0'..=b'9' | b'-') {
            let end = line_end(p);
            if is_skipped(&text[p..end], layout.delimiter) {
                p = end + 1;
                continue;
            }
        }
        let mut ended = false;
        for wanted in &layout.columns {
            if ended {
                for (slot, _) in wanted {
                    parsed.columns[*slot].push(f64::NAN);
                }
                continue;
            }
            let start = p;
            let mut end = None;
            for &(slot, shift) in wanted {
                let (value, at) = match plain(text, start, newline, layout, shift) {
                    Some(found) => found,
                    None => {
                        let at = start + cell_end(&text[start..], layout.delimiter, Some(newline));
                        (number::cell(&text[start..at], layout.comma, shift), at)
                    }
                };
                parsed.columns[slot].push(value);
                end = Some(at);
            }
            p = end.unwrap_or_else(|| {
                start + cell_end(&text[start..], layout.delimiter, Some(newline))
            });
            // On a delimiter there is a next cell; on a line end or at the end not.
            ended = text.get(p) != Some(&layout.delimiter);
            if !ended {
                p += 1;
            }
        }
        parsed.rows += 1;
        if p < text.len() && (!ended || text[p] != newline) {
            p = line_end(p);
        }
        p += 1;
    }
    parsed
}

/// A number that stands in its cell alone, but for spaces: its value and where the
/// cell ends. `None` sends the cell the long way.
#[inline]
fn plain(
    text: &[u8],
    start: usize,
    newline: u8,
    layout: &Layout,
    shift: i32,
) -> Option<(f64, usize)> {
    let mut p = start;
    while text.get(p) == Some(&b' ') {
        p += 1;
    }
    let (value, taken) = number::prefix(&text[p..], layout.comma, shift)?;
    p += taken;
    while text.get(p) == Some(&b' ') {
        p += 1;
    }
    let at_end = match text.get(p) {
        None => true,
        Some(&b) if b == layout.delimiter || b == newline => true,
        Some(b'\r') => text.get(p + 1) == Some(&newline),
        Some(_) => false,
    };
    if !at_end || !value.is_finite() {
        return None;
    }
    Some((value, p))
}
