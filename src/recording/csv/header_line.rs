//! Where the header stands among comments, free text and units.

use super::line::{show_row, uncomment};
use super::names;
use super::settings::Delimiter;

/// A header and where the rows after it start (indices of lines).
pub(super) struct HeaderLine {
    pub line: usize,
    pub next_line: usize,
    pub cells: Vec<String>,
}

/// The header among the lines before the first row of numbers: the nearest line that
/// names known columns, commented or not; else the nearest line with as many cells
/// as the rows have.
pub(super) fn find_header_line(
    before: &[&[u8]],
    delimiter: u8,
    columns: usize,
) -> Option<HeaderLine> {
    let candidates: Vec<(usize, Vec<String>)> = before
        .iter()
        .enumerate()
        .rev()
        .filter(|(_, line)| !line.trim_ascii().is_empty())
        .take(50)
        .flat_map(|(i, line)| {
            let plain = uncomment(line).unwrap_or(line);
            // Some programs separate the names otherwise than the numbers.
            let own = show_row(plain, delimiter);
            if own.len() > 1 {
                vec![(i, own)]
            } else {
                Delimiter::ALL
                    .iter()
                    .map(|d| (i, show_row(plain, d.byte())))
                    .filter(|(_, cells)| cells.len() == columns.max(2))
                    .collect()
            }
        })
        .collect();
    let known = candidates
        .iter()
        .position(|(_, cells)| names::is_header(cells));
    let nearest = || {
        let (line, cells) = candidates.first()?;
        let commented = uncomment(before[*line]).is_some();
        (cells.len() == columns && !commented).then_some(0)
    };
    let at = known.or_else(nearest)?;
    let (mut line, mut cells) = candidates[at].clone();
    let mut next_line = line + 1;
    // Names above, units below. A row of units is itself close to the numbers, so the
    // search may have stopped there.
    if names::is_units_row(&cells)
        && known.is_none()
        && let Some((above, names)) = candidates
            .get(at + 1)
            .filter(|(_, c)| c.len() == cells.len())
    {
        cells = join_units(names, &cells);
        line = *above;
    } else if let Some((below, units)) = at.checked_sub(1).map(|i| &candidates[i])
        && units.len() == cells.len()
        && names::is_units_row(units)
        && cells.iter().all(|cell| names::split_unit(cell).1.is_none())
    {
        cells = join_units(&cells, units);
        next_line = below + 1;
    }
    // A trailing delimiter makes an empty name.
    while cells.len() > columns && cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    Some(HeaderLine {
        line,
        next_line,
        cells,
    })
}

fn join_units(names: &[String], units: &[String]) -> Vec<String> {
    names
        .iter()
        .zip(units)
        .map(|(name, unit)| match names::unbracket(unit) {
            "" => name.clone(),
            unit => format!("{name} [{unit}]"),
        })
        .collect()
}
