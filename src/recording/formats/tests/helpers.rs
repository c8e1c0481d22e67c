//! The recording that all test files hold, and how a file is read.

use crate::recording::formats::raw_table::{RawColumn, RawTable, SampleClock};
use crate::recording::formats::{FormatContent, HEAD_BYTES, recognise};

/// A file of `assets/test_files/formats`.
macro_rules! test_file {
    ($name:literal) => {
        (
            $name,
            include_bytes!(concat!("../../../../assets/test_files/formats/", $name)) as &[u8],
        )
    };
}
pub(super) use test_file;

/// Rows of the recording in the test files.
pub const ROWS: usize = 12;
/// Its clock, from 0.
pub const INTERVAL: f64 = 0.00025;

/// A column of the recording in the test files, by row.
fn by_row(value: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..ROWS).map(|i| value(i as f64)).collect()
}

/// Times \[s\].
pub fn t() -> Vec<f64> {
    by_row(|i| INTERVAL * i)
}

/// Voltage: 8, 8, -8, -8, ...
pub fn v() -> Vec<f64> {
    by_row(|i| if i % 4.0 < 2.0 { 8.0 } else { -8.0 })
}

/// Displacement.
pub fn xp() -> Vec<f64> {
    by_row(|i| i - 0.5 * i * i)
}

/// Values times a factor.
pub fn times(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| v * factor).collect()
}

/// Reads a file by the format that recognises it.
pub fn read((name, bytes): (&str, &[u8])) -> Result<FormatContent, String> {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    let format = recognise(head, name).ok_or("no format")?;
    format.read(name, bytes).map_err(|error| error.to_string())
}

/// The tables of a file.
pub fn tables(file: (&str, &[u8])) -> Vec<RawTable> {
    match read(file) {
        Ok(FormatContent::Tables(tables)) => tables,
        other => panic!("{}: {other:?}", file.0),
    }
}

/// The only table of a file.
pub fn table(file: (&str, &[u8])) -> RawTable {
    let mut tables = tables(file);
    assert_eq!(tables.len(), 1, "{}: {tables:?}", file.0);
    tables.remove(0)
}

/// Why a file is refused.
pub fn refusal(file: (&str, &[u8])) -> String {
    read(file).expect_err(file.0)
}

/// A column by its name.
pub fn column<'a>(table: &'a RawTable, name: &str) -> &'a RawColumn {
    table
        .columns
        .iter()
        .find(|column| column.name == name)
        .unwrap_or_else(|| panic!("no {name} in {table:?}"))
}

/// The values of a column by its name.
pub fn values(table: &RawTable, name: &str) -> Vec<f64> {
    column(table, name).values.clone()
}

/// Names of the columns.
pub fn names(table: &RawTable) -> Vec<&str> {
    table.columns.iter().map(|c| c.name.as_str()).collect()
}

/// The unit of a column.
pub fn unit<'a>(table: &'a RawTable, name: &str) -> Option<&'a str> {
    column(table, name).unit.as_deref()
}

/// A clock.
pub fn clock(start: f64, interval: f64) -> Option<SampleClock> {
    SampleClock::new(start, interval)
}

/// Whether a note holds all of `words`.
pub fn notes_say(table: &RawTable, words: &[&str]) -> bool {
    let holds = |note: &String| words.iter().all(|word| note.contains(word));
    table.notes.iter().any(holds)
}
