//! One line of a file: its cells, whether it is a comment, and its text for the screen.

use crate::recording::error::visible;

/// Longest cell shown \[characters\].
const MAX_SHOWN_CHARS: usize = 60;

/// The cells of a line. Quotes keep a delimiter inside a cell.
pub(super) fn cells(line: &[u8], delimiter: u8) -> impl Iterator<Item = &[u8]> {
    let mut rest = Some(line);
    std::iter::from_fn(move || {
        let line = rest?;
        let end = cell_end(line, delimiter, None);
        rest = line.get(end + 1..).filter(|_| end < line.len());
        Some(&line[..end])
    })
}

/// Where the cell at the start of `text` ends: at the delimiter or line end outside
/// quotes, or at the end.
pub(super) fn cell_end(text: &[u8], delimiter: u8, newline: Option<u8>) -> usize {
    let stops = |b: u8| b == delimiter || Some(b) == newline;
    let blank = text.iter().take_while(|b| **b == b' ').count();
    if text.get(blank) == Some(&b'"') {
        let mut p = blank + 1;
        while let Some(&b) = text.get(p) {
            if Some(b) == newline {
                break;
            }
            if b == b'"' {
                if text.get(p + 1) == Some(&b'"') {
                    p += 1;
                } else {
                    let after = &text[p + 1..];
                    return p + 1 + after.iter().position(|b| stops(*b)).unwrap_or(after.len());
                }
            }
            p += 1;
        }
        // The quote is never closed: it is an ordinary character.
    }
    text.iter().position(|b| stops(*b)).unwrap_or(text.len())
}

/// Lines that are no rows: comments, empty lines, lines of delimiters only.
pub(super) fn is_skipped(line: &[u8], delimiter: u8) -> bool {
    let line = line.trim_ascii_start();
    line.starts_with(b"#")
        || line.starts_with(b"%")
        || line.starts_with(b"//")
        // 0x1a: the end mark that DOS programs left.
        || line
            .iter()
            .all(|b| *b == delimiter || b.is_ascii_whitespace() || *b == 0x1a)
}

/// A cell as text for the screen and for names: trimmed, unquoted, without control characters.
pub(super) fn show(cell: &[u8]) -> String {
    let text = String::from_utf8_lossy(cell.trim_ascii());
    let text = match text.strip_prefix('"').and_then(|t| t.strip_suffix('"')) {
        Some(inner) => inner.replace("\"\"", "\""),
        None => text.into_owned(),
    };
    let text: String = text.trim().chars().take(MAX_SHOWN_CHARS).collect();
    visible(&text)
}

pub(super) fn show_row(line: &[u8], delimiter: u8) -> Vec<String> {
    cells(line, delimiter).map(show).collect()
}

/// The mark of a comment line, stripped.
pub(super) fn uncomment(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii_start();
    [&b"#"[..], b"%", b"//"]
        .iter()
        .find_map(|mark| line.strip_prefix(*mark))
        .map(|rest| rest.trim_ascii())
}
