//! Excel workbooks (`.xlsx`, `.xlsm`), by `calamine`: each sheet with numbers is a table.
//!
//! Cells are read one after the other, so that a sheet is as large as its cells, not as its
//! corners say.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use calamine::{DataRef, Reader, Xlsx as Workbook};

use super::archive::{check_size, first_entry, is_zip, open};
use super::arrays::{finish, listed};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::sheet_header::{SheetText, header};
use crate::recording::csv::{TextMarks, is_number_in_text};
use crate::recording::formats::raw_table::{RawColumn, RawTable};

/// Reads `.xlsx` files.
#[derive(Debug)]
pub struct Xlsx;

const NAME: &str = "Excel";
/// Rows at the top whose text is kept as a possible header; below them text is a missing number.
const MAX_HEADER_ROWS: u32 = 200;
/// Cells that a sheet may leave empty beyond [`MAX_EMPTY_SHARE`]: 128 MB.
const MAX_EMPTY_CELLS: usize = 1 << 24;
/// Empty cells for each one that is there; a table has fewer than one.
const MAX_EMPTY_SHARE: usize = 16;

impl Format for Xlsx {
    fn id(&self) -> &'static str {
        "xlsx"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["xlsx", "xlsm"]
    }

    fn recognises(&self, head: &[u8], file_name: &str) -> bool {
        let name = file_name.to_ascii_lowercase();
        let parts: [&[u8]; 4] = [b"[Content_Types].xml", b"_rels/", b"docProps/", b"xl/"];
        let is_office =
            first_entry(head).is_some_and(|entry| parts.iter().any(|part| entry.starts_with(part)));
        is_zip(head) && (is_office || name.ends_with(".xlsx") || name.ends_with(".xlsm"))
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        read_workbook(&FileContext { file, format: NAME }, bytes)
    }
}

/// All sheets of a workbook.
pub(super) fn read_workbook(
    context: &FileContext,
    bytes: &[u8],
) -> Result<FormatContent, FormatError> {
    let context = FileContext {
        format: NAME,
        ..*context
    };
    check_size(&context, &mut open(&context, bytes)?)?;
    // Ranges that end before they begin overflow in calamine 0.38 (`get_dimension`) where the build
    // checks for it. Nothing of the workbook outlives the call.
    let read = AssertUnwindSafe(|| read_sheets(&context, bytes));
    catch_unwind(read).unwrap_or_else(|_| Err(context.unreadable("a cell or range is not valid")))
}

/// [`read_workbook`] after the archive was checked.
fn read_sheets(context: &FileContext, bytes: &[u8]) -> Result<FormatContent, FormatError> {
    let mut workbook: Workbook<_> =
        Workbook::new(Cursor::new(bytes)).map_err(|error| context.unreadable(error))?;
    let mut tables = Vec::new();
    let mut without = Vec::new();
    for name in workbook.sheet_names() {
        let Some(sheet) = read_sheet(context, &mut workbook, &name)? else {
            without.push(name);
            continue;
        };
        let epoch_1904 = workbook.has_1904_epoch();
        match sheet.table(&name, epoch_1904) {
            Some(table) => tables.push(table),
            None => without.push(name),
        }
    }
    if tables.is_empty() {
        let found = format!("sheets: {}", listed(&without));
        return Err(context.no_numbers(found));
    }
    if !without.is_empty() {
        let note = format!("Sheets without a table of numbers: {}.", listed(&without));
        for table in &mut tables {
            table.notes.push(note.clone());
        }
    }
    Ok(FormatContent::Tables(finish(tables)))
}

/// A sheet's cells, by column.
#[derive(Debug, Default)]
struct Sheet {
    columns: BTreeMap<u32, Column>,
    /// Text of the first rows: row, column, text.
    texts: Vec<SheetText>,
    /// Cells that are there.
    cells: usize,
    /// Cells that memory is held for.
    held: usize,
}

/// One column of a sheet.
#[derive(Debug, Default)]
struct Column {
    /// By row; NaN where there is no number.
    values: Vec<f64>,
    /// Numbers that are stored as text: row, text.
    text_numbers: Vec<(u32, String)>,
    /// Cells that are dates or times of day.
    dates: usize,
    /// Cells of text or errors below the first rows or among the numbers: row, text.
    other: Vec<(u32, String)>,
}

/// The cells of a sheet; `None` for a chart.
fn read_sheet(
    context: &FileContext,
    workbook: &mut Workbook<Cursor<&[u8]>>,
    name: &str,
) -> Result<Option<Sheet>, FormatError> {
    let mut reader = match workbook.worksheet_cells_reader(name) {
        Ok(reader) => reader,
        Err(calamine::XlsxError::NotAWorksheet(_)) => return Ok(None),
        Err(error) => return Err(context.unreadable(format!("sheet \"{name}\": {error}"))),
    };
    let mut sheet = Sheet::default();
    loop {
        let cell = reader
            .next_cell()
            .map_err(|error| context.unreadable(format!("sheet \"{name}\": {error}")))?;
        let Some(cell) = cell else {
            return Ok(Some(sheet));
        };
        let (row, column) = cell.get_position();
        if !sheet.add(row, column, cell.get_value()) {
            return Err(context.unsupported(
                format!("the cells of sheet \"{name}\" lie far apart (row {row})"),
                "copy the table alone into a new workbook, or save it as CSV",
            ));
        }
    }
}

impl Sheet {
    /// Adds a cell; `false` if the sheet has too much empty space.
    fn add(&mut self, row: u32, index: u32, value: &DataRef) -> bool {
        self.cells += 1;
        let column = self.columns.entry(index).or_default();
        let number = match value {
            DataRef::Empty => return true,
            DataRef::Int(v) => *v as f64,
            DataRef::Float(v) => *v,
            DataRef::Bool(v) => f64::from(u8::from(*v)),
            DataRef::DateTime(v) => {
                column.dates += 1;
                v.as_f64()
            }
            DataRef::Error(error) => {
                column.other.push((row, error.to_string()));
                return true;
            }
            DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => {
                return self.add_text(row, index, text);
            }
            DataRef::SharedString(text) => return self.add_text(row, index, text),
        };
        self.put(row, index, number)
    }

    /// Puts a number, NaN to hold its place; `false` if the sheet has too much empty space.
    fn put(&mut self, row: u32, index: u32, number: f64) -> bool {
        let column = self.columns.entry(index).or_default();
        let at = row as usize;
        if column.values.len() <= at {
            self.held += at + 1 - column.values.len();
            if self.held > MAX_EMPTY_CELLS + MAX_EMPTY_SHARE * self.cells {
                return false;
            }
            column.values.resize(at + 1, f64::NAN);
        }
        if let Some(slot) = column.values.get_mut(at) {
            *slot = number;
        }
        true
    }

    /// Text that is a number, a header, or neither; `false` as [`Self::put`].
    fn add_text(&mut self, row: u32, index: u32, text: &str) -> bool {
        let text = text.trim();
        if text.is_empty() {
            return true;
        }
        let column = self.columns.entry(index).or_default();
        if is_number_in_text(text) {
            column.text_numbers.push((row, text.to_owned()));
            return self.put(row, index, f64::NAN);
        }
        if row < MAX_HEADER_ROWS {
            self.texts.push(SheetText {
                row,
                column: index,
                text: text.to_owned(),
            });
        }
        column.other.push((row, text.to_owned()));
        true
    }

    /// The table of the sheet; `None` if no column has two numbers.
    fn table(mut self, name: &str, epoch_1904: bool) -> Option<RawTable> {
        let mut notes = Vec::new();
        for (index, column) in &mut self.columns {
            column.read_text_numbers(*index, &mut notes);
        }
        self.columns.retain(|_, column| column.has_numbers_from(0));
        let first = self.first_row()?;
        let above: Vec<String> = self
            .columns
            .iter()
            .filter(|(_, column)| !column.has_numbers_from(first))
            .map(|(index, _)| letters(*index))
            .collect();
        if !above.is_empty() {
            notes.push(format!(
                "Numbers above the table in columns {} were left out.",
                listed(&above)
            ));
        }
        self.columns
            .retain(|_, column| column.has_numbers_from(first));
        let indices: Vec<u32> = self.columns.keys().copied().collect();
        let header = header(&self.texts, first, &indices, &mut notes);
        let mut columns = Vec::new();
        for (index, mut column) in self.columns {
            let name = header
                .names
                .get(&index)
                .cloned()
                .unwrap_or_else(|| format!("Column {}", letters(index)));
            column.describe(&name, first, epoch_1904, &mut notes);
            let values = column
                .values
                .split_off((first as usize).min(column.values.len()));
            let above = column.values.iter().filter(|v| v.is_finite()).count();
            if above > 0 {
                notes.push(format!(
                    "\"{name}\": {above} numbers above the table (row {}) were left out.",
                    first + 1
                ));
            }
            let days = (column.dates > 0).then(|| "d".to_owned());
            columns.push(RawColumn {
                unit: header.units.get(&index).cloned().or(days),
                name,
                values,
            });
        }
        Some(RawTable {
            name: name.to_owned(),
            columns,
            clock: None,
            notes,
        })
    }

    /// First row with numbers in half as many columns as most rows have, but in two if most have
    /// two: a setting above the table is one number beside its name.
    fn first_row(&self) -> Option<u32> {
        let rows = self.columns.values().map(|c| c.values.len()).max()?;
        let mut numbers = vec![0_u32; rows];
        for column in self.columns.values() {
            for (count, value) in numbers.iter_mut().zip(&column.values) {
                *count += u32::from(value.is_finite());
            }
        }
        let mut rows_with: BTreeMap<u32, usize> = BTreeMap::new();
        for count in numbers.iter().filter(|count| **count > 0) {
            *rows_with.entry(*count).or_default() += 1;
        }
        let (usual, _) = rows_with.iter().max_by_key(|(_, rows)| **rows)?;
        let needed = usual.div_ceil(2).max(2).min(*usual);
        let first = numbers.iter().position(|count| *count >= needed)?;
        u32::try_from(first).ok()
    }
}

impl Column {
    /// Whether there are two numbers from a row on.
    fn has_numbers_from(&self, row: u32) -> bool {
        let numbers = self.values.iter().skip(row as usize);
        numbers.filter(|v| v.is_finite()).nth(1).is_some()
    }

    /// Puts numbers that are stored as text among the others.
    fn read_text_numbers(&mut self, index: u32, notes: &mut Vec<String>) {
        if self.text_numbers.is_empty() {
            return;
        }
        let texts = self.text_numbers.iter().map(|(_, text)| text.as_str());
        let Some(marks) = TextMarks::of(texts) else {
            notes.push(format!(
                "Column {}: numbers are stored as text with marks that contradict each other; they are missing.",
                letters(index)
            ));
            self.other.append(&mut self.text_numbers);
            return;
        };
        let count = self.text_numbers.len();
        for (row, text) in std::mem::take(&mut self.text_numbers) {
            match (marks.parse(&text), self.values.get_mut(row as usize)) {
                (Some(number), Some(slot)) => *slot = number,
                _ => self.other.push((row, text)),
            }
        }
        notes.push(format!(
            "Column {}: {count} numbers are stored as text; they were read {}.",
            letters(index),
            marks.words()
        ));
    }

    /// Notes on dates and on cells that are no numbers.
    fn describe(&self, name: &str, first: u32, epoch_1904: bool, notes: &mut Vec<String>) {
        if self.dates > 0 {
            let since = if epoch_1904 {
                "1904-01-01"
            } else {
                "1899-12-30"
            };
            notes.push(format!(
                "\"{name}\" holds dates or times of day; they are Excel's day numbers: days of 86400 s since {since}."
            ));
        }
        let mut among = self.other.iter().filter(|(row, _)| *row >= first);
        if let Some((row, text)) = among.next() {
            notes.push(format!(
                "\"{name}\": {} cells are no numbers (first: \"{text}\" in row {}); they are missing values.",
                among.count() + 1,
                row + 1
            ));
        }
    }
}

/// A column's letters: A, B, ..., Z, AA.
fn letters(index: u32) -> String {
    let mut text = Vec::new();
    let mut rest = index;
    loop {
        text.push(char::from(b'A' + (rest % 26) as u8));
        if rest < 26 {
            break;
        }
        rest = rest / 26 - 1;
    }
    text.iter().rev().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn column_letters() {
        let of = [
            (0, "A"),
            (25, "Z"),
            (26, "AA"),
            (701, "ZZ"),
            (702, "AAA"),
            (16383, "XFD"),
        ];
        for (index, expected) in of {
            assert_eq!(letters(index), expected);
        }
    }

    #[test]
    fn far_cells_do_not_take_memory() {
        let mut sheet = Sheet::default();
        let fits = (0..16_384).all(|column| sheet.add(1_048_575, column, &DataRef::Int(1)));
        assert!(!fits);
        assert!(sheet.held <= MAX_EMPTY_CELLS + (1 << 21));
    }
}
