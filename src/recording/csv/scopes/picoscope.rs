//! PicoScope 6 and 7: names, below them units in round brackets, and an empty line: `Time,Channel A`,
//! `(ms),(V)`. Units differ from file to file; a custom probe has one of its own. In countries of the
//! decimal comma cells end with semicolons, and the names are translated: `Zeit;Kanal A`. Readings out
//! of range are an infinity sign.

use super::{Head, ScopeHeader, with_units};
use crate::recording::csv::line::show_row;

/// Lines above the units.
const MAX_LINES_ABOVE: usize = 3;
/// What separates cells.
const DELIMITERS: [u8; 3] = [b',', b';', b'\t'];

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let (line, delimiter, units) = (1..=MAX_LINES_ABOVE).find_map(|line| {
        let text = head.lines.get(line)?;
        let split = |delimiter: &u8| Some((line, *delimiter, units(&show_row(text, *delimiter))?));
        DELIMITERS.iter().find_map(split)
    })?;
    let names = show_row(head.lines.get(line - 1)?, delimiter);
    // Other programs write units in brackets, too, but no empty line below them.
    if !head.lines.get(line + 1)?.trim_ascii().is_empty() {
        return None;
    }
    let is_name = |name: &String| name.trim().parse::<f64>().is_err();
    if names.len() != units.len() || !names.iter().all(is_name) {
        return None;
    }
    let mut cells = with_units(&names, &units);
    // A translated name is still the time.
    if let (Some(first), Some(unit)) = (cells.first_mut(), units.first()) {
        *first = format!("Time [{}]", unit.trim());
    }
    Some(ScopeHeader::new("PicoScope", cells, line))
}

/// The units, where every cell is one in round brackets, and the first is one of time.
fn units(cells: &[String]) -> Option<Vec<String>> {
    let one = |cell: &String| {
        let inner = cell.trim().strip_prefix('(')?.strip_suffix(')')?;
        Some(inner.trim().to_owned())
    };
    let units: Vec<String> = cells.iter().map(one).collect::<Option<_>>()?;
    let is_time = units.first()?.ends_with('s');
    (is_time && units.len() >= 2).then_some(units)
}
