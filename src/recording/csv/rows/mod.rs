//! Rows of numbers, parsed in parallel pieces.

pub(in crate::recording::csv) mod layout;
pub(in crate::recording::csv) mod order;
pub(super) mod truncated_line;
mod widths;

use std::ops::Range;

use rayon::prelude::*;

use self::layout::{Layout, TIME_SLOT};
use self::widths::Widths;
use crate::recording::csv::line::{cell_end, cells, is_skipped, show};
use crate::recording::csv::number;
use crate::recording::csv::number::marks::Evidence;
use crate::recording::csv::number::relative_time::{self, RelativeTime, Zero};
use crate::recording::csv::text::{Progress, READ_SHARE, Text};
use crate::recording::error::ImportError;
use crate::recording::times::exact_time::ExactTime;
use crate::recording::times::rounding::Printed;

/// Size of one piece of text \[bytes\]: large against a line, small against a file.
const PIECE_BYTES: usize = 2 << 20;
/// Rows without a time of which a piece keeps the place.
const MAX_TIMELESS_ROWS: usize = 4096;
/// Columns whose marks are looked at.
const MAX_MARKED_COLUMNS: usize = 256;

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

/// What a thread makes of one piece.
struct Parsed {
    columns: [Vec<f64>; 4],
    rows: usize,
    lines: usize,
    printed: Printed,
    overrange: [usize; 4],
    text_rows: Vec<usize>,
    widths: Widths,
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
        overrange: [0; 4],
        text_rows: Vec::new(),
        widths: Widths::default(),
    };
    let line_end = |from: usize| {
        let rest = text.get(from..).unwrap_or_default();
        from + memchr::memchr(newline, rest).unwrap_or(rest.len())
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
        let start = p;
        let width = if layout.is_plain {
            plain_row(text, &mut p, newline, layout, zero, &mut parsed)
        } else {
            p = line_end(p);
            marked_row(&text[start..p], layout, zero, &mut parsed)
        };
        parsed.note_row(&text[start..p], layout, width);
        p += 1;
    }
    parsed
}

impl Parsed {
    /// Takes note of a row after its cells.
    #[inline]
    fn note_row(&mut self, line: &[u8], layout: &Layout, width: usize) {
        let timeless = self.columns[TIME_SLOT].last().is_some_and(|t| t.is_nan());
        if timeless && self.text_rows.len() < MAX_TIMELESS_ROWS && is_text(line, layout) {
            self.text_rows.push(self.rows);
        } else {
            self.widths.note(width, self.rows);
        }
        self.rows += 1;
    }

    #[inline]
    fn push(&mut self, slot: usize, value: f64, overrange: (f64, f64), cell: &[u8]) {
        let value = if value.abs() >= overrange.0 && value.abs() < overrange.1 {
            self.overrange[slot] += 1;
            f64::NAN
        } else {
            if value.is_nan() && number::is_overrange(cell) {
                self.overrange[slot] += 1;
            }
            value
        };
        self.columns[slot].push(value);
    }
}

/// Whether most cells of a line are text: a header or a footer among the rows.
fn is_text(line: &[u8], layout: &Layout) -> bool {
    let (mut numbers, mut texts) = (0usize, 0usize);
    for cell in cells(line, layout.delimiter).take(MAX_MARKED_COLUMNS) {
        match number::looks_numeric(cell) {
            Some(true) => numbers += 1,
            Some(false) => {}
            None => texts += 1,
        }
    }
    texts > 0 && texts >= numbers
}

/// Reads a row of plain numbers at `p`, which ends on the line's end; returns the number of cells.
#[inline]
fn plain_row(
    text: &[u8],
    p: &mut usize,
    newline: u8,
    layout: &Layout,
    zero: &Zero,
    parsed: &mut Parsed,
) -> usize {
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
            *p += cell_end(&text[*p..], layout.delimiter, Some(newline));
            ended = on_to_next(p);
            column += 1;
        }
        if ended {
            for slot in wanted {
                parsed.columns[*slot].push(f64::NAN);
            }
            continue;
        }
        let start = *p;
        for &slot in wanted {
            let reading = &layout.slots[slot];
            if slot == TIME_SLOT {
                let (time, at) = time_cell(text, start, newline, layout, reading.shift, zero);
                if let Some(time) = time {
                    parsed.printed.note(time.digits, time.place);
                }
                parsed.columns[slot].push(time.map_or(f64::NAN, |t| t.value));
                *p = at;
            } else {
                let (value, at) = number_cell(text, start, newline, layout, reading.shift);
                parsed.push(slot, value, reading.overrange, &text[start..at]);
                *p = at;
            }
        }
        ended = on_to_next(p);
        column += 1;
    }
    if ended && text.get(*p) == Some(&newline) || *p >= text.len() {
        return column + usize::from(!ended);
    }
    let rest = text.get(*p..).unwrap_or_default();
    let end = memchr::memchr(newline, rest).unwrap_or(rest.len());
    let more = rest.get(..end).unwrap_or_default();
    *p += end;
    if ended {
        return column;
    }
    // Empty cells at the end are no cells.
    let more = more.strip_suffix(b"\r").unwrap_or(more);
    let filled = more
        .iter()
        .rposition(|b| *b != layout.delimiter && *b != b' ');
    match filled.and_then(|last| more.get(..=last)) {
        None => column,
        Some(more) if more.contains(&b'"') => column + cells(more, layout.delimiter).count(),
        Some(more) => column + 1 + more.iter().filter(|b| **b == layout.delimiter).count(),
    }
}

/// Reads the cells of a line with the marks of their columns; returns the number of cells.
fn marked_row(line: &[u8], layout: &Layout, zero: &Zero, parsed: &mut Parsed) -> usize {
    let line = line.strip_suffix(b"\r").unwrap_or(line);
    let mut found: [Option<f64>; 4] = [None; 4];
    let (mut time, mut date): (Option<&[u8]>, &[u8]) = (None, &[]);
    let mut wanted = layout.columns.iter().peekable();
    let mut width = 0;
    for (index, cell) in cells(line, layout.delimiter).enumerate() {
        if !cell.trim_ascii().is_empty() {
            width = index + 1;
        }
        if layout.date == Some(index) {
            date = cell;
        }
        let Some((_, slots)) = wanted.next_if(|(own, _)| *own == index) else {
            continue;
        };
        for &slot in slots {
            if slot == TIME_SLOT {
                time = Some(cell);
                continue;
            }
            let reading = &layout.slots[slot];
            let value = number::cell_with(cell, reading.marks, reading.shift);
            parsed.push(slot, value, reading.overrange, cell);
            found[slot] = Some(value);
        }
    }
    for (slot, wanted) in layout.present.iter().enumerate() {
        if *wanted && slot != TIME_SLOT && found[slot].is_none() {
            parsed.columns[slot].push(f64::NAN);
        }
    }
    if layout.present[TIME_SLOT] {
        let read = time.and_then(|time| layout.time_text(time, date));
        let shift = layout.slots[TIME_SLOT].shift;
        let read = read.and_then(|text| relative_time::cell(&text, false, shift, zero));
        if let Some(time) = read {
            parsed.printed.note(time.digits, time.place);
        }
        parsed.columns[TIME_SLOT].push(read.map_or(f64::NAN, |t| t.value));
    }
    width
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
