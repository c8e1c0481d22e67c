//! Rows without a delimiter of one byte, rewritten with tabulators: blanks, cells of a fixed width,
//! `label:value`. A line stays a line, so that line numbers hold.

use std::borrow::Cow;

use crate::recording::csv::number;
use crate::recording::csv::settings::Delimiter;

/// Most names of a `label:value` row.
const MAX_LABELS: usize = 64;

/// Writes a line as it is to be read.
type Rewrite<'a> = Box<dyn Fn(&[u8], &mut Vec<u8>) + 'a>;

/// `bytes` as the other modules read them.
pub(in crate::recording::csv) fn reshape<'a>(
    bytes: Cow<'a, [u8]>,
    newline: u8,
    delimiter: Delimiter,
    cell_ends: &[usize],
) -> Cow<'a, [u8]> {
    let rewrite: Rewrite = match delimiter {
        Delimiter::Comma | Delimiter::Semicolon | Delimiter::Tab | Delimiter::Pipe => return bytes,
        Delimiter::Spaces => Box::new(spaces),
        Delimiter::FixedWidth => Box::new(|line, out| fixed_width(line, cell_ends, out)),
        Delimiter::Labels => {
            let names = bytes.split(|b| *b == newline).find_map(labels);
            let names: Vec<Vec<u8>> = names.map_or_else(Vec::new, |found| {
                found.iter().map(|l| l.name.to_vec()).collect()
            });
            Box::new(move |line, out| by_labels(line, &names, out))
        }
    };
    let mut out = Vec::with_capacity(bytes.len() + 16);
    let mut first = true;
    for line in bytes.split(|b| *b == newline) {
        if !first {
            out.push(newline);
        }
        first = false;
        rewrite(line.strip_suffix(b"\r").unwrap_or(line), &mut out);
    }
    Cow::Owned(out)
}

/// Runs of blanks to one tabulator; a unit in brackets stays with its name, and a quoted text whole.
fn spaces(line: &[u8], out: &mut Vec<u8>) {
    let mut quoted = false;
    let mut blank = false;
    let start = out.len();
    for &b in line.trim_ascii() {
        if !quoted && (b == b' ' || b == b'\t') {
            blank = true;
            continue;
        }
        if blank {
            let unit = b == b'[' || b == b'(';
            // The mark of a comment is no cell.
            let after_mark = matches!(out.get(start..), Some(b"#" | b"%" | b"//"));
            out.push(if unit || after_mark { b' ' } else { b'\t' });
            blank = false;
        }
        quoted ^= b == b'"';
        out.push(b);
    }
}

/// Cells that end at the characters `ends`.
fn fixed_width(line: &[u8], ends: &[usize], out: &mut Vec<u8>) {
    let Ok(text) = std::str::from_utf8(line) else {
        out.extend_from_slice(line);
        return;
    };
    let mut at = 0;
    let mut cell = String::new();
    let mut put = |cell: &mut String, last: bool| {
        out.extend_from_slice(cell.trim().replace('\t', " ").as_bytes());
        if !last {
            out.push(b'\t');
        }
        cell.clear();
    };
    for (i, c) in text.chars().enumerate() {
        while ends.get(at).is_some_and(|end| i >= *end) {
            put(&mut cell, false);
            at += 1;
        }
        cell.push(c);
    }
    put(&mut cell, true);
}

/// Where the cells of right-aligned or left-aligned `rows` end, so that `header` is cut in blanks,
/// too; `None` if no characters are blank in all of them.
pub(in crate::recording::csv) fn find_cell_ends(
    rows: &[&[u8]],
    header: Option<&[u8]>,
) -> Option<Vec<usize>> {
    let blank_at = |line: &[u8], i: usize| line.get(i).is_none_or(|b| *b == b' ');
    let width = rows.iter().map(|row| row.len()).max()?.min(4096);
    let used: Vec<bool> = (0..width)
        .map(|i| rows.iter().any(|row| !blank_at(row, i)))
        .collect();
    let mut ends = Vec::new();
    let mut i = used.iter().position(|u| *u)?;
    while i < width {
        if used.get(i).copied().unwrap_or(false) {
            i += 1;
            continue;
        }
        let gap = i;
        while i < width && !used.get(i).copied().unwrap_or(true) {
            i += 1;
        }
        if i >= width {
            break;
        }
        let cut = header.and_then(|h| (gap..i).find(|&at| blank_at(h, at)));
        ends.push(cut.unwrap_or(gap));
    }
    (!ends.is_empty()).then_some(ends)
}

/// A number with its name and unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording::csv) struct Label<'a> {
    pub name: &'a [u8],
    pub value: &'a [u8],
    pub unit: &'a [u8],
}

/// The numbers of a `label:value` row; `None` if some part of the line is none.
pub(in crate::recording::csv) fn labels(line: &[u8]) -> Option<Vec<Label<'_>>> {
    let line = line.trim_ascii();
    let is_mark = |b: &u8| matches!(b, b',' | b';' | b'\t' | b'|');
    let marked = line.iter().any(is_mark);
    let parts: Vec<&[u8]> = if marked {
        line.split(|b| is_mark(b)).collect()
    } else {
        line.split(|b| *b == b' ').collect()
    };
    let mut found = Vec::new();
    for part in parts.iter().map(|p| p.trim_ascii()) {
        if part.is_empty() {
            continue;
        }
        let at = part.iter().position(|b| matches!(b, b':' | b'='))?;
        let name = part.get(..at)?.trim_ascii();
        let rest = part.get(at + 1..)?.trim_ascii();
        let end = rest
            .iter()
            .position(|b| b.is_ascii_alphabetic() && !matches!(b, b'e' | b'E') || *b >= 0x80)
            .unwrap_or(rest.len());
        let (value, unit) = (rest.get(..end)?.trim_ascii(), rest.get(end..)?.trim_ascii());
        let named = name
            .first()
            .is_some_and(|b| b.is_ascii_alphabetic() || *b >= 0x80);
        if !named || !number::kinds::is_number(value) {
            return None;
        }
        found.push(Label { name, value, unit });
        if found.len() > MAX_LABELS {
            return None;
        }
    }
    (found.len() >= 2).then_some(found)
}

/// The numbers of a row in the order of `names`; any other line as it is.
fn by_labels(line: &[u8], names: &[Vec<u8>], out: &mut Vec<u8>) {
    let Some(found) = labels(line) else {
        out.extend_from_slice(line);
        return;
    };
    for (i, name) in names.iter().enumerate() {
        if i > 0 {
            out.push(b'\t');
        }
        // Usually in the same order.
        let own = found.get(i).filter(|l| l.name == &name[..]);
        let own = own.or_else(|| found.iter().find(|l| l.name == &name[..]));
        if let Some(label) = own {
            out.extend_from_slice(label.value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::reshape::*;

    fn shaped(text: &str, delimiter: Delimiter, ends: &[usize]) -> String {
        let bytes = reshape(Cow::Borrowed(text.as_bytes()), b'\n', delimiter, ends);
        String::from_utf8(bytes.into_owned()).unwrap()
    }

    #[test]
    fn blanks_become_tabulators() {
        assert_eq!(
            shaped(
                "  t [s]   x [um]\r\n 0  1\n\"a b\" 2 ",
                Delimiter::Spaces,
                &[]
            ),
            "t [s]\tx [um]\n0\t1\n\"a b\"\t2"
        );
        assert_eq!(shaped("# t x", Delimiter::Spaces, &[]), "# t\tx");
    }

    #[test]
    fn fixed_cells_may_be_empty() {
        let rows: [&[u8]; 2] = [b"  0.0  8.0  1.25", b"  0.1  8.0 -1.25"];
        let ends = find_cell_ends(&rows, Some(b"time s  V  tip um")).unwrap();
        assert_eq!(ends.len(), 2);
        let text = shaped("  0.2       1.25", Delimiter::FixedWidth, &ends);
        assert_eq!(text, "0.2\t\t1.25");
    }

    #[test]
    fn labels_are_sorted_by_name() {
        let text = "t:0,V:8.00,x:-0.001\nx:2,t:1\nhello\n";
        assert_eq!(
            shaped(text, Delimiter::Labels, &[]),
            "0\t8.00\t-0.001\n1\t\t2\nhello\n"
        );
        let own = labels(b"t = 1.5ms; x= -2e-3 um").unwrap();
        assert_eq!((own[0].unit, own[1].value), (&b"ms"[..], &b"-2e-3"[..]));
        assert!(labels(b"14:03:12,5").is_none());
        assert!(labels(b"Date: 1.1.2026").is_none());
    }
}
