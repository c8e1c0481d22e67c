//! One piece of the rows: numbers are read where they stand.

use super::layout::{Layout, TIME_SLOT};
use super::widths::Widths;
use crate::recording::csv::line::{cell_end, cells, is_skipped};
use crate::recording::csv::number;
use crate::recording::csv::number::kinds::{is_overrange, looks_numeric};
use crate::recording::csv::number::relative_time::{self, RelativeTime, Zero};
use crate::recording::times::rounding::Printed;

/// Rows without a time of which a piece keeps the place.
const MAX_TIMELESS_ROWS: usize = 4096;
/// Columns whose marks are looked at.
pub(super) const MAX_MARKED_COLUMNS: usize = 256;

/// What a thread makes of one piece.
pub(super) struct Parsed {
    pub columns: [Vec<f64>; 4],
    pub rows: usize,
    pub lines: usize,
    pub printed: Printed,
    pub overrange: [usize; 4],
    pub text_rows: Vec<usize>,
    pub widths: Widths,
}

/// One pass over the bytes: numbers are read where they stand, and only cells that
/// are not plain numbers are looked at twice.
pub(super) fn parse_piece(text: &[u8], newline: u8, layout: &Layout, zero: &Zero) -> Parsed {
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
            if value.is_nan() && is_overrange(cell) {
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
        match looks_numeric(cell) {
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
