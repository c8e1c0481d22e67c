//! How the lines of a table are divided into cells.

use std::borrow::Cow;

use crate::recording::csv::line::{cells, is_skipped, uncomment};
use crate::recording::csv::number::calendar;
use crate::recording::csv::number::kinds::looks_numeric;
use crate::recording::csv::settings::Delimiter;
use crate::recording::csv::text::reshape::{find_cell_ends, labels, reshape};

/// Rows of one number of cells that begin a table, although later rows have more.
const MIN_TABLE_ROWS: usize = 3;

/// Delimiters of one byte, the plainest first: a later one must be better to win.
const PLAIN_DELIMITERS: [Delimiter; 4] = [
    Delimiter::Comma,
    Delimiter::Semicolon,
    Delimiter::Tab,
    Delimiter::Pipe,
];

/// Number of cells if `line` is a row of numbers: numbers, clock times and missing values, at
/// least one number. With `remarks`, cells of other text are let in as long as there
/// are more numbers, two at least.
pub(super) fn data_cells(line: &[u8], delimiter: u8, remarks: bool) -> Option<usize> {
    let (mut numbers, mut texts, mut count) = (0, 0, 0);
    for cell in cells(line, delimiter) {
        match looks_numeric(cell) {
            Some(true) => numbers += 1,
            Some(false) => {}
            None if is_clock(cell) => numbers += 1,
            None if remarks => texts += 1,
            None => return None,
        }
        count += 1;
    }
    let enough = if texts > 0 {
        numbers >= 2 && numbers > texts
    } else {
        numbers > 0
    };
    enough.then_some(count)
}

fn is_clock(cell: &[u8]) -> bool {
    cell.first()
        .is_some_and(|b| b.is_ascii_digit() || matches!(b, b'"' | b' '))
        && std::str::from_utf8(cell).is_ok_and(|text| calendar::seconds(text).is_some())
}

/// How many rows of numbers there are, and with how many cells most.
fn score(lines: &[&[u8]], delimiter: u8, remarks: bool) -> (usize, usize) {
    let mut counts: Vec<usize> = lines
        .iter()
        .filter_map(|line| data_cells(line, delimiter, remarks))
        .collect();
    counts.sort_unstable();
    counts
        .chunk_by(|a, b| a == b)
        .map(|run| (run.len(), run.first().copied().unwrap_or(0)))
        .max()
        .unwrap_or((0, 0))
}

/// How the lines are divided into cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Way {
    pub delimiter: Delimiter,
    pub cell_ends: Vec<usize>,
    pub columns: usize,
    pub remarks: bool,
}

/// The delimiter that reads most rows of numbers; `None` if there are none.
pub(super) fn best_way(lines: &[&[u8]]) -> Option<Way> {
    let filled = lines.iter().filter(|l| !is_skipped(l, b',')).count();
    let labelled = lines.iter().filter(|l| labels(l).is_some()).count();
    if labelled > 0 && 2 * labelled >= filled {
        let columns = lines.iter().find_map(|l| labels(l)).map_or(0, |l| l.len());
        return Some(Way {
            delimiter: Delimiter::Labels,
            cell_ends: Vec::new(),
            columns,
            remarks: false,
        });
    }
    let blank = reshaped(lines, Delimiter::Spaces, &[]);
    let blank: Vec<&[u8]> = blank.split(|b| *b == b'\n').collect();
    // Rows with remarks in them only where there are none without.
    [false, true].into_iter().find_map(|remarks| {
        let mut best: Option<(Delimiter, (usize, usize), usize)> = None;
        let plain = PLAIN_DELIMITERS.map(|d| (d, score(lines, d.byte(), remarks)));
        let spaces = (Delimiter::Spaces, score(&blank, b'\t', remarks));
        for (delimiter, (found, cells)) in plain.into_iter().chain([spaces]) {
            // Two columns beat one: "0,5" is a row of two before it is a number.
            let rank = (cells.min(2), found);
            if found > 0 && best.is_none_or(|(_, most, _)| rank > most) {
                best = Some((delimiter, rank, cells));
            }
        }
        best.map(|(delimiter, _, columns)| Way {
            delimiter,
            cell_ends: Vec::new(),
            columns,
            remarks,
        })
    })
}

pub(super) fn reshaped(lines: &[&[u8]], delimiter: Delimiter, cell_ends: &[usize]) -> Vec<u8> {
    let joined = lines.join(&b'\n');
    reshape(Cow::Owned(joined), b'\n', delimiter, cell_ends).into_owned()
}

/// Cells of a fixed width, where blanks do not tell cells apart: a header of several words, or cells
/// that are empty.
pub(super) fn fixed_width(lines: &[&[u8]], way: &Way) -> Option<Way> {
    let blank = reshaped(lines, Delimiter::Spaces, &[]);
    let widths: Vec<Option<usize>> = blank
        .split(|b| *b == b'\n')
        .map(|line| data_cells(line, b'\t', way.remarks))
        .collect();
    let first = widths.iter().position(|w| *w == Some(way.columns))?;
    let rows: Vec<&[u8]> = lines
        .iter()
        .zip(&widths)
        .filter(|(_, w)| w.is_some())
        .map(|(line, _)| *line)
        .collect();
    let header = first.checked_sub(1).and_then(|i| lines.get(i)).copied();
    let tokens = header.map_or(0, |h| {
        let own = reshaped(&[h], Delimiter::Spaces, &[]);
        cells(&own, b'\t').count()
    });
    let ragged = widths
        .iter()
        .skip(first)
        .flatten()
        .any(|w| *w < way.columns);
    let wordy = tokens > way.columns && header.is_some_and(|h| uncomment(h).is_none());
    if !ragged && !wordy {
        return None;
    }
    let cell_ends = find_cell_ends(&rows, header.filter(|_| wordy))?;
    (cell_ends.len() + 1 == way.columns).then(|| Way {
        delimiter: Delimiter::FixedWidth,
        cell_ends,
        ..way.clone()
    })
}

/// Where the table of numbers begins, and its number of cells there: with the most frequent number, or
/// with a run of another one before.
pub(super) fn first_row(lines: &[&[u8]], delimiter: u8, way: &Way) -> Option<(usize, usize)> {
    let widths: Vec<Option<usize>> = lines
        .iter()
        .map(|line| data_cells(line, delimiter, way.remarks))
        .collect();
    let most = widths.iter().position(|w| *w == Some(way.columns))?;
    let run = (0..most).find(|i| {
        let rows = widths.get(*i..*i + MIN_TABLE_ROWS).unwrap_or_default();
        let first = rows.first().copied().flatten();
        first.is_some_and(|n| n >= 2) && rows.iter().all(|w| *w == first)
    });
    match run {
        Some(i) => Some((i, widths.get(i).copied().flatten()?)),
        None => Some((most, way.columns)),
    }
}
