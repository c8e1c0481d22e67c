//! The whole import of a text: decoding, rows in parallel, order in time.

use std::borrow::Cow;

use sha2::{Digest, Sha256};

use super::columns::sample::certain_decimal;
use super::columns::several;
use super::line;
use super::number::marks::{Marks, Verdict};
use super::number::relative_time::Zero;
use super::rows::layout::{Layout, TIME_SLOT};
use super::rows::order::{Counting, Order, analyse};
use super::rows::truncated_line;
use super::rows::{Part, Table, evidence, first_time};
use super::settings::{Decimal, Encoding, ImportSettings, TimeZero};
use super::text::encoding::{Decoded, decode, encoding_warning};
use super::text::reshape::reshape;
use super::text::{Progress, Text, newline_of};
use crate::model::unit::counted;
use crate::recording::Recording;
use crate::recording::error::{ImportError, ImportWarning, WarningKind};
use crate::recording::times::exact_time::ExactTime;

/// Reads `bytes` as `settings` say; `warnings` are put first.
pub(super) fn read(
    file: &str,
    bytes: &[u8],
    settings: &ImportSettings,
    mut warnings: Vec<ImportWarning>,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    settings.check(file)?;
    let decoded = decode(bytes, settings.encoding, false);
    say_encoding(&decoded, settings, &mut warnings);
    let bytes_read = reshaped(decoded.bytes, settings);
    let text = Text::new(file, &bytes_read)?;
    let mut layout = Layout::new(file, settings)?;
    let source = Source::new(file, &text, settings);
    source.judge_marks(&mut layout, &mut warnings)?;

    // The hash is of the same bytes but needs nothing of the parse: its own thread.
    let (rows, hash) = std::thread::scope(|scope| {
        let hash = scope.spawn(|| hex(&Sha256::digest(bytes)));
        let rows = source.rows(&layout, progress, &mut warnings);
        (rows, hash.join().ok())
    });
    let mut recording = source.recording(rows?, &layout, warnings)?;
    recording.sha256 = hash;
    Ok(recording)
}

/// Where each of the recordings below each other in a file begins: its name for a chooser.
pub(super) fn stacked(
    file: &str,
    bytes: &[u8],
    settings: &ImportSettings,
) -> Result<Vec<String>, ImportError> {
    settings.check(file)?;
    let decoded = decode(bytes, settings.encoding, false);
    let bytes_read = reshaped(decoded.bytes, settings);
    let text = Text::new(file, &bytes_read)?;
    let mut layout = Layout::new(file, settings)?;
    let source = Source::new(file, &text, settings);
    source.judge_marks(&mut layout, &mut Vec::new())?;
    let (table, zero) = source.parse(source.part.clone(), None, &layout, None)?;
    let order = source.order_of(&table, &layout, &zero);
    Ok(source.names_of(&table, &layout, &order))
}

fn reshaped<'a>(bytes: Cow<'a, [u8]>, settings: &ImportSettings) -> Cow<'a, [u8]> {
    let newline = newline_of(&bytes);
    reshape(bytes, newline, settings.delimiter, &settings.cell_ends)
}

fn say_encoding(decoded: &Decoded, settings: &ImportSettings, warnings: &mut Vec<ImportWarning>) {
    if let Some(encoding) = decoded
        .from
        .filter(|_| decoded.guessed && settings.encoding.is_none())
    {
        warnings.push(encoding_warning(encoding));
    }
    let mut warn = |count: usize, message: String| {
        let kind = WarningKind::TextEncoding;
        warnings.push(ImportWarning::new(kind, count, None, &message));
    };
    if decoded.malformed {
        let name = decoded.from.unwrap_or(Encoding::Utf8).label();
        warn(1, format!("some bytes are no characters of {name}"));
    }
    if decoded.zeros_cut > 0 {
        let zeros = counted(decoded.zeros_cut, "zero byte");
        warn(
            decoded.zeros_cut,
            format!("{zeros} at the end were cut off"),
        );
    }
}

/// The text of a file and what is to be read of it.
pub(super) struct Source<'a> {
    pub file: &'a str,
    pub text: &'a Text<'a>,
    pub settings: &'a ImportSettings,
    pub part: Part,
}

/// Rows in the order of time.
pub(super) struct Rows {
    pub table: Table,
    pub columns: [Option<Vec<f64>>; 4],
    /// The instant in the file from which times count, in its unit.
    pub zero: ExactTime,
    /// Row of the table of each row; `None` if they are the same.
    pub order: Option<Vec<usize>>,
    /// Rows without a time that are no rows of numbers.
    pub text_rows: usize,
}

impl<'a> Source<'a> {
    fn new(file: &'a str, text: &'a Text<'a>, settings: &'a ImportSettings) -> Self {
        let (start, first_line) = text.skip_lines(settings.skip_lines);
        Self {
            file,
            text,
            settings,
            part: Part {
                range: start..text.bytes.len(),
                first_line,
            },
        }
    }

    /// The marks of the columns that are read, by all their cells.
    fn judge_marks(
        &self,
        layout: &mut Layout,
        warnings: &mut Vec<ImportWarning>,
    ) -> Result<(), ImportError> {
        let rows = &self.text.bytes[self.part.range.clone()];
        // Only these can stand in a number that is not plain.
        let sign = if layout.delimiter == b',' { b'"' } else { b',' };
        let suspicious = memchr::memchr(sign, rows).is_some();
        if !suspicious && self.settings.decimal == Decimal::Point {
            return Ok(());
        }
        let found = evidence(self.text, self.part.range.clone(), layout.delimiter);
        let others = certain_decimal(&found, layout.delimiter);
        let mut is_plain = true;
        let mut has_comma = false;
        for (index, slots) in &layout.columns {
            if slots.contains(&TIME_SLOT) && layout.is_clock {
                continue;
            }
            let Some(own) = found.get(*index) else {
                continue;
            };
            let marks = match own.judge(others, self.settings.decimal) {
                Verdict::Clear(marks) | Verdict::Open(marks) => marks,
                Verdict::Mixed => return Err(self.mixed_marks(*index)),
            };
            if let Some(mark) = marks.thousands {
                let message = format!(
                    "column {}: a {} stands between thousands and a {} before decimals",
                    index + 1,
                    Marks::name(mark),
                    Marks::name(marks.decimal),
                );
                let kind = WarningKind::ThousandsMarks;
                warnings.push(ImportWarning::new(kind, 1, None, &message));
            }
            let quick =
                marks.thousands.is_none() && (marks.decimal == b'.' || layout.delimiter != b',');
            is_plain &= quick;
            has_comma |= marks.decimal == b',';
            for slot in slots {
                layout.slots[*slot].marks = marks;
            }
        }
        layout.is_plain &= is_plain;
        layout.comma = has_comma && layout.delimiter != b',';
        Ok(())
    }

    fn mixed_marks(&self, index: usize) -> ImportError {
        ImportError::Undecided {
            file: self.file.into(),
            line: self.part.first_line,
            question: format!(
                "column {} has numbers with a decimal point and numbers with a decimal comma",
                index + 1
            )
            .into(),
            options: "an export with one decimal mark".into(),
        }
    }

    /// Parses a part; times count from `zero` if given, else from its first row.
    fn parse(
        &self,
        part: Part,
        zero: Option<ExactTime>,
        layout: &Layout,
        progress: Option<&Progress>,
    ) -> Result<(Table, ExactTime), ImportError> {
        let rows = &self.text.bytes[part.range.clone()];
        let zero = match (self.settings.time_zero, zero) {
            (TimeZero::FirstRow, Some(zero)) => zero,
            (TimeZero::FirstRow, None) => first_time(rows, self.text, layout).unwrap_or_default(),
            (TimeZero::File, _) => ExactTime::default(),
        };
        let from = Zero::new(zero.clone());
        let table = Table::parse(self.file, self.text, part, layout, &from, progress)?;
        Ok((table, zero))
    }

    /// What the order of the rows shows; times are not in the file's unit yet but in seconds.
    fn order_of(&self, table: &Table, layout: &Layout, zero: &ExactTime) -> Order {
        let slot = layout.slots[TIME_SLOT];
        let time = table.columns[TIME_SLOT].as_deref().unwrap_or_default();
        let counting = Counting {
            origin: zero.clone().shifted(slot.shift).seconds(),
            unit: 10f64.powi(slot.shift),
            is_clock: layout.is_clock,
        };
        analyse(time, counting)
    }

    fn names_of(&self, table: &Table, layout: &Layout, order: &Order) -> Vec<String> {
        let line = |row: usize| table.line_of(self.text, layout, row);
        let name = |part: &std::ops::Range<usize>| {
            let last = part.end.saturating_sub(1);
            format!("lines {} to {}", line(part.start), line(last))
        };
        order.parts.iter().take(100).map(name).collect()
    }

    /// The rows, one recording, in the order of time.
    fn rows(
        &self,
        layout: &Layout,
        progress: Option<&Progress>,
        warnings: &mut Vec<ImportWarning>,
    ) -> Result<Rows, ImportError> {
        let mut part = self.part.clone();
        let rows = &self.text.bytes[part.range.clone()];
        let cut = truncated_line::cut_last_line(rows, self.text, layout);
        if let Some(at) = cut {
            part.range.end = part.range.start + at;
        }
        let (mut table, mut zero) = self.parse(part.clone(), None, layout, progress)?;
        if cut.is_some() {
            let line = table.next_line;
            let message =
                format!("the last line ({line}) was cut off in the middle and is left out");
            let kind = WarningKind::CutLastLine;
            warnings.push(ImportWarning::new(kind, 1, Some(line), &message));
        }
        self.check_widths(&table, layout, warnings)?;
        let mut order = self.order_of(&table, layout, &zero);
        if order.parts.len() > 1 {
            part = self.chosen_part(&table, layout, &order, part)?;
            (table, zero) = self.parse(part.clone(), None, layout, progress)?;
            order = self.order_of(&table, layout, &zero);
        }
        if let Some(row) = order.unit_change {
            return Err(self.unit_changes(&table, layout, row));
        }
        if order.reversed {
            let last = table.columns[TIME_SLOT]
                .as_ref()
                .and_then(|time| time.iter().rposition(|t| t.is_finite()));
            let first = last.and_then(|row| table.exact_time_of(self.text, layout, row));
            (table, zero) = self.parse(part, first, layout, progress)?;
        }
        Ok(self.in_order(table, zero, &order, warnings))
    }

    /// The bytes of the recording that is asked for.
    fn chosen_part(
        &self,
        table: &Table,
        layout: &Layout,
        order: &Order,
        whole: Part,
    ) -> Result<Part, ImportError> {
        let count = order.parts.len();
        let Some(trial) = self.settings.trial else {
            let names = self.names_of(table, layout, order);
            let mut shown: Vec<&str> = names.iter().map(String::as_str).collect();
            shown.resize(count, "");
            return Err(several(self.file, &shown));
        };
        let no_such = || ImportError::NoSuchTrial {
            file: self.file.into(),
            trial,
            count,
        };
        let at = trial.checked_sub(1).ok_or_else(no_such)?;
        let rows = order.parts.get(at).ok_or_else(no_such)?;
        let start = table
            .start_of(self.text, layout, rows.start)
            .ok_or_else(no_such)?;
        let end = if rows.end < table.rows {
            table
                .start_of(self.text, layout, rows.end)
                .ok_or_else(no_such)?
                .0
        } else {
            whole.range.end
        };
        Ok(Part {
            range: start.0..end,
            first_line: start.1,
        })
    }

    fn unit_changes(&self, table: &Table, layout: &Layout, row: usize) -> ImportError {
        let cell = |row: usize| {
            let column = layout.time.unwrap_or(0);
            table.cell_of(self.text, layout, row, column)
        };
        ImportError::TimeUnitChanges {
            file: self.file.into(),
            line: table.line_of(self.text, layout, row),
            before: cell(row.saturating_sub(1)).into(),
            after: cell(row).into(),
        }
    }

    /// Whether rows get more cells midway than the header names.
    fn check_widths(
        &self,
        table: &Table,
        layout: &Layout,
        warnings: &mut Vec<ImportWarning>,
    ) -> Result<(), ImportError> {
        let Some(change) = table.widths.change() else {
            return Ok(());
        };
        let before = self.text.split(&self.text.bytes[..self.part.range.start]);
        let named: Vec<Vec<String>> = before
            .map(|l| line::show_row(l, layout.delimiter))
            .collect();
        let most = named.iter().map(Vec::len).max().unwrap_or(0);
        let row = table.line_of(self.text, layout, change.row);
        if change.before.max(change.after) <= most {
            return Ok(());
        }
        // A header that is written again says where the columns are.
        let header = named.iter().rev().find(|cells| cells.len() >= 2);
        let again = change
            .row
            .checked_sub(1)
            .filter(|r| table.text_rows.contains(r));
        let stays = again.zip(header).is_some_and(|(again, header)| {
            layout.columns.iter().all(|(index, _)| {
                let name = table.cell_of(self.text, layout, again, *index);
                header.get(*index) == Some(&name)
            })
        });
        let (cells, fewer) = (change.after, change.before);
        if !stays && !self.settings.accept_losses {
            return Err(ImportError::ColumnsChange {
                file: self.file.into(),
                line: row,
                before: fewer,
                after: cells,
            });
        }
        let message = format!(
            "from line {row} on rows have {cells} cells, before {fewer}; the columns are read at the same places"
        );
        let kind = WarningKind::ColumnsChange;
        warnings.push(ImportWarning::new(kind, 1, Some(row), &message));
        Ok(())
    }
}

pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
