//! The beginning of a file, to preview it with other delimiters than the guessed one.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui::Context;

use crate::recording::csv::{Decimal, Delimiter};

/// Bytes read for the preview.
const SAMPLE_BYTES: u64 = 256 << 10;
/// Rows shown in the preview.
const SAMPLE_ROWS: usize = 20;

/// The first lines of a file, read in a thread of their own.
#[derive(Debug)]
pub struct Sample {
    coming: Option<Receiver<Vec<String>>>,
    lines: Vec<String>,
}

/// Lines split into cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cells {
    /// Names of the columns; empty without a header.
    pub header: Vec<String>,
    /// Number of columns.
    pub columns: usize,
    /// The first rows, at most 20.
    pub rows: Vec<Vec<String>>,
}

impl Sample {
    /// Starts reading; asks for a repaint when done.
    pub fn read(path: PathBuf, context: &Context) -> Self {
        let (send, coming) = channel();
        let context = context.clone();
        let started = std::thread::Builder::new()
            .name("sample".to_owned())
            .spawn(move || {
                // The dialog may be closed meanwhile.
                let _ = send.send(head(&path).unwrap_or_default());
                context.request_repaint();
            });
        Self {
            coming: started.is_ok().then_some(coming),
            lines: Vec::new(),
        }
    }

    /// The lines after the first `skip`, split; `None` while the file is being read.
    pub fn split(&mut self, delimiter: Delimiter, skip: usize) -> Option<Cells> {
        if let Some(coming) = &self.coming {
            match coming.try_recv() {
                Ok(lines) => self.lines = lines,
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => {}
            }
            self.coming = None;
        }
        Some(split(&self.lines, delimiter, skip))
    }
}

/// The first lines. Bytes that are not text become replacement characters.
fn head(path: &Path) -> std::io::Result<Vec<String>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?
        .take(SAMPLE_BYTES)
        .read_to_end(&mut bytes)?;
    let cut = bytes.len() as u64 == SAMPLE_BYTES;
    let text = String::from_utf8_lossy(&bytes);
    Ok(lines(text.trim_start_matches('\u{feff}'), cut))
}

/// Lines of a text, without the last one if the text was `cut`.
fn lines(text: &str, cut: bool) -> Vec<String> {
    let newline = if text.contains('\n') { '\n' } else { '\r' };
    let mut lines: Vec<String> = text
        .split(newline)
        .map(|line| line.trim_end_matches('\r').to_owned())
        .collect();
    if cut || lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
    lines
}

fn split(lines: &[String], delimiter: Delimiter, skip: usize) -> Cells {
    let skip = skip.min(lines.len());
    let header = lines[..skip]
        .iter()
        .rev()
        .map(|line| line.trim_start_matches(['#', '%']).trim())
        .find(|line| !line.is_empty())
        .map(|line| cells(line, delimiter))
        .unwrap_or_default();
    let rows: Vec<Vec<String>> = lines[skip..]
        .iter()
        .filter(|line| !line.trim().is_empty())
        .take(SAMPLE_ROWS)
        .map(|line| cells(line, delimiter))
        .collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    Cells {
        header,
        columns,
        rows,
    }
}

/// Splits one line at a time, so that an unpaired quote does not affect other lines.
fn cells(line: &str, delimiter: Delimiter) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter.byte())
        .from_reader(line.as_bytes());
    match reader.records().next() {
        Some(Ok(record)) => record
            .iter()
            .map(|cell| cell.trim().chars().take(60).collect())
            .collect(),
        _ => vec![line.to_owned()],
    }
}

/// Whether a cell is a number; others are marked.
pub fn is_number(cell: &str, decimal: Decimal) -> bool {
    let cell = cell.trim().trim_matches('"');
    match decimal {
        Decimal::Point => cell.parse::<f64>().is_ok(),
        Decimal::Comma => cell.replacen(',', ".", 1).parse::<f64>().is_ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::*;

    #[test]
    fn lines_are_split_by_the_chosen_delimiter() {
        let text = lines("# t [s]; x [um]\r\n0,5;\"1\"\r\n1,5;2\r\n", false);
        let found = split(&text, Delimiter::Semicolon, 1);
        assert_eq!(found.header, ["t [s]", "x [um]"]);
        assert_eq!(found.columns, 2);
        assert_eq!(found.rows, [["0,5", "1"], ["1,5", "2"]]);
        let found = split(&text, Delimiter::Tab, 99);
        assert_eq!((found.columns, found.rows.len()), (0, 0));
        assert_eq!(lines("1,2\r3,4\r5", true), ["1,2", "3,4"]);
        assert_eq!(split(&[], Delimiter::Comma, 3), Cells::default());
    }

    #[test]
    fn an_unpaired_quote_affects_one_row_only() {
        let text = lines("1,\"2\n3,4\n", false);
        assert_eq!(split(&text, Delimiter::Comma, 0).rows[1], ["3", "4"]);
    }

    #[test]
    fn numbers_follow_the_decimal_sign() {
        assert!(is_number("1,5", Decimal::Comma) && !is_number("1,5", Decimal::Point));
        assert!(is_number("1.5e-3", Decimal::Point) && is_number("-2", Decimal::Comma));
        assert!(!is_number("", Decimal::Point) && !is_number("x", Decimal::Comma));
    }
}
