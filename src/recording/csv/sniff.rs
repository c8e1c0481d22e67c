//! What a file seems to be: delimiter, decimal mark, comments, header, columns.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::header_line::find_header_line;
use super::line::{cells, is_skipped, show, show_row, uncomment};
use super::settings::{Decimal, Delimiter, ImportSettings};
use super::text::Text;
use super::{header, number, text};
use crate::recording::error::{ImportError, ImportWarning, visible};

/// Bytes looked at from the beginning of a file.
const HEAD_BYTES: usize = 256 << 10;
/// Bytes looked at in the middle and at the end, where the first comma of a decimal
/// number may be.
const PROBE_BYTES: usize = 16 << 10;
/// Rows shown.
const SHOWN_ROWS: usize = 20;

/// Lines looked at, so that a file of empty lines costs nothing.
const MAX_LINES: usize = 2000;

/// What was understood of a file, for a dialog or at once for the import.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// File name or the name given for the bytes.
    pub name: String,
    /// Size of the file \[bytes\].
    pub size: u64,
    /// Comments and free text before the header.
    pub comments: Vec<String>,
    /// Column names as written (with units); empty if there is no header.
    pub header: Vec<String>,
    /// Number of columns.
    pub columns: usize,
    /// The first rows of numbers, as text; at most 20.
    pub rows: Vec<Vec<String>>,
    /// The import that suggests itself. `time` and `proof_mass` are `None` where the
    /// user has to choose.
    pub settings: ImportSettings,
    /// What a user should confirm; empty if the file is clear.
    pub ambiguities: Vec<String>,
    /// What is worth saying if the import goes ahead as suggested.
    pub warnings: Vec<ImportWarning>,
    /// Why the import cannot go ahead as suggested.
    pub(super) problem: Option<ImportError>,
}

impl Preview {
    /// Whether the file leaves a choice to the user.
    #[must_use]
    pub fn needs_dialog(&self) -> bool {
        self.problem.is_some() || !self.ambiguities.is_empty()
    }

    /// Why the file cannot be read as suggested, if so.
    #[must_use]
    pub fn problem(&self) -> Option<&ImportError> {
        self.problem.as_ref()
    }
}

/// Looks at a file's beginning, middle and end, however long it is.
///
/// # Errors
/// [`ImportError`] if it is not a file of text with rows of numbers.
pub fn preview(path: &Path) -> Result<Preview, ImportError> {
    let file = path.display().to_string();
    let (mut input, size) = text::open(path)?;
    let mut part = |from: u64, length: usize| {
        let mut bytes = Vec::new();
        input
            .seek(SeekFrom::Start(from))
            .and_then(|_| {
                Read::by_ref(&mut input)
                    .take(length as u64)
                    .read_to_end(&mut bytes)
            })
            .map(|_| bytes)
            .map_err(|error| ImportError::Unreadable {
                file: file.clone().into(),
                reason: error.to_string().into(),
            })
    };
    let head = part(0, HEAD_BYTES)?;
    let probes = if size > (HEAD_BYTES + 2 * PROBE_BYTES) as u64 {
        vec![
            part(size / 2, PROBE_BYTES)?,
            part(size - PROBE_BYTES as u64, PROBE_BYTES)?,
        ]
    } else {
        Vec::new()
    };
    let probes: Vec<&[u8]> = probes.iter().map(Vec::as_slice).collect();
    let mut preview = look(&file, &head, (head.len() as u64) < size, &probes)?;
    preview.size = size;
    preview.name = text::short_name(path);
    Ok(preview)
}

/// [`preview`] of bytes in memory.
///
/// # Errors
/// As [`preview`].
pub fn preview_bytes(name: &str, bytes: &[u8]) -> Result<Preview, ImportError> {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    let n = bytes.len();
    let probes: &[&[u8]] = if n > HEAD_BYTES + 2 * PROBE_BYTES {
        &[
            &bytes[n / 2..n / 2 + PROBE_BYTES],
            &bytes[n - PROBE_BYTES..],
        ]
    } else {
        &[]
    };
    let mut preview = look(name, head, head.len() < n, probes)?;
    preview.size = n as u64;
    Ok(preview)
}

/// The ways to read a row, the plainest first: a later one must be better to win.
const READING_WAYS: [(Delimiter, Decimal); 5] = [
    (Delimiter::Comma, Decimal::Point),
    (Delimiter::Semicolon, Decimal::Point),
    (Delimiter::Tab, Decimal::Point),
    (Delimiter::Semicolon, Decimal::Comma),
    (Delimiter::Tab, Decimal::Comma),
];

/// Number of cells if `line` is a row of numbers: numbers and missing values, at
/// least one number. With `remarks`, cells of other text are let in as long as there
/// are more numbers, two at least.
fn data_cells(line: &[u8], way: (Delimiter, Decimal), remarks: bool) -> Option<usize> {
    let (mut numbers, mut texts, mut count) = (0, 0, 0);
    for cell in cells(line, way.0.byte()) {
        match number::looks_numeric(cell, way.1 == Decimal::Comma) {
            Some(true) => numbers += 1,
            Some(false) => {}
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

/// How many rows of numbers a way of reading finds, and with how many cells most.
fn score(lines: &[&[u8]], way: (Delimiter, Decimal), remarks: bool) -> (usize, usize) {
    let mut counts: Vec<usize> = lines
        .iter()
        .filter_map(|line| data_cells(line, way, remarks))
        .collect();
    counts.sort_unstable();
    counts
        .chunk_by(|a, b| a == b)
        .map(|run| (run.len(), run[0]))
        .max()
        .unwrap_or((0, 0))
}

/// The way that reads most rows of numbers, with their number of cells; `None` if
/// there are none.
fn best_way(lines: &[&[u8]], remarks: bool) -> Option<((Delimiter, Decimal), usize)> {
    let mut best: Option<((Delimiter, Decimal), (usize, usize))> = None;
    for way in READING_WAYS {
        let (found, cells) = score(lines, way, remarks);
        // Two columns beat one: "0,5" is a row of two before it is a number.
        let rank = (cells.min(2), found);
        if found > 0 && best.is_none_or(|(_, most)| rank > most) {
            best = Some((way, rank));
        }
    }
    best.map(|(way, _)| (way, score(lines, way, remarks).1))
}

fn look(file: &str, head: &[u8], cut: bool, probes: &[&[u8]]) -> Result<Preview, ImportError> {
    let text = Text::new(file, head)?;
    // The last line of a longer file is cut in the middle: leave it out, and with it
    // a character cut in the middle.
    let whole = if cut {
        let end = text.bytes.iter().rposition(|b| *b == text.newline);
        &text.bytes[..end.map_or(text.bytes.len(), |p| p + 1)]
    } else {
        text.bytes
    };
    text.check(file, 0..whole.len(), 1)?;
    let lines: Vec<&[u8]> = text.split(whole).take(MAX_LINES).collect();

    // The first and last line of a probe are parts of lines.
    let mut sample = lines.clone();
    for probe in probes {
        let inner: Vec<&[u8]> = text.split(probe).collect();
        sample.extend(
            inner
                .get(1..inner.len().saturating_sub(1))
                .unwrap_or_default(),
        );
    }
    let no_numbers = || ImportError::NoNumbers {
        file: file.into(),
        line: 1 + lines
            .iter()
            .position(|l| !l.trim_ascii().is_empty())
            .unwrap_or(0),
    };
    // Rows with remarks in them only where there are none without.
    let (way, columns, remarks) = [false, true]
        .into_iter()
        .find_map(|remarks| best_way(&sample, remarks).map(|(way, n)| (way, n, remarks)))
        .ok_or_else(no_numbers)?;
    let delimiter = way.0.byte();
    let is_data = |line: &[u8]| data_cells(line, way, remarks) == Some(columns);
    let first_data = lines
        .iter()
        .position(|line| is_data(line))
        .ok_or_else(no_numbers)?;
    let heading = find_header_line(&lines[..first_data], delimiter, columns);

    let mut settings = ImportSettings {
        delimiter: way.0,
        decimal: way.1,
        skip_lines: heading.as_ref().map_or(first_data, |h| h.next_line),
        ..ImportSettings::default()
    };
    let assumed = assumed_displacement(&lines[first_data..], way, columns);
    let (named, line) = match &heading {
        Some(h) => (h.cells.clone(), h.line + 1),
        None => (Vec::new(), first_data + 1),
    };
    // One name per two cells: "0,001;..." written with commas for both purposes.
    if way.0 == Delimiter::Comma && named.len() >= 2 && columns == 2 * named.len() {
        return Err(ImportError::AmbiguousComma {
            file: file.into(),
            line: first_data + 1,
            cells: columns,
            names: named.len(),
        });
    }
    let mapping = if named.is_empty() {
        header::map_by_count(file, line, columns, assumed, &mut settings)
    } else {
        header::map_header(file, line, &named, assumed, &mut settings)
    };
    let heading_line = heading.as_ref().map_or(settings.skip_lines, |h| h.line);
    let comments = lines[..heading_line]
        .iter()
        .filter(|line| !line.trim_ascii().is_empty())
        .map(|line| show(uncomment(line).unwrap_or(line)))
        .collect();
    let shown = lines[settings.skip_lines..]
        .iter()
        .filter(|line| !is_skipped(line, delimiter))
        .take(SHOWN_ROWS)
        .map(|line| show_row(line, delimiter))
        .collect();
    Ok(Preview {
        name: visible(file),
        size: 0,
        comments,
        columns: columns.max(named.len()),
        header: named,
        rows: shown,
        settings,
        ambiguities: mapping.ambiguities,
        warnings: mapping.warnings,
        problem: mapping.problem,
    })
}

/// The unit of a displacement that names none: metres, unless the numbers would be
/// absurd for it (centimetres at more than 1 kHz), then micrometres.
fn assumed_displacement(
    lines: &[&[u8]],
    way: (Delimiter, Decimal),
    columns: usize,
) -> &'static str {
    let comma = way.1 == Decimal::Comma;
    let numbers = |line: &&[u8]| -> Vec<f64> {
        cells(line, way.0.byte())
            .map(|cell| number::cell(cell, comma, 0))
            .collect()
    };
    let table: Vec<Vec<f64>> = lines.iter().take(MAX_LINES).map(numbers).collect();
    let time: Vec<f64> = table
        .iter()
        .filter_map(|r| r.first().copied())
        .filter(|t| t.is_finite())
        .collect();
    let interval = crate::recording::median_interval(&time);
    let column = columns.saturating_sub(1).min(2);
    let largest = table
        .iter()
        .filter_map(|r| r.get(column).copied())
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest >= 1e-2 && interval < 1e-3 {
        "um"
    } else {
        "m"
    }
}
