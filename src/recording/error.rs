//! What can go wrong, or half wrong, when a recording is read.

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Longest text from a file in a message \[characters\]: that of a path.
const MAX_SHOWN_CHARS: usize = 4096;

/// `text` as it may stand in a message: what a terminal would obey (escape sequences, line ends, bells,
/// marks that turn the direction of writing) is written as `\u{1b}`, `\r` and so on; a tabulator is a
/// space.
pub(crate) fn visible(text: &str) -> String {
    let unseen = |c: char| {
        c.is_control()
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let mut shown = String::with_capacity(text.len());
    for c in text.chars().take(MAX_SHOWN_CHARS) {
        match c {
            '\t' => shown.push(' '),
            '\r' | '\n' => shown.extend(c.escape_default()),
            c if unseen(c) => shown.extend(c.escape_unicode()),
            c => shown.push(c),
        }
    }
    if text.chars().nth(MAX_SHOWN_CHARS).is_some() {
        shown.push_str("...");
    }
    shown
}

/// Text from a file, or a file's name, inside an error: kept as it is, shown as [`visible`] says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileText(String);

impl<T: Into<String>> From<T> for FileText {
    fn from(text: T) -> Self {
        Self(text.into())
    }
}

impl fmt::Display for FileText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&visible(&self.0))
    }
}

/// Why a recording could not be read. Each message names the file, the place and
/// what to do; lines and columns count from 1.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs)] // The fields are the file, the place and the offending text.
pub enum ImportError {
    /// A file of a known format could not be read; the message says what, where and what to do.
    #[error("{0}")]
    Format(FileText),
    /// Recordings cannot be put together; the message says which, why and what to do.
    #[error("{0}")]
    Combine(FileText),
    /// A drive is to be read, and no column is a voltage.
    #[error("{file}, line {line}: there is no voltage column; give a CSV with t [s] and V [V]")]
    NoVoltageColumn { file: FileText, line: usize },
    #[error("{file}: the file does not exist; check the path, or choose the file again")]
    NotFound { file: FileText },
    #[error("{file}: this is a folder, not a recording; choose a file in it")]
    IsDirectory { file: FileText },
    #[error(
        "{file}: this is not an ordinary file (a pipe or a device); copy the data into a file first"
    )]
    NotAFile { file: FileText },
    #[error("{file}: cannot be read ({reason}); check the permissions and the disk")]
    Unreadable { file: FileText, reason: FileText },
    #[error(
        "{file}: {megabytes} MB do not fit into the memory that is free; split the file, or record at a lower rate"
    )]
    TooLarge { file: FileText, megabytes: u64 },
    #[error("{file}: the file is empty; record or export it again")]
    Empty { file: FileText },
    #[error(
        "{file}, line {line}: binary data (byte 0x{byte:02x} at offset {offset}); export the recording as CSV text"
    )]
    Binary {
        file: FileText,
        line: usize,
        offset: usize,
        byte: u8,
    },
    #[error(
        "{file}, line {line}: no rows of numbers from here on; expected a header such as \"t [s], V [V], xp [um], xc [um]\" and rows of numbers separated by comma, semicolon, tab, pipe or blanks"
    )]
    NoNumbers { file: FileText, line: usize },
    #[error(
        "{file}, line {line}: rows have {cells} cells but the header names {names} columns, as when numbers with a decimal comma are separated by commas; export with a decimal point, or with semicolons"
    )]
    AmbiguousComma {
        file: FileText,
        line: usize,
        cells: usize,
        names: usize,
    },
    #[error(
        "{file}, line {line}: no time column among {found}; name one \"t [s]\" (or ms, us), choose one with --column t=NAME or in the import window, or give --dt or --rate"
    )]
    NoTimeColumn {
        file: FileText,
        line: usize,
        found: FileText,
    },
    #[error(
        "{file}, line {line}: this is a spectrum ({found}), not a recording in time; export the time signal"
    )]
    Spectrum {
        file: FileText,
        line: usize,
        found: FileText,
    },
    #[error(
        "{file}, line {line}: no position column among {found}; name one \"xp [um]\" (or m, mm, nm), or choose one with --column xp=NAME or in the import window"
    )]
    NoPositionColumn {
        file: FileText,
        line: usize,
        found: FileText,
    },
    #[error(
        "{file}, line {line}, column {column}: \"{unit}\" is not a unit for {quantity}; write {expected}"
    )]
    UnknownUnit {
        file: FileText,
        line: usize,
        column: usize,
        unit: FileText,
        quantity: String,
        expected: String,
    },
    #[error(
        "{file}, line {line}, column {column}: {symbol} has no cell that is a number (here \"{cell}\"); check the column, the delimiter and the decimal mark"
    )]
    EmptyColumn {
        file: FileText,
        line: usize,
        column: usize,
        symbol: String,
        cell: FileText,
    },
    #[error(
        "{file}, line {line}, column {column}: time goes backwards in {count} of {rows} rows; sort the rows by time, or choose another time column"
    )]
    TimeBackwards {
        file: FileText,
        line: usize,
        column: usize,
        count: usize,
        rows: usize,
    },
    #[error(
        "{file}, line {line}, column {column}: only {rows} usable rows; a recording needs at least two with increasing time"
    )]
    TooFewRows {
        file: FileText,
        line: usize,
        column: usize,
        rows: usize,
    },
    /// A column is to be read that no row has.
    #[error(
        "{file}, line {line}: {symbol} is to be read from column {column}, but there are only {cells} columns; choose another column in the import settings"
    )]
    NoSuchColumn {
        file: FileText,
        line: usize,
        column: usize,
        symbol: String,
        cells: usize,
    },
    /// The rows that are left hold no displacement.
    #[error(
        "{file}, line {line}, column {column}: no row has both a time that can be used and a number for {symbol}; check both columns"
    )]
    NoUsableRow {
        file: FileText,
        line: usize,
        column: usize,
        symbol: String,
    },
    /// Times that differ in the file are the same number after the offset.
    #[error(
        "{file}: with a time offset of {offset} s neighbouring times are the same number; give a smaller offset"
    )]
    OffsetTooLarge { file: FileText, offset: FileText },
    #[error(
        "{file}: --column {choice} takes column {column} (\"{name}\"), which another channel has: one column twice; give each its own (a name that is a number goes before a place)"
    )]
    ColumnTwice {
        file: FileText,
        choice: FileText,
        column: usize,
        name: FileText,
    },
    #[error("{file}: import setting {setting} is {value}; give a finite number")]
    BadSetting {
        file: FileText,
        setting: &'static str,
        value: FileText,
    },
    /// More than one reading is possible.
    #[error("{file}, line {line}: {question}; decide with {options}, or in the import window")]
    Undecided {
        file: FileText,
        line: usize,
        question: FileText,
        options: FileText,
    },
    /// A motion or a voltage is in a unit of another quantity, and nothing says what it stands for.
    #[error(
        "{file}, line {line}, column {column}: {symbol} is in \"{unit}\"; say what one {unit} stands for, for example with --scale {symbol}={example}"
    )]
    NeedsScale {
        file: FileText,
        line: usize,
        column: usize,
        unit: FileText,
        symbol: String,
        example: FileText,
    },
    #[error(
        "{file}, column {column}: \"{scale}\" is no scale from \"{unit}\" to {base}; write for example --scale {symbol}=0.5um/V"
    )]
    BadScale {
        file: FileText,
        column: usize,
        scale: FileText,
        unit: FileText,
        symbol: &'static str,
        base: &'static str,
    },
    /// A file with several recordings.
    #[error(
        "{file}: there are {count} recordings in the file ({names}); choose one with --trial N"
    )]
    SeveralRecordings {
        file: FileText,
        count: usize,
        names: FileText,
    },
    #[error(
        "{file}: recording {trial} is asked for, but the file holds {count}; choose one of them"
    )]
    NoSuchTrial {
        file: FileText,
        trial: usize,
        count: usize,
    },
    /// More rows would be lost than a few.
    #[error(
        "{file}, line {line}: {lost} of {rows} rows have no time that can be used ({reason}); mend the file, choose another time column, or accept the loss with --accept-losses"
    )]
    RowsLost {
        file: FileText,
        line: usize,
        lost: usize,
        rows: usize,
        reason: FileText,
    },
    /// The numbers of the time column change their unit midway.
    #[error(
        "{file}, line {line}: the unit of time changes between rows ({before}, then {after}): the recorder wrote some times in another unit; multiply them, or export again"
    )]
    TimeUnitChanges {
        file: FileText,
        line: usize,
        before: FileText,
        after: FileText,
    },
    /// Rows get another number of cells midway.
    #[error(
        "{file}, line {line}: from here on rows have {after} cells, before {before}: a column was added or removed, so that columns may have moved; split the file here, or accept the columns as they are with --accept-losses"
    )]
    ColumnsChange {
        file: FileText,
        line: usize,
        before: usize,
        after: usize,
    },
    /// An option names a column that the file does not have.
    #[error("{file}: no column is called \"{name}\"; the columns are {found}")]
    NoColumnNamed {
        file: FileText,
        name: FileText,
        found: FileText,
    },
    #[error("{file}: import stopped")]
    Cancelled { file: FileText },
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
    /// Times count from the first row, which is not at 0 in the file.
    TimeOrigin,
    /// Times were rounded; those of the even clock behind them are used.
    RoundedTimes,
    /// Stamps that jitter around an even clock; its times are used.
    TimeJitter,
    /// The samples are not evenly spaced; the times are used as they are.
    UnevenSampling,
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
    /// Another column could have the same meaning; it is not used.
    DuplicateColumn,
    /// Readings out of the instrument's range; they become NaN.
    Overrange,
    /// Marks between thousands were taken out.
    ThousandsMarks,
    /// The text is in another encoding than UTF-8, or zero bytes were cut off.
    TextEncoding,
    /// Lines of text among or after the rows were left out.
    TextRows,
    /// Rows were turned round or sorted by time.
    RowsReordered,
    /// A counter began again at zero; what it had counted was added.
    CounterWrap,
    /// Times come from a sampling rate, not from a column of times.
    SampleClock,
    /// Times were converted from days, clock times or the like.
    ConvertedTime,
    /// A velocity or an acceleration was integrated.
    Integrated,
    /// Rows have different numbers of cells.
    ColumnsChange,
    /// What a format has to say of itself: a scale that was applied, a table that is not read.
    FormatNote,
    /// A column has a known name but a unit that does not fit, or no numbers; left out.
    IgnoredColumn,
    /// What a unit of the instrument stands for was answered before.
    KnownSensitivity,
    /// Trials were averaged: how they lie over each other and differ.
    Averaged,
    /// Two runs with one point each were merged: their lag, and how their voltages agree.
    Merged,
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

impl ImportWarning {
    /// A warning; what the sentence quotes from a file is made visible.
    pub(crate) fn new(
        kind: WarningKind,
        count: usize,
        first_line: Option<usize>,
        message: &str,
    ) -> Self {
        Self {
            kind,
            count,
            first_line,
            message: visible(message),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::error::*;

    #[test]
    fn nothing_reaches_a_terminal_that_it_would_obey() {
        let hostile = "a\u{1b}[31mb\u{7}c\0d\re\nf\u{9b}2Jg\u{202e}h\ti";
        let shown = "a\\u{1b}[31mb\\u{7}c\\u{0}d\\re\\nf\\u{9b}2Jg\\u{202e}h i";
        assert_eq!(visible(hostile), shown);
        let error = ImportError::UnknownUnit {
            file: hostile.into(),
            line: 1,
            column: 2,
            unit: hostile.into(),
            quantity: "time".to_owned(),
            expected: "s".to_owned(),
        };
        let message = error.to_string();
        assert!(!message.contains(char::is_control), "{message:?}");
        assert_eq!(message.matches(shown).count(), 2);
        let warning = ImportWarning::new(WarningKind::GuessedColumn, 1, None, hostile);
        assert_eq!(warning.message, shown);
        assert_eq!(visible("xp [\u{b5}m] f\u{fc}r"), "xp [\u{b5}m] f\u{fc}r");
        assert_eq!(visible(&"x".repeat(9999)).len(), MAX_SHOWN_CHARS + 3);
    }
}
