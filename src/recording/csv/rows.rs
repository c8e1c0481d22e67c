//! Rows of numbers, parsed in parallel pieces.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::line::{cell_end, cells, is_skipped, show};
use super::names::unit_shift;
use super::number;
use super::number::relative_time::{self, RelativeTime, Zero};
use super::settings::{Decimal, ImportSettings};
use super::text::{Progress, READ_SHARE, Text};
use crate::recording::error::ImportError;
use crate::recording::times::exact_time::ExactTime;
use crate::recording::times::rounding::Printed;

/// Size of one piece of text \[bytes\]: large against a line, small against a file.
const PIECE_BYTES: usize = 2 << 20;

/// Slot of the time column.
const TIME_SLOT: usize = 0;

/// Which columns to read, and as what.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub delimiter: u8,
    /// Whether an unquoted number may have a decimal comma.
    pub comma: bool,
    /// The columns needed, in their order: index and (slot, power of ten) pairs. Slots are t, V,
    /// xp, xc.
    columns: Vec<(usize, Vec<(usize, i32)>)>,
    present: [bool; 4],
    /// Index of the time column, and the power of ten of its unit.
    time: (usize, i32),
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
                file: file.into(),
                line: line.max(1),
                found: found().into(),
            });
        }
        if settings.proof_mass.is_none() {
            return Err(ImportError::NoPositionColumn {
                file: file.into(),
                line: line.max(1),
                found: found().into(),
            });
        }
        let mut columns: BTreeMap<usize, Vec<(usize, i32)>> = BTreeMap::new();
        let mut present = [false; 4];
        let mut time = (0, 0);
        for (slot, (choice, base, quantity, expected)) in chosen.into_iter().enumerate() {
            let Some(choice) = choice else { continue };
            let shift = unit_shift(&choice.unit, base).ok_or_else(|| ImportError::UnknownUnit {
                file: file.into(),
                line: line.max(1),
                column: choice.index.saturating_add(1),
                unit: choice.unit.clone().into(),
                quantity: quantity.to_owned(),
                expected: expected.to_owned(),
            })?;
            columns.entry(choice.index).or_default().push((slot, shift));
            present[slot] = true;
            if slot == TIME_SLOT {
                time = (choice.index, shift);
            }
        }
        let delimiter = settings.delimiter.byte();
        Ok(Self {
            delimiter,
            comma: settings.decimal == Decimal::Comma && delimiter != b',',
            columns: columns.into_iter().collect(),
            present,
            time,
        })
    }

    /// Power of ten of the unit of time.
    pub(super) fn time_unit(&self) -> i32 {
        self.time.1
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
    /// How the times were written.
    pub printed: Printed,
    pieces: Vec<Piece>,
}

/// What a thread makes of one piece.
struct Parsed {
    columns: [Vec<f64>; 4],
    rows: usize,
    lines: usize,
    printed: Printed,
}

impl Table {
    /// Parses `text.bytes[range]`, whose first line has the number `first_line`. Times count from
    /// `zero`.
    pub(super) fn parse(
        file: &str,
        text: &Text,
        range: Range<usize>,
        first_line: usize,
        layout: &Layout,
        zero: &Zero,
        progress: Option<&Progress>,
    ) -> Result<Self, ImportError> {
        let total = range.len().max(1);
        let ranges = split(text, range.clone());
        let mut table = Table {
            columns: layout.present.map(|wanted| wanted.then(Vec::new)),
            next_line: first_line,
            printed: Printed {
                unit: layout.time_unit(),
                ..Printed::NONE
            },
            pieces: Vec::with_capacity(ranges.len()),
        };
        let mut rows = 0;
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
                table.printed.join(&parsed.printed);
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
                return Err(ImportError::Cancelled { file: file.into() });
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

    /// Number of cells of the line that gave `row`.
    pub(super) fn cells_of(&self, text: &Text, layout: &Layout, row: usize) -> usize {
        self.find(text, layout, row)
            .map_or(0, |(_, line)| cells(line, layout.delimiter).count())
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

/// The first time in `rows` with all its digits, in the file's unit; `None` if there is none.
pub(super) fn first_time(rows: &[u8], text: &Text, layout: &Layout) -> Option<ExactTime> {
    let (column, unit) = layout.time;
    text.split(rows)
        .filter(|line| !is_skipped(line, layout.delimiter))
        .find_map(|line| {
            let cell = cells(line, layout.delimiter).nth(column)?;
            relative_time::exact_cell(cell, layout.comma, unit)
        })
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
fn parse_piece(text: &[u8], newline: u8, layout: &Layout, zero: &Zero) -> Parsed {
    let mut parsed = Parsed {
        columns: layout
            .present
            .map(|wanted| Vec::with_capacity(if wanted { text.len() / 24 } else { 0 })),
        rows: 0,
        lines: 0,
        printed: Printed::NONE,
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
        // On a delimiter there is a next cell; on a line end or at the end not.
        let on_to_next = |p: &mut usize| {
            let goes_on = text.get(*p) == Some(&layout.delimiter);
            *p += usize::from(goes_on);
            !goes_on
        };
        let mut column = 0;
        for (index, wanted) in &layout.columns {
            while column < *index && !ended {
                p += cell_end(&text[p..], layout.delimiter, Some(newline));
                ended = on_to_next(&mut p);
                column += 1;
            }
            if ended {
                for (slot, _) in wanted {
                    parsed.columns[*slot].push(f64::NAN);
                }
                continue;
            }
            let start = p;
            for &(slot, shift) in wanted {
                let (value, at) = if slot == TIME_SLOT {
                    let (time, at) = time_cell(text, start, newline, layout, shift, zero);
                    if let Some(time) = time {
                        parsed.printed.note(time.digits, time.place);
                    }
                    (time.map_or(f64::NAN, |t| t.value), at)
                } else {
                    number_cell(text, start, newline, layout, shift)
                };
                parsed.columns[slot].push(value);
                p = at;
            }
            ended = on_to_next(&mut p);
            column += 1;
        }
        parsed.rows += 1;
        if p < text.len() && (!ended || text[p] != newline) {
            p = line_end(p);
        }
        p += 1;
    }
    parsed
}

/// The number in the cell at `start`, NaN if it is none, and where the cell ends.
#[inline]
fn number_cell(
    text: &[u8],
    start: usize,
    newline: u8,
    layout: &Layout,
    shift: i32,
) -> (f64, usize) {
    let read = |text: &[u8]| number::prefix(text, layout.comma, shift);
    match plain(text, start, newline, layout, read) {
        Some((value, at)) if value.is_finite() => (value, at),
        _ => {
            let at = start + cell_end(&text[start..], layout.delimiter, Some(newline));
            (number::cell(&text[start..at], layout.comma, shift), at)
        }
    }
}

/// The time in the cell at `start`, if it is one, and where the cell ends.
#[inline]
fn time_cell(
    text: &[u8],
    start: usize,
    newline: u8,
    layout: &Layout,
    shift: i32,
    zero: &Zero,
) -> (Option<RelativeTime>, usize) {
    let read = |text: &[u8]| relative_time::prefix(text, layout.comma, shift, zero);
    match plain(text, start, newline, layout, read) {
        Some((time, at)) => (Some(time), at),
        None => {
            let at = start + cell_end(&text[start..], layout.delimiter, Some(newline));
            let cell = &text[start..at];
            (relative_time::cell(cell, layout.comma, shift, zero), at)
        }
    }
}

/// A number that stands in its cell alone, but for spaces, by `read`: its value and where the
/// cell ends. `None` sends the cell the long way.
#[inline]
fn plain<T>(
    text: &[u8],
    start: usize,
    newline: u8,
    layout: &Layout,
    read: impl Fn(&[u8]) -> Option<(T, usize)>,
) -> Option<(T, usize)> {
    let mut p = start;
    while text.get(p) == Some(&b' ') {
        p += 1;
    }
    let (value, taken) = read(&text[p..])?;
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
    at_end.then_some((value, p))
}
