//! The first rows of a text as settings split them, for a dialog's table.

use std::borrow::Cow;

use super::line::{is_skipped, show_row, uncomment};
use super::settings::ImportSettings;
use super::text::encoding::decode;
use super::text::reshape::reshape;
use super::text::{Text, newline_of};

/// Rows shown.
const SHOWN_ROWS: usize = 20;

/// The beginning of a text, split into cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShownRows {
    /// Names of the columns; empty without a header.
    pub header: Vec<String>,
    /// Number of columns.
    pub columns: usize,
    /// The first rows, at most 20.
    pub rows: Vec<Vec<String>>,
}

/// Splits the beginning of a file by encoding, delimiter and lines before the data. What is no text
/// gives no rows.
///
/// # Examples
/// ```
/// use impactscope::recording::csv::{Delimiter, ImportSettings, shown_rows};
/// let settings = ImportSettings { delimiter: Delimiter::Semicolon, skip_lines: 1, ..ImportSettings::default() };
/// let shown = shown_rows(b"# t [s]; x [um]\r\n0,5;\"1\"\r\n1,5;2\r\n", &settings);
/// assert_eq!(shown.header, ["t [s]", "x [um]"]);
/// assert_eq!(shown.rows, [["0,5", "1"], ["1,5", "2"]]);
/// ```
#[must_use]
pub fn shown_rows(head: &[u8], settings: &ImportSettings) -> ShownRows {
    let decoded = decode(head, settings.encoding, true).bytes;
    let newline = newline_of(&decoded);
    let bytes: Cow<'_, [u8]> = reshape(decoded, newline, settings.delimiter, &settings.cell_ends);
    let Ok(text) = Text::new("", &bytes) else {
        return ShownRows::default();
    };
    let delimiter = settings.delimiter.byte();
    let (start, _) = text.skip_lines(settings.skip_lines);
    let (before, after) = text.bytes.split_at(start.min(text.bytes.len()));
    let header = text
        .split(before)
        .map(|line| uncomment(line).unwrap_or(line).trim_ascii())
        .filter(|line| !line.is_empty())
        .last()
        .map(|line| show_row(line, delimiter))
        .unwrap_or_default();
    let rows: Vec<Vec<String>> = text
        .split(after)
        .filter(|line| !is_skipped(line, delimiter))
        .take(SHOWN_ROWS)
        .map(|line| show_row(line, delimiter))
        .collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    ShownRows {
        header,
        columns,
        rows,
    }
}

#[cfg(test)]
mod tests {
    use super::super::shown::*;
    use crate::recording::csv::{Delimiter, Encoding};

    #[test]
    fn settings_decide_how_rows_are_split() {
        let of = |text: &[u8], delimiter, skip_lines| {
            let settings = ImportSettings {
                delimiter,
                skip_lines,
                ..ImportSettings::default()
            };
            shown_rows(text, &settings)
        };
        let found = of(b"0 1\n 2   3\n", Delimiter::Spaces, 0);
        assert_eq!(found.rows, [["0", "1"], ["2", "3"]]);
        let found = of(b"1,\"2\n3,4\n", Delimiter::Comma, 0);
        assert_eq!(
            found.rows[1],
            ["3", "4"],
            "an unpaired quote affects one row only"
        );
        let beyond = of(b"1,2\n", Delimiter::Tab, 99);
        assert_eq!((beyond.columns, beyond.rows.len()), (0, 0));
        assert_eq!(of(b"", Delimiter::Comma, 0), ShownRows::default());
        let settings = ImportSettings {
            encoding: Some(Encoding::Windows1252),
            skip_lines: 1,
            ..ImportSettings::default()
        };
        let found = shown_rows(b"t [s],x [\xb5m]\n0,1\n", &settings);
        assert_eq!(found.header[1], "x [\u{b5}m]");
    }
}
