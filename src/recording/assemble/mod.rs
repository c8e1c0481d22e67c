//! From columns of numbers to a [`Recording`]: the rules for time, gaps and missing
//! samples, the same for every format.

mod kept_rows;

pub(super) use self::kept_rows::forward_rows;
use self::kept_rows::{ForwardRows, missing, missing_in};
use super::error::{ImportError, ImportWarning, WarningKind, visible};
use super::times::clock::{ClockFinding, Judgement, judge_rows, judge_steps};
use super::times::exact_time::ExactTime;
use super::times::rounding::Printed;
use super::{Channel, Recording, median_interval};
use crate::model::unit::{counted, format_quantity};

/// A step of more than this many median intervals is a gap.
pub const GAP_FACTOR: f64 = 5.0;

/// Largest share of the rows that is left out without asking: a loss of more says that the time is read
/// wrongly, or that the file is damaged.
const MAX_LOST_SHARE: f64 = 0.01;
/// Rows that may be lost from any file.
const MAX_LOST_ROWS: usize = 2;

/// Columns as a file gave them, SI, NaN where a cell was no number.
#[derive(Debug)]
pub(super) struct Columns {
    pub time: Vec<f64>,
    pub voltage: Option<Vec<f64>>,
    pub proof_mass: Vec<f64>,
    pub cantilever: Option<Vec<f64>>,
    /// Whether the motion is a displacement rather than what is to be integrated.
    pub is_displacement: bool,
}

/// How the times of the columns relate to those of the file.
#[derive(Debug)]
pub(super) struct FileClock {
    /// The instant in the file from which `Columns::time` counts \[s\].
    pub origin: ExactTime,
    /// Whether that is the file's zero rather than the first row.
    pub keeps_zero: bool,
    /// How the times were written.
    pub printed: Printed,
    /// Whether they are used as written, whatever they show.
    pub as_written: bool,
    /// Added to all times in the end \[s\].
    pub offset: f64,
    /// Whether more rows may be lost than [`MAX_LOST_SHARE`].
    pub accept_losses: bool,
}

/// Where a row stands in its file, for messages. A `None` channel is the time.
pub(super) struct Place<'a> {
    pub file: &'a str,
    /// Line number of a row.
    pub line_of: &'a dyn Fn(usize) -> usize,
    /// Column number of a quantity, from 1.
    pub column_of: &'a dyn Fn(Option<Channel>) -> usize,
    /// Text of a cell.
    pub cell_of: &'a dyn Fn(usize, Option<Channel>) -> String,
    /// Number of columns that the file has at a row.
    pub columns_at: &'a dyn Fn(usize) -> usize,
}

/// Applies the rules, in this order: times that repeat because they were rounded are told apart, rows
/// without a time and rows that go back in time are dropped, cells that are no numbers are
/// counted in what is left, the clock is judged, gaps are counted, the unit of time is judged.
pub(super) fn assemble(
    mut columns: Columns,
    mut clock: FileClock,
    place: &Place,
    warnings: Vec<ImportWarning>,
) -> Result<Recording, ImportError> {
    let mut report = Report {
        place,
        warnings,
        rows_moved: false,
    };
    let rows = columns.time.len();
    if rows < 2 {
        return Err(place.too_few_rows(rows));
    }
    let (missing_times, first_missing_time) = missing(&columns.time);
    if missing_times == rows {
        return Err(place.empty_column(None));
    }
    let first_row = clock.origin.clone();
    let settled = missing_times == 0 && adopt_rounded_rows(&mut columns, &mut clock, &mut report);

    let increasing = missing_times == 0 && columns.time.windows(2).all(|w| w[1] > w[0]);
    let keep = (!increasing).then(|| forward_rows(&columns.time));
    if let Some(kept) = &keep {
        check_direction(kept, rows - missing_times, &report)?;
        check_losses(kept, missing_times, first_missing_time, &clock, place)?;
    }
    count_missing_cells(
        &mut columns,
        keep.as_ref().map(|k| &k.keep[..]),
        &mut report,
    )?;
    if missing_times > 0 {
        report.missing_times(missing_times, first_missing_time);
    }
    if let Some(kept) = keep {
        drop_rows(&mut columns, &kept, &mut report);
        // What is counted below has no line any more: rows have moved.
        report.rows_moved = true;
    }
    if !settled && !clock.as_written {
        let start = clock.origin.seconds();
        let (time, readings) = (&columns.time, &columns.proof_mass);
        let found = judge_steps(time, readings, start, clock.printed, GAP_FACTOR);
        if let Some(found) = found {
            adopt(found, &mut columns, &mut clock, &mut report);
        }
    }
    judge_time(&columns, &mut report);
    report.origin(&first_row);
    finish(columns, clock, report)
}

/// The recording, with the offset added to its times.
fn finish(
    mut columns: Columns,
    clock: FileClock,
    report: Report<'_>,
) -> Result<Recording, ImportError> {
    let mut origin = clock.origin;
    let file = report.place.file;
    if clock.offset != 0.0 {
        columns.time.iter_mut().for_each(|t| *t += clock.offset);
        origin = origin.minus(&ExactTime::from_seconds(clock.offset));
        if !columns.time.windows(2).all(|w| w[1] > w[0]) {
            return Err(ImportError::OffsetTooLarge {
                file: file.into(),
                offset: clock.offset.to_string().into(),
            });
        }
    }
    let mut recording = Recording::new(
        visible(file),
        columns.time,
        columns.voltage,
        columns.proof_mass,
        columns.cantilever,
    )
    .map_err(|error| ImportError::Unreadable {
        file: file.into(),
        reason: error.to_string().into(),
    })?;
    recording.origin = origin;
    recording.warnings = report.warnings;
    Ok(recording)
}

/// Uses the times of an even clock where those of the rows are its rounded times; whether the
/// clock is settled.
fn adopt_rounded_rows(
    columns: &mut Columns,
    clock: &mut FileClock,
    report: &mut Report<'_>,
) -> bool {
    let ordered = columns.time.windows(2).all(|w| w[1] >= w[0]);
    if clock.as_written || !ordered {
        return false;
    }
    match judge_rows(&columns.time, clock.origin.seconds(), clock.printed) {
        Judgement::Open => false,
        Judgement::Settled(found) => {
            if let Some(found) = found {
                adopt(found, columns, clock, report);
            }
            true
        }
    }
}

/// Uses the times that were found, if any, and says so.
fn adopt(
    found: ClockFinding,
    columns: &mut Columns,
    clock: &mut FileClock,
    report: &mut Report<'_>,
) {
    report.warn(found.kind, found.count, Some(found.row), found.message);
    if let Some(even) = found.times {
        columns.time = even.time;
        // The clock's first tick is not quite where the first row says.
        if clock.keeps_zero {
            columns.time.iter_mut().for_each(|t| *t += even.first_shift);
        } else {
            let shift = ExactTime::from_seconds(even.first_shift);
            clock.origin = clock.origin.plus(&shift);
        }
    }
}

impl Place<'_> {
    fn too_few_rows(&self, rows: usize) -> ImportError {
        ImportError::TooFewRows {
            file: self.file.into(),
            line: (self.line_of)(0),
            column: (self.column_of)(None),
            rows,
        }
    }

    /// No row has a number for `channel`; `None` is the time.
    fn empty_column(&self, channel: Option<Channel>) -> ImportError {
        self.no_such_column(channel)
            .unwrap_or_else(|| ImportError::EmptyColumn {
                file: self.file.into(),
                line: (self.line_of)(0),
                column: (self.column_of)(channel),
                symbol: channel.map_or("t", Channel::symbol).to_owned(),
                cell: (self.cell_of)(0, channel).into(),
            })
    }

    /// The error for a column that the file does not have; `None` if it has it.
    fn no_such_column(&self, channel: Option<Channel>) -> Option<ImportError> {
        let (column, cells) = ((self.column_of)(channel), (self.columns_at)(0));
        (column > cells).then(|| ImportError::NoSuchColumn {
            file: self.file.into(),
            line: (self.line_of)(0),
            column,
            symbol: channel.map_or("t", Channel::symbol).to_owned(),
            cells,
        })
    }
}

/// The warnings of an import, with the lines that they are about.
struct Report<'a> {
    place: &'a Place<'a>,
    warnings: Vec<ImportWarning>,
    /// Whether rows were dropped, so that a row has no line any more.
    rows_moved: bool,
}

impl Report<'_> {
    fn warn(&mut self, kind: WarningKind, count: usize, row: Option<usize>, message: String) {
        let row = row.filter(|_| !self.rows_moved);
        let line = row.map(self.place.line_of);
        self.warnings
            .push(ImportWarning::new(kind, count, line, &message));
    }

    /// Says where the file has t = 0, if it is another instant.
    fn origin(&mut self, origin: &ExactTime) {
        if !origin.is_zero() {
            let message = format!(
                "times count from the first row, which is at {origin} s in the file (the import settings can keep the file's zero)"
            );
            self.warn(WarningKind::TimeOrigin, 1, None, message);
        }
    }

    fn missing_times(&mut self, count: usize, first: Option<usize>) {
        let line = first.map_or(0, self.place.line_of);
        let (have, are) = if count == 1 {
            ("has", "is")
        } else {
            ("have", "are")
        };
        let message = format!(
            "{} {have} no time that is a number (first in line {line}) and {are} left out",
            counted(count, "row"),
        );
        self.warn(WarningKind::TimeNotANumber, count, first, message);
    }
}

/// Counts the cells of each channel that are no numbers, in the rows to `keep` (all, if `None`). A
/// voltage or cantilever without any number is dropped; a proof mass without any is an error, as is
/// a column that the file does not have.
fn count_missing_cells(
    columns: &mut Columns,
    keep: Option<&[bool]>,
    report: &mut Report<'_>,
) -> Result<(), ImportError> {
    let rows = keep.map_or(columns.time.len(), |keep| {
        keep.iter().filter(|k| **k).count()
    });
    for channel in Channel::ALL {
        let column = match channel {
            Channel::Voltage => columns.voltage.as_ref(),
            Channel::ProofMass => Some(&columns.proof_mass),
            Channel::Cantilever => columns.cantilever.as_ref(),
        };
        let Some(column) = column else { continue };
        let (count, first) = missing_in(column, keep);
        if count == rows {
            let place = report.place;
            let empty = missing(column).0 == column.len();
            if let Some(error) = place.no_such_column(Some(channel)).filter(|_| empty) {
                return Err(error);
            }
            match channel {
                Channel::ProofMass if empty => return Err(place.empty_column(Some(channel))),
                Channel::ProofMass => {
                    return Err(ImportError::NoUsableRow {
                        file: place.file.into(),
                        line: first.map_or(0, place.line_of),
                        column: (place.column_of)(Some(channel)),
                        symbol: channel.symbol().to_owned(),
                    });
                }
                Channel::Voltage => columns.voltage = None,
                Channel::Cantilever => columns.cantilever = None,
            }
            let message = format!("{} holds no numbers and is left out", channel.symbol());
            report.warn(WarningKind::IgnoredColumn, count, first, message);
        } else if count > 0 {
            let line = first.map_or(0, report.place.line_of);
            let message = format!(
                "{} of {} {} not {} (first in line {line}); {} left out of comparisons",
                counted(count, "cell"),
                channel.symbol(),
                if count == 1 { "is" } else { "are" },
                if count == 1 { "a number" } else { "numbers" },
                if count == 1 { "it is" } else { "they are" },
            );
            report.warn(WarningKind::NotANumber, count, first, message);
        }
    }
    Ok(())
}

/// Checks that time goes forward in most of the `timed` rows that have one, and that two are left.
///
/// # Errors
/// [`ImportError::TimeBackwards`], [`ImportError::TooFewRows`].
fn check_direction(
    kept: &ForwardRows,
    timed: usize,
    report: &Report<'_>,
) -> Result<(), ImportError> {
    let place = report.place;
    if kept.dropped * 2 > timed {
        return Err(ImportError::TimeBackwards {
            file: place.file.into(),
            line: kept.first_dropped.map_or(0, place.line_of),
            column: (place.column_of)(None),
            count: kept.dropped,
            rows: kept.keep.len(),
        });
    }
    let left = timed - kept.dropped;
    if left < 2 {
        return Err(place.too_few_rows(left));
    }
    Ok(())
}

/// Checks that the rows without a time and those that go back in time are few.
///
/// # Errors
/// [`ImportError::RowsLost`].
fn check_losses(
    kept: &ForwardRows,
    missing: usize,
    first_missing: Option<usize>,
    clock: &FileClock,
    place: &Place,
) -> Result<(), ImportError> {
    let (lost, rows) = (missing + kept.dropped, kept.keep.len());
    let most = MAX_LOST_ROWS.max((MAX_LOST_SHARE * rows as f64) as usize);
    if clock.accept_losses || lost <= most {
        return Ok(());
    }
    let first = [first_missing, kept.first_dropped]
        .into_iter()
        .flatten()
        .min();
    let reason = match (missing, kept.dropped) {
        (0, n) => format!("in {n} it does not increase"),
        (n, 0) => format!("in {n} it is no number"),
        (missing, back) => {
            format!("in {missing} it is no number, in {back} it does not increase")
        }
    };
    Err(ImportError::RowsLost {
        file: place.file.into(),
        line: first.map_or(0, place.line_of),
        lost,
        rows,
        reason: reason.into(),
    })
}

/// Drops the rows without a time and those that go back in time.
fn drop_rows(columns: &mut Columns, kept: &ForwardRows, report: &mut Report<'_>) {
    let backwards = kept.dropped;
    if backwards > 0 {
        let line = kept.first_dropped.map_or(0, report.place.line_of);
        let message = format!(
            "in {} time does not increase (first in line {line}); {} left out",
            counted(backwards, "row"),
            if backwards == 1 { "it is" } else { "they are" },
        );
        let first = kept.first_dropped;
        report.warn(WarningKind::TimeNotIncreasing, backwards, first, message);
    }
    let pick = |column: &mut Vec<f64>| {
        let mut kept = kept.keep.iter();
        column.retain(|_| kept.next().copied().unwrap_or(false));
    };
    pick(&mut columns.time);
    pick(&mut columns.proof_mass);
    columns.voltage.iter_mut().for_each(pick);
    columns.cantilever.iter_mut().for_each(pick);
}

/// Gaps and unlikely units of time.
fn judge_time(columns: &Columns, report: &mut Report<'_>) {
    let time = &columns.time;
    let interval = median_interval(time);
    let wide = |i: &usize| time[i + 1] - time[*i] > GAP_FACTOR * interval;
    let gaps = (0..time.len() - 1).filter(wide).count();
    if gaps > 0 {
        let first = (0..time.len() - 1).find(wide);
        let longest = time.windows(2).fold(0.0, |m: f64, w| m.max(w[1] - w[0]));
        let message = format!(
            "{} in time (the longest {}, against {} between samples); nothing is compared inside",
            counted(gaps, "gap"),
            format_quantity(longest, "s", 3),
            format_quantity(interval, "s", 3),
        );
        report.warn(WarningKind::Gap, gaps, first, message);
    }
    let (low, high) = super::extremes(&columns.proof_mass);
    let travel = high - low;
    // A thing that moves by less than a millimetre is small, hence fast, and is not
    // recorded at less than 1 kHz; nothing here is recorded slower than once a second
    // or faster than 1 GHz.
    let small_and_slow =
        columns.is_displacement && travel < 1e-3 && travel > 0.0 && interval >= 1e-3;
    if small_and_slow || !(1e-9..=1.0).contains(&interval) {
        let motion = if columns.is_displacement {
            format!(" for a motion of {}", format_quantity(travel, "m", 3))
        } else {
            String::new()
        };
        let message = format!(
            "samples every {} seem unlikely{motion}; check the unit of the time column",
            format_quantity(interval, "s", 3),
        );
        report.warn(WarningKind::UnlikelyTimeUnit, 1, None, message);
    }
}
