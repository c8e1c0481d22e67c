//! From columns of numbers to a [`Recording`]: the rules for time, gaps and missing
//! samples, the same for every format.

use super::error::{ImportError, ImportWarning, WarningKind};
use super::{Channel, Recording, median_interval};
use crate::model::unit::{counted, format_quantity};

/// A step of more than this many median intervals is a gap.
pub const GAP_FACTOR: f64 = 5.0;

/// Columns as a file gave them, SI, NaN where a cell was no number.
#[derive(Debug, Default)]
pub(super) struct Columns {
    pub time: Vec<f64>,
    pub voltage: Option<Vec<f64>>,
    pub proof_mass: Vec<f64>,
    pub cantilever: Option<Vec<f64>>,
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
}

/// Applies the rules, in this order: cells that are no numbers are counted, rows
/// without a time and rows that go back in time are dropped, gaps are counted, the
/// unit of time is judged.
pub(super) fn assemble(
    mut columns: Columns,
    place: &Place,
    warnings: Vec<ImportWarning>,
) -> Result<Recording, ImportError> {
    let mut report = Report { place, warnings };
    let rows = columns.time.len();
    if rows < 2 {
        return Err(place.too_few_rows(rows));
    }
    let (missing_times, first_missing_time) = missing(&columns.time);
    if missing_times == rows {
        return Err(place.empty_column(None));
    }
    count_missing_cells(&mut columns, &mut report)?;
    if missing_times > 0 {
        report.missing_times(missing_times, first_missing_time);
    }

    let increasing = missing_times == 0 && columns.time.windows(2).all(|w| w[1] > w[0]);
    if !increasing {
        drop_backward_rows(&mut columns, missing_times, &mut report)?;
        // What is counted below has no line any more: rows have moved.
        judge_time(&columns, |kind, count, _, message| {
            report.warn(kind, count, None, message)
        });
    } else {
        judge_time(&columns, |kind, count, row, message| {
            report.warn(kind, count, row, message)
        });
    }

    let mut recording = Recording::new(
        place.file,
        columns.time,
        columns.voltage,
        columns.proof_mass,
        columns.cantilever,
    )
    .map_err(|error| ImportError::Unreadable {
        file: place.file.to_owned(),
        reason: error.to_string(),
    })?;
    recording.warnings = report.warnings;
    Ok(recording)
}

impl Place<'_> {
    fn too_few_rows(&self, rows: usize) -> ImportError {
        ImportError::TooFewRows {
            file: self.file.to_owned(),
            line: (self.line_of)(0),
            column: (self.column_of)(None),
            rows,
        }
    }

    fn empty_column(&self, channel: Option<Channel>) -> ImportError {
        ImportError::EmptyColumn {
            file: self.file.to_owned(),
            line: (self.line_of)(0),
            column: (self.column_of)(channel),
            symbol: channel.map_or("t", Channel::symbol).to_owned(),
            cell: (self.cell_of)(0, channel),
        }
    }
}

/// The warnings of an import, with the lines that they are about.
struct Report<'a> {
    place: &'a Place<'a>,
    warnings: Vec<ImportWarning>,
}

impl Report<'_> {
    fn warn(&mut self, kind: WarningKind, count: usize, row: Option<usize>, message: String) {
        self.warnings.push(ImportWarning {
            kind,
            count,
            first_line: row.map(self.place.line_of),
            message,
        });
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

/// Counts the cells of each channel that are no numbers. A voltage or cantilever without any
/// number is dropped; a proof mass without any is an error.
fn count_missing_cells(columns: &mut Columns, report: &mut Report<'_>) -> Result<(), ImportError> {
    for channel in Channel::ALL {
        let column = match channel {
            Channel::Voltage => columns.voltage.as_ref(),
            Channel::ProofMass => Some(&columns.proof_mass),
            Channel::Cantilever => columns.cantilever.as_ref(),
        };
        let Some(column) = column else { continue };
        let (count, first) = missing(column);
        if count == column.len() {
            match channel {
                Channel::ProofMass => return Err(report.place.empty_column(Some(channel))),
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

/// Drops the rows without a time and those that go back in time.
///
/// # Errors
/// [`ImportError`] if most rows go back, or fewer than two are left.
fn drop_backward_rows(
    columns: &mut Columns,
    missing_times: usize,
    report: &mut Report<'_>,
) -> Result<(), ImportError> {
    let place = report.place;
    let rows = columns.time.len();
    let (keep, backwards, first) = forward_rows(&columns.time);
    if backwards * 2 > rows - missing_times {
        return Err(ImportError::TimeBackwards {
            file: place.file.to_owned(),
            line: first.map_or(0, place.line_of),
            column: (place.column_of)(None),
            count: backwards,
            rows,
        });
    }
    if backwards > 0 {
        let line = first.map_or(0, place.line_of);
        let message = format!(
            "in {} time does not increase (first in line {line}); {} left out",
            counted(backwards, "row"),
            if backwards == 1 { "it is" } else { "they are" },
        );
        report.warn(WarningKind::TimeNotIncreasing, backwards, first, message);
    }
    let pick = |column: &mut Vec<f64>| {
        let mut kept = keep.iter();
        column.retain(|_| kept.next().copied().unwrap_or(false));
    };
    pick(&mut columns.time);
    pick(&mut columns.proof_mass);
    columns.voltage.iter_mut().for_each(pick);
    columns.cantilever.iter_mut().for_each(pick);
    if columns.time.len() < 2 {
        return Err(place.too_few_rows(columns.time.len()));
    }
    Ok(())
}

/// Number of missing samples, and the first.
fn missing(values: &[f64]) -> (usize, Option<usize>) {
    let count = values.iter().filter(|v| !v.is_finite()).count();
    let first = if count > 0 {
        values.iter().position(|v| !v.is_finite())
    } else {
        None
    };
    (count, first)
}

/// Which rows to keep so that time increases; how many go back, and the first that
/// does. A single time that is too large is dropped rather than all that follow it.
fn forward_rows(time: &[f64]) -> (Vec<bool>, usize, Option<usize>) {
    let mut keep = vec![false; time.len()];
    let mut dropped = 0;
    let mut first = None;
    let mut last = f64::NEG_INFINITY;
    let finite: Vec<usize> = (0..time.len()).filter(|&i| time[i].is_finite()).collect();
    for (k, &i) in finite.iter().enumerate() {
        let t = time[i];
        let next = finite.get(k + 1).map(|&j| time[j]);
        let spike = next.is_some_and(|next| next < t && next > last) && k > 0;
        if t > last && !spike {
            keep[i] = true;
            last = t;
        } else {
            dropped += 1;
            first.get_or_insert(i);
        }
    }
    (keep, dropped, first)
}

/// Gaps and unlikely units of time.
fn judge_time(columns: &Columns, mut warn: impl FnMut(WarningKind, usize, Option<usize>, String)) {
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
        warn(WarningKind::Gap, gaps, first, message);
    }
    let (low, high) = super::extremes(&columns.proof_mass);
    let travel = high - low;
    // A thing that moves by less than a millimetre is small, hence fast, and is not
    // recorded at less than 1 kHz; nothing here is recorded slower than once a second
    // or faster than 1 GHz.
    let small_and_slow = travel < 1e-3 && travel > 0.0 && interval >= 1e-3;
    if small_and_slow || !(1e-9..=1.0).contains(&interval) {
        let message = format!(
            "samples every {} seem unlikely for a motion of {}; check the unit of the time column",
            format_quantity(interval, "s", 3),
            format_quantity(travel, "m", 3),
        );
        warn(WarningKind::UnlikelyTimeUnit, 1, None, message);
    }
}
