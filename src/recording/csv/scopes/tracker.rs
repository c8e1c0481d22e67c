//! Tracker (physlets.org/tracker): `mass A` or `#multi:` above `t`, `x`, `y`, separated by tabulators
//! or commas, in seconds and metres, which it does not write. x is sideways, y the height.

use super::{Head, ScopeHeader};
use crate::recording::csv::line::{show_row, uncomment};

/// Lines above the names.
const MAX_LINES_ABOVE: usize = 3;

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let plain = |line: &&[u8]| uncomment(line).unwrap_or(line).to_vec();
    let lines: Vec<Vec<u8>> = head
        .lines
        .iter()
        .take(MAX_LINES_ABOVE + 1)
        .map(plain)
        .collect();
    let cells_of = |line: &[u8]| {
        let delimiters = [b'\t', b',', b';'];
        let rows = delimiters.iter().map(|d| show_row(line, *d));
        rows.max_by_key(Vec::len).unwrap_or_default()
    };
    let at = lines.iter().position(|line| {
        let cells = cells_of(line);
        let first = cells.first().map(|c| c.trim().trim_matches('"').to_owned());
        let has_height = cells.iter().any(|c| c.trim() == "y");
        first.as_deref() == Some("t") && has_height
    })?;
    // The name of the tracked mass stands alone in the line above.
    let above = lines.get(at.checked_sub(1)?)?;
    let named: Vec<String> = cells_of(above)
        .into_iter()
        .filter(|c| !c.is_empty())
        .collect();
    let [mass] = named.as_slice() else {
        return None;
    };
    let is_name = mass.chars().next().is_some_and(char::is_alphabetic) && mass.len() < 60;
    is_name.then(|| ScopeHeader {
        is_si: true,
        ..ScopeHeader::new("Tracker", cells_of(lines.get(at).map_or(&[], |l| l)), at)
    })
}
