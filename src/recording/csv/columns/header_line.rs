//! Where the header stands among comments, free text and units.

use super::names;
use super::units::{is_units_row, kind_of, split_unit, unbracket};
use crate::recording::csv::line::{show_row, uncomment};
use crate::recording::csv::settings::Delimiter;

/// Lines before the first row of numbers that may be the header.
const MAX_CANDIDATES: usize = 50;

/// A header and where the rows after it start (indices of lines).
#[derive(Debug, Clone)]
pub(in crate::recording::csv) struct HeaderLine {
    pub line: usize,
    pub next_line: usize,
    /// Names with their units.
    pub cells: Vec<String>,
    /// The row above, if it has as many cells: labels of groups of columns.
    pub labels: Vec<String>,
    /// Units of a second row that are not known, with their columns.
    pub unknown_units: Vec<(usize, String)>,
}

/// The header among the lines before the first row of numbers: the nearest line that
/// names known columns, commented or not; else the nearest line with as many cells
/// as the rows have.
pub(in crate::recording::csv) fn find_header_line(
    before: &[&[u8]],
    delimiter: u8,
    columns: usize,
) -> Option<HeaderLine> {
    let candidates: Vec<(usize, Vec<String>)> = before
        .iter()
        .enumerate()
        .rev()
        .filter(|(_, line)| !line.trim_ascii().is_empty())
        .take(MAX_CANDIDATES)
        .flat_map(|(i, line)| {
            let plain = uncomment(line).unwrap_or(line);
            // Some programs separate the names otherwise than the numbers.
            let own = show_row(plain, delimiter);
            if own.len() > 1 {
                vec![(i, own)]
            } else {
                let others = [
                    Delimiter::Comma,
                    Delimiter::Semicolon,
                    Delimiter::Tab,
                    Delimiter::Pipe,
                ];
                let by_mark = others.iter().map(|d| (i, show_row(plain, d.byte())));
                let by_blank = std::iter::once((i, words(plain)));
                by_mark
                    .chain(by_blank)
                    .filter(|(_, cells)| cells.len() == columns.max(2))
                    .collect()
            }
        })
        .collect();
    let known = candidates
        .iter()
        .position(|(_, cells)| names::is_header(cells) && cells.len() <= 2 * columns.max(2));
    let nearest = || {
        let (line, cells) = candidates.first()?;
        let commented = uncomment(before.get(*line)?).is_some();
        let names = cells
            .iter()
            .any(|cell| cell.chars().any(char::is_alphabetic));
        (cells.len() == columns && !commented && names).then_some(0)
    };
    let at = known.or_else(nearest)?;
    let (mut line, mut cells) = candidates.get(at)?.clone();
    let mut next_line = line + 1;
    let mut above = at + 1;
    let mut unknown_units = Vec::new();
    // Names above, units below. A row of units is itself close to the numbers, so the
    // search may have stopped there.
    let has_units = cells.iter().any(|cell| split_unit(cell).1.is_some());
    if let Some((row, names)) = candidates
        .get(at + 1)
        .filter(|(_, c)| c.len() == cells.len() && is_units_row(&cells) && !is_units_row(c))
        .filter(|_| known.is_none())
    {
        unknown_units = unknown(&cells);
        cells = join_units(names, &cells);
        line = *row;
        above += 1;
    } else if let Some((below, units)) = at.checked_sub(1).and_then(|i| candidates.get(i))
        && units.len() == cells.len()
        && is_units_row(units)
        && !has_units
    {
        unknown_units = unknown(units);
        cells = join_units(&cells, units);
        next_line = below + 1;
    }
    let labels = candidates
        .get(above)
        .filter(|(i, labels)| *i + 1 == line && labels.len() <= cells.len())
        .map(|(_, labels)| labels.clone())
        .unwrap_or_default();
    // A trailing delimiter makes an empty name.
    while cells.len() > columns && cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    Some(HeaderLine {
        line,
        next_line,
        cells,
        labels,
        unknown_units,
    })
}

/// The words of a line; a unit in brackets stays with its name.
fn words(line: &[u8]) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for word in String::from_utf8_lossy(line).split_whitespace() {
        match words.last_mut() {
            Some(last) if word.starts_with(['[', '(']) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.to_owned()),
        }
    }
    words
}

fn unknown(units: &[String]) -> Vec<(usize, String)> {
    units
        .iter()
        .enumerate()
        .map(|(i, unit)| (i, unbracket(unit).to_owned()))
        .filter(|(_, unit)| !unit.is_empty() && kind_of(unit).is_none())
        .collect()
}

fn join_units(names: &[String], units: &[String]) -> Vec<String> {
    names
        .iter()
        .zip(units)
        .map(|(name, unit)| match unbracket(unit) {
            "" => name.clone(),
            unit => format!("{name} [{unit}]"),
        })
        .collect()
}
