//! What can go wrong, or half wrong, when a recording is read.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Why a recording could not be read. Each message names the file, the place and
/// what to do; lines and columns count from 1.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs)] // The fields are the file, the place and the offending text.
pub enum ImportError {
    /// A drive is to be read, and no column is a voltage.
    #[error("{file}, line {line}: there is no voltage column; give a CSV with t [s] and V [V]")]
    NoVoltageColumn { file: String, line: usize },
    #[error("{file}: the file does not exist; check the path, or choose the file again")]
    NotFound { file: String },
    #[error("{file}: this is a folder, not a recording; choose a file in it")]
    IsDirectory { file: String },
    #[error(
        "{file}: this is not an ordinary file (a pipe or a device); copy the data into a file first"
    )]
    NotAFile { file: String },
    #[error("{file}: cannot be read ({reason}); check the permissions and the disk")]
    Unreadable { file: String, reason: String },
    #[error(
        "{file}: {megabytes} MB do not fit into the memory that is free; split the file, or record at a lower rate"
    )]
    TooLarge { file: String, megabytes: u64 },
    #[error("{file}: the file is empty; record or export it again")]
    Empty { file: String },
    #[error("{file}: the text is UTF-16; save it as UTF-8 (\"CSV UTF-8\" in a spreadsheet)")]
    Utf16 { file: String },
    #[error(
        "{file}, line {line}: binary data (byte 0x{byte:02x} at offset {offset}); export the recording as CSV text"
    )]
    Binary {
        file: String,
        line: usize,
        offset: usize,
        byte: u8,
    },
    #[error(
        "{file}, line {line}, column {column}: byte 0x{byte:02x} is not UTF-8 (Latin-1, perhaps); save the file as UTF-8, or write um for \u{b5}m"
    )]
    NotUtf8 {
        file: String,
        line: usize,
        column: usize,
        byte: u8,
    },
    #[error(
        "{file}, line {line}: no rows of numbers from here on; expected a header such as \"t [s], V [V], xp [um], xc [um]\" and rows of numbers separated by comma, semicolon or tab"
    )]
    NoNumbers { file: String, line: usize },
    #[error(
        "{file}, line {line}: rows have {cells} cells but the header names {names} columns, as when numbers with a decimal comma are separated by commas; export with a decimal point, or with semicolons"
    )]
    AmbiguousComma {
        file: String,
        line: usize,
        cells: usize,
        names: usize,
    },
    #[error(
        "{file}, line {line}: no time column among {found}; name one \"t [s]\" (or ms, us), or choose it in the import window"
    )]
    NoTimeColumn {
        file: String,
        line: usize,
        found: String,
    },
    #[error(
        "{file}, line {line}: no position column among {found}; name one \"xp [um]\" (or m, mm, nm), or choose it in the import window"
    )]
    NoPositionColumn {
        file: String,
        line: usize,
        found: String,
    },
    #[error(
        "{file}, line {line}, column {column}: \"{unit}\" is not a unit for {quantity}; write {expected}"
    )]
    UnknownUnit {
        file: String,
        line: usize,
        column: usize,
        unit: String,
        quantity: String,
        expected: String,
    },
    #[error(
        "{file}, line {line}, column {column}: {symbol} has no cell that is a number (here \"{cell}\"); check the column, the delimiter and the decimal mark"
    )]
    EmptyColumn {
        file: String,
        line: usize,
        column: usize,
        symbol: String,
        cell: String,
    },
    #[error(
        "{file}, line {line}, column {column}: time goes backwards in {count} of {rows} rows; sort the rows by time, or choose another time column"
    )]
    TimeBackwards {
        file: String,
        line: usize,
        column: usize,
        count: usize,
        rows: usize,
    },
    #[error(
        "{file}, line {line}, column {column}: only {rows} usable rows; a recording needs at least two with increasing time"
    )]
    TooFewRows {
        file: String,
        line: usize,
        column: usize,
        rows: usize,
    },
    #[error("{file}: import setting {setting} is {value}; give a finite number")]
    BadSetting {
        file: String,
        setting: &'static str,
        value: String,
    },
    #[error("{file}: import stopped")]
    Cancelled { file: String },
}

/// What kind of partial problem a warning is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WarningKind {
    /// Cells that are not numbers; they become NaN.
    NotANumber,
    /// Rows whose time is not a number; dropped.
    TimeNotANumber,
    /// Rows whose time does not increase; dropped.
    TimeNotIncreasing,
    /// Steps of more than five median intervals.
    Gap,
    /// The last line was cut and is dropped.
    CutLastLine,
    /// The time unit seems wrong for the sampling interval.
    UnlikelyTimeUnit,
    /// No header: columns were guessed from their number.
    NoHeader,
    /// A column was recognised by its unit only.
    GuessedColumn,
    /// A column carries no unit; one was assumed.
    AssumedUnit,
    /// Two columns have the same meaning; the first is used.
    DuplicateColumn,
    /// A column has a known name but a unit that does not fit, or no numbers; left out.
    IgnoredColumn,
}

/// A partial problem: the recording was read, but the user should know.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImportWarning {
    /// What kind of problem.
    pub kind: WarningKind,
    /// How often it occurs.
    pub count: usize,
    /// Line of the first occurrence, from 1.
    pub first_line: Option<usize>,
    /// The whole sentence, for the screen.
    pub message: String,
}
