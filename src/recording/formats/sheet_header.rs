//! The header of a spreadsheet's table: names, units, and what stands above them.

use std::collections::BTreeMap;

/// A cell of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SheetText {
    /// Row from 0.
    pub row: u32,
    /// Column from 0.
    pub column: u32,
    /// Trimmed, not empty.
    pub text: String,
}

/// Names and units by column.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct SheetHeader {
    /// Name of a column.
    pub names: BTreeMap<u32, String>,
    /// Unit of a column, where a row of its own gives units.
    pub units: BTreeMap<u32, String>,
}

/// Longest text that can be a unit without brackets \[characters\].
const MAX_UNIT_CHARS: usize = 6;
/// Units that a row of units may have without brackets. Others need brackets, so that short names
/// (`V`, `xp`) are no units unless all their neighbours are.
const UNITS: [&str; 30] = [
    "s", "ms", "us", "\u{b5}s", "\u{3bc}s", "ns", "min", "h", "v", "mv", "kv", "volt", "volts",
    "m", "cm", "mm", "um", "\u{b5}m", "\u{3bc}m", "nm", "m/s", "mm/s", "um/s", "m/s2", "m/s^2",
    "g", "n", "mn", "hz", "-",
];
/// Rows of text above the header that a note shows.
const MAX_SHOWN_ROWS: usize = 8;

/// A unit without its brackets; `None` if the text is none.
fn unit(text: &str) -> Option<&str> {
    let inner = [('[', ']'), ('(', ')')]
        .iter()
        .find_map(|(open, close)| text.strip_prefix(*open)?.strip_suffix(*close));
    if let Some(inner) = inner {
        return Some(inner.trim());
    }
    let short = text.chars().count() <= MAX_UNIT_CHARS;
    let known = UNITS.contains(&text.to_lowercase().as_str());
    (short && known).then_some(text)
}

/// The header above row `first` for the columns `columns`: its last row of text, and the one before
/// where the last holds only units.
pub(super) fn header(
    texts: &[SheetText],
    first: u32,
    columns: &[u32],
    notes: &mut Vec<String>,
) -> SheetHeader {
    let mut rows: BTreeMap<u32, BTreeMap<u32, &str>> = BTreeMap::new();
    for cell in texts.iter().filter(|cell| cell.row < first) {
        rows.entry(cell.row)
            .or_default()
            .insert(cell.column, &cell.text);
    }
    // Names stand above most of the columns; a single line above a wide table is its title.
    let needed = columns.len().div_ceil(2);
    let covers = |row: &BTreeMap<u32, &str>| {
        columns
            .iter()
            .filter(|column| row.contains_key(column))
            .count()
            >= needed
    };
    let own = |row: &BTreeMap<u32, &str>| -> BTreeMap<u32, String> {
        columns
            .iter()
            .filter_map(|column| Some((*column, (*row.get(column)?).to_owned())))
            .collect()
    };
    let mut header = SheetHeader::default();
    let mut candidates = rows.iter().rev().filter(|(_, row)| covers(row));
    let mut used = Vec::new();
    if let Some((last, row)) = candidates.next() {
        used.push(*last);
        let units: Option<BTreeMap<u32, String>> = own(row)
            .into_iter()
            .map(|(column, text)| Some((column, unit(&text)?.to_owned())))
            .collect();
        match (units, candidates.next()) {
            (Some(units), Some((above, names))) => {
                used.push(*above);
                header.names = own(names);
                header.units = units;
            }
            _ => header.names = own(row),
        }
    }
    let above: Vec<String> = rows
        .iter()
        .filter(|(index, _)| !used.contains(index))
        .map(|(_, row)| row.values().copied().collect::<Vec<_>>().join(" | "))
        .collect();
    if !above.is_empty() {
        let shown: Vec<&str> = above
            .iter()
            .take(MAX_SHOWN_ROWS)
            .map(String::as_str)
            .collect();
        notes.push(format!("Text above the table: {}.", shown.join("; ")));
    }
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(rows: &[&[&str]]) -> (SheetHeader, Vec<String>) {
        let texts: Vec<SheetText> = rows
            .iter()
            .enumerate()
            .flat_map(|(row, cells)| {
                cells
                    .iter()
                    .enumerate()
                    .map(move |(column, text)| SheetText {
                        row: row as u32,
                        column: column as u32,
                        text: (*text).to_owned(),
                    })
            })
            .collect();
        let mut notes = Vec::new();
        let header = header(&texts, rows.len() as u32, &[0, 1], &mut notes);
        (header, notes)
    }

    fn texts(of: &BTreeMap<u32, String>) -> Vec<&str> {
        of.values().map(String::as_str).collect()
    }

    #[test]
    fn names_units_and_a_title() {
        let (header, notes) = read(&[&["Run 7"], &["time", "voltage"], &["[s]", "mV"]]);
        assert_eq!(texts(&header.names), ["time", "voltage"]);
        assert_eq!(texts(&header.units), ["s", "mV"]);
        assert_eq!(notes, ["Text above the table: Run 7."]);
    }

    #[test]
    fn one_row_of_short_names_is_names() {
        let (header, _) = read(&[&["s", "V"]]);
        assert_eq!(texts(&header.names), ["s", "V"]);
        assert!(header.units.is_empty());
        let (header, _) = read(&[&["A", "B"], &["t", "V"]]);
        assert_eq!(texts(&header.names), ["t", "V"]);
    }
}
