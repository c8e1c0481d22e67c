//! Telling a last line that was cut off in the middle.

use super::layout::Layout;
use crate::recording::csv::line::{cells, is_skipped};
use crate::recording::csv::number;
use crate::recording::csv::text::Text;

/// Where the last line starts, if it was cut in the middle: it has no line end, and
/// fewer cells than the line before, or an unfinished last number, or fewer decimals
/// where all lines before have the same number of them.
pub(in crate::recording::csv) fn cut_last_line(
    rows: &[u8],
    text: &Text,
    layout: &Layout,
) -> Option<usize> {
    if rows.last().is_none_or(|b| *b == text.newline) {
        return None;
    }
    let start = rows.iter().rposition(|b| *b == text.newline)? + 1;
    let last = &rows[start..];
    if is_skipped(last, layout.delimiter) {
        return None;
    }
    // About the last fifty lines before it.
    let back = start.saturating_sub(50 * last.len().max(100));
    let before: Vec<&[u8]> = text
        .split(&rows[back..start])
        .filter(|line| !is_skipped(line, layout.delimiter))
        .collect();
    // The first of them is whole only if it is the first of all.
    let before = &before[usize::from(back > 0).min(before.len())..];
    let previous = before.last()?;
    let own: Vec<&[u8]> = cells(last, layout.delimiter).collect();
    let expected = cells(previous, layout.delimiter).count();
    if own.len() < expected {
        return Some(start);
    }
    let last_cell = |line: &&[u8]| cells(line, layout.delimiter).last().map(<[u8]>::to_vec);
    let own_cell = own.last()?;
    let reads = |cell: &[u8]| number::cell(cell, layout.comma, 0).is_finite();
    let previous_cell = last_cell(previous)?;
    if !reads(own_cell) && reads(&previous_cell) {
        return Some(start);
    }
    let decimals = |cell: &[u8]| {
        let cell = cell.trim_ascii();
        cell.iter()
            .position(|b| matches!(b, b'.' | b','))
            .map_or(0, |p| cell.len() - p)
    };
    let usual = decimals(&previous_cell);
    let steady = before.len() >= 8
        && before
            .iter()
            .filter_map(last_cell)
            .all(|cell| decimals(&cell) == usual);
    (steady && decimals(own_cell) < usual).then_some(start)
}
