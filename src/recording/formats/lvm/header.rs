//! The two kinds of header.

use super::super::bytes::text;
use super::super::error::{FileContext, FormatError};
use super::super::lines::Lines;

/// End of either header.
const END_OF_HEADER: &[u8] = b"***End_of_Header***";
/// Name of a column of times.
const X_VALUE: &str = "X_Value";
/// Name of the last column, for text.
const COMMENT: &str = "Comment";
/// Most columns of a segment. NI's loggers have some hundred.
const MAX_COLUMNS: usize = 4096;

/// What holds for the whole file.
#[derive(Debug)]
pub(super) struct FileHeader {
    /// Between two cells.
    pub separator: u8,
    /// `.` or `,`; `None` until a number shows it.
    pub decimal: Option<u8>,
    /// Which columns of times there are: `No`, `One`, `Multi`.
    x_columns: Option<String>,
}

impl FileHeader {
    /// Reads to the end of the file's header.
    pub fn read(context: &FileContext, lines: &mut Lines) -> Result<Self, FormatError> {
        let mut header = Self {
            separator: b'\t',
            decimal: None,
            x_columns: None,
        };
        lines.next();
        for line in lines.by_ref() {
            if line.starts_with(END_OF_HEADER) {
                return Ok(header);
            }
            let mut cells = line.splitn(2, |b| *b == b'\t' || *b == b',');
            let key = cells.next().unwrap_or_default();
            let value = cells.next().unwrap_or_default().trim_ascii();
            // With commas between cells, the file's header ends its lines with one.
            let bare = value.strip_suffix(b",").unwrap_or(value);
            match key {
                b"Separator" => header.separator = if bare == b"Comma" { b',' } else { b'\t' },
                b"Decimal_Separator" => {
                    header.decimal = value.first().copied().filter(|b| b".,".contains(b));
                }
                b"X_Columns" => header.x_columns = Some(text(bare)),
                _ => {}
            }
        }
        Err(context.truncated(lines.at(), "the header"))
    }

    /// What a user should know of it.
    pub fn notes(&self) -> Vec<String> {
        match self.x_columns.as_deref() {
            None => vec!["The header does not say X_Columns; times are taken from columns named X_Value that hold numbers.".to_owned()],
            Some(_) => Vec::new(),
        }
    }

    /// The cells of a line.
    pub fn cells<'a>(&self, line: &'a [u8]) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let separator = self.separator;
        line.split(move |b| *b == separator)
    }

    /// A number as this file writes it.
    pub fn number(&self, cell: &[u8]) -> Option<f64> {
        number(cell, self.decimal.unwrap_or(b'.'))
    }
}

/// A number; `None` for text.
pub(super) fn number(cell: &[u8], decimal: u8) -> Option<f64> {
    let cell = cell.trim_ascii();
    if decimal != b',' {
        return std::str::from_utf8(cell).ok()?.parse().ok();
    }
    // Numbers of measurements are shorter.
    let mut point = [0_u8; 64];
    let copy = point.get_mut(..cell.len())?;
    copy.copy_from_slice(cell);
    if let Some(mark) = copy.iter_mut().find(|b| **b == b',') {
        *mark = b'.';
    }
    std::str::from_utf8(copy).ok()?.parse().ok()
}

/// What a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Times of the columns after it.
    Times,
    /// A channel.
    Channel,
    /// Text.
    Comment,
}

/// A column of a segment.
#[derive(Debug, Clone)]
pub(super) struct ColumnHeader {
    pub role: Role,
    pub name: String,
    pub unit: Option<String>,
    pub dimension: String,
    /// `X0`: time of its first sample \[s\].
    pub start: Option<f64>,
    /// `Delta_X`: time between its samples \[s\].
    pub interval: Option<f64>,
}

/// The header of one segment.
#[derive(Debug)]
pub(super) struct SegmentHeader {
    pub columns: Vec<ColumnHeader>,
    /// Date and time of its first sample, in seconds from an arbitrary day.
    pub instant: Option<f64>,
    /// For the user.
    pub notes: Vec<String>,
}

/// Values of a header line by column.
#[derive(Default)]
struct Keys {
    units: Vec<String>,
    dimensions: Vec<String>,
    starts: Vec<String>,
    intervals: Vec<String>,
    dates: Vec<String>,
    times: Vec<String>,
    any: bool,
}

impl SegmentHeader {
    /// Reads the next header and the line of names below; `None` at the end of the file.
    pub fn read(
        context: &FileContext,
        file: &mut FileHeader,
        lines: &mut Lines,
    ) -> Result<Option<Self>, FormatError> {
        let mut keys = Keys::default();
        let mut notes = Vec::new();
        let mut special = 0_usize;
        loop {
            let Some(line) = lines.next() else {
                // Blank lines at the end of the file.
                return if keys.any {
                    Err(context.truncated(lines.at(), "the header of a segment"))
                } else {
                    Ok(None)
                };
            };
            if line.starts_with(END_OF_HEADER) {
                break;
            }
            if line.starts_with(b"***Start_Special***") {
                special += 1;
                lines
                    .by_ref()
                    .find(|line| line.starts_with(b"***End_Special***"));
                continue;
            }
            let cells: Vec<String> = file
                .cells(line)
                .take(MAX_COLUMNS)
                .map(|cell| text(cell.trim_ascii()))
                .collect();
            let key = cells.first().cloned().unwrap_or_default();
            keys.any |= !key.is_empty();
            match key.as_str() {
                "Y_Unit_Label" => keys.units = cells,
                "X_Dimension" => keys.dimensions = cells,
                "X0" => keys.starts = cells,
                "Delta_X" => keys.intervals = cells,
                "Date" => keys.dates = cells,
                "Time" => keys.times = cells,
                "Notes" => {
                    let words: Vec<_> = cells
                        .into_iter()
                        .skip(1)
                        .filter(|c| !c.is_empty())
                        .collect();
                    notes.push(format!("The file notes: {}.", words.join(" ")));
                }
                _ => {}
            }
        }
        if special > 0 {
            notes.push(format!(
                "{special} special blocks of a segment are not read."
            ));
        }
        let Some(names) = lines.next() else {
            return Err(context.truncated(lines.at(), "the names of a segment's columns"));
        };
        if file.decimal.is_none() {
            let numbers = keys.starts.iter().chain(&keys.intervals);
            let comma = file.separator != b',' && numbers.clone().any(|cell| cell.contains(','));
            file.decimal = Some(if comma { b',' } else { b'.' });
            notes.push(format!(
                "The header does not say the decimal mark; \"{}\" was taken.",
                if comma { ',' } else { '.' }
            ));
        }
        let columns = Self::columns(context, file, &keys, names, lines.number())?;
        let at = |cells: &[String]| cells.get(1).cloned().unwrap_or_default();
        Ok(Some(Self {
            columns,
            instant: instant(&at(&keys.dates), &at(&keys.times)),
            notes,
        }))
    }

    fn columns(
        context: &FileContext,
        file: &FileHeader,
        keys: &Keys,
        names: &[u8],
        line: usize,
    ) -> Result<Vec<ColumnHeader>, FormatError> {
        let names: Vec<String> = file
            .cells(names)
            .map(|cell| text(cell.trim_ascii()))
            .collect();
        if names.len() > MAX_COLUMNS {
            return Err(context.malformed_line(line, format!("there are {} columns", names.len())));
        }
        if !names.iter().any(|name| name == X_VALUE) {
            return Err(context.malformed_line(line, "no column is named X_Value"));
        }
        let last = names.iter().rposition(|name| !name.is_empty()).unwrap_or(0);
        let at =
            |cells: &[String], index: usize| cells.get(index).filter(|c| !c.is_empty()).cloned();
        let mut columns = Vec::with_capacity(names.len());
        for (index, name) in names.into_iter().take(last + 1).enumerate() {
            let role = match name.as_str() {
                X_VALUE => Role::Times,
                COMMENT if index == last => Role::Comment,
                _ => Role::Channel,
            };
            let number =
                |cells: &[String]| at(cells, index).and_then(|cell| file.number(cell.as_bytes()));
            columns.push(ColumnHeader {
                role,
                name,
                unit: at(&keys.units, index),
                dimension: at(&keys.dimensions, index).unwrap_or_default(),
                start: number(&keys.starts),
                interval: number(&keys.intervals),
            });
        }
        Ok(columns)
    }

    /// Whether the first channel is over frequency.
    pub fn is_spectrum(&self) -> bool {
        self.columns
            .iter()
            .any(|column| column.dimension == "Frequency")
    }
}

/// Seconds from an arbitrary day to `2016/08/23`, `10:45:47.035`.
fn instant(date: &str, time: &str) -> Option<f64> {
    let mut ymd = date.split('/').map(str::parse::<i32>);
    let (year, month, day) = (ymd.next()?.ok()?, ymd.next()?.ok()?, ymd.next()?.ok()?);
    if !(1..=9999).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Days by Hinnant's civil calendar: years begin in March, so that leap days end them.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day;
    let mut seconds = 0.0;
    let time = time.replace(',', ".");
    for (part, scale) in time.split(':').zip([3600.0, 60.0, 1.0]) {
        seconds += scale * part.parse::<f64>().ok()?;
    }
    Some(f64::from(days) * 86400.0 + seconds).filter(|t| t.is_finite())
}
