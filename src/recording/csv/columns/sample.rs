//! What the first rows of a column look like.

use crate::recording::csv::line::cells;
use crate::recording::csv::number::marks::{Evidence, Marks, Verdict};
use crate::recording::csv::number::{self, calendar};
use crate::recording::csv::settings::Decimal;
use crate::recording::median_interval;

/// The first rows of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::recording::csv) struct ColumnSample {
    /// Largest absolute number.
    pub largest: f64,
    /// First number.
    pub first: f64,
    /// Median step between rows.
    pub step: f64,
    /// Whether each row adds one to a whole number.
    pub counts: bool,
    /// Whether the cells are clock times, and whether these have a date.
    pub is_clock: bool,
    pub has_date: bool,
    /// Rows with a number.
    pub numbers: usize,
}

/// The columns of `rows`, and what their marks show.
pub(in crate::recording::csv) fn columns(
    rows: &[&[u8]],
    delimiter: u8,
    count: usize,
    decimal: Decimal,
) -> (Vec<ColumnSample>, Vec<Evidence>) {
    let table: Vec<Vec<&[u8]>> = rows
        .iter()
        .map(|row| cells(row, delimiter).collect())
        .collect();
    let column = |i: usize| table.iter().filter_map(move |row| row.get(i).copied());
    let evidence: Vec<Evidence> = (0..count)
        .map(|i| {
            let mut own = Evidence::default();
            column(i).for_each(|cell| own.note(cell));
            own
        })
        .collect();
    let others = certain_decimal(&evidence, delimiter);
    let samples = (0..count)
        .map(|i| {
            let marks = match evidence.get(i).map(|own| own.judge(others, decimal)) {
                Some(Verdict::Clear(marks) | Verdict::Open(marks)) => marks,
                _ => Marks::PLAIN,
            };
            of_cells(&column(i).collect::<Vec<_>>(), marks)
        })
        .collect();
    (samples, evidence)
}

/// The decimal mark that some columns certainly have; `None` if they differ or there is none.
pub(in crate::recording::csv) fn certain_decimal(
    evidence: &[Evidence],
    delimiter: u8,
) -> Option<Decimal> {
    let shown = |mark: Decimal| evidence.iter().any(|own| own.shows_decimal(mark));
    // Semicolons separate cells where the comma is taken for decimals.
    let has_comma = || evidence.iter().any(|own| own.has(Decimal::Comma));
    let by_groups = || {
        evidence
            .iter()
            .find_map(|own| match own.judge(None, Decimal::Point) {
                Verdict::Clear(Marks {
                    decimal,
                    thousands: Some(_),
                }) => Some(if decimal == b',' {
                    Decimal::Comma
                } else {
                    Decimal::Point
                }),
                _ => None,
            })
    };
    let by_delimiter = || (delimiter == b';' && has_comma()).then_some(Decimal::Comma);
    match (shown(Decimal::Point), shown(Decimal::Comma)) {
        // Thousands of one column are marked as those of another.
        (false, false) => by_groups().or_else(by_delimiter),
        (true, false) => Some(Decimal::Point),
        (false, true) => Some(Decimal::Comma),
        _ => None,
    }
}

fn of_cells(cells: &[&[u8]], marks: Marks) -> ColumnSample {
    let all: Vec<f64> = cells
        .iter()
        .map(|cell| number::cell_with(cell, marks, 0))
        .filter(|x| x.is_finite() && !number::kinds::OVERRANGE.contains(&x.abs()))
        .collect();
    let text = |cell: &&[u8]| String::from_utf8_lossy(cell).into_owned();
    let clocks = cells
        .iter()
        .filter(|cell| calendar::seconds(&text(cell)).is_some())
        .count();
    let first = all.first().copied().unwrap_or(f64::NAN);
    ColumnSample {
        largest: all.iter().fold(0.0, |m: f64, x| m.max(x.abs())),
        first,
        step: if all.len() > 1 {
            median_interval(&all)
        } else {
            f64::NAN
        },
        counts: all.len() > 1 && first.fract() == 0.0 && all.windows(2).all(|w| w[1] - w[0] == 1.0),
        is_clock: all.is_empty() && clocks > 0 && 2 * clocks >= cells.len(),
        has_date: cells.iter().any(|cell| calendar::has_date(&text(cell))),
        numbers: all.len(),
    }
}

/// Least and largest number of a count of days since 1899-12-30 that a spreadsheet writes today (1955
/// to 2118), and the longest step between samples.
const EXCEL_DAYS: std::ops::Range<f64> = 20_000.0..80_000.0;
const MAX_EXCEL_STEP: f64 = 1e-2;
/// Longest interval between samples of a time without a unit that is read as seconds \[s\].
const MAX_ASSUMED_INTERVAL: f64 = 0.1;
/// Seconds since 1970 from 2001 on.
const EPOCH_SECONDS: std::ops::Range<f64> = 1e9..1e10;
/// Numbers below this are metres, if they are a displacement: as micrometres they would be less than
/// any instrument resolves, and nobody writes millimetres of a micrometre.
const MAX_CERTAIN_METRES: f64 = 1e-3;

/// A unit that a column's numbers suggest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording::csv) enum Suggestion {
    /// No other is possible.
    Clear(&'static str),
    /// Another is as possible.
    Guess(&'static str),
}

impl ColumnSample {
    /// The unit of times that name none.
    pub(in crate::recording::csv) fn time_unit(&self) -> Suggestion {
        if self.is_clock {
            return Suggestion::Clear("clock");
        }
        let epochs = [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)];
        let epoch = epochs
            .iter()
            .find(|(_, factor)| EPOCH_SECONDS.contains(&(self.first / factor)));
        if let Some((unit, _)) = epoch {
            return Suggestion::Clear(unit);
        }
        if EXCEL_DAYS.contains(&self.first) && self.step.abs() < MAX_EXCEL_STEP {
            return Suggestion::Clear("days");
        }
        if self.counts || self.step.abs() > MAX_ASSUMED_INTERVAL {
            return Suggestion::Guess("s");
        }
        Suggestion::Clear("s")
    }

    /// The unit of displacements that name none, sampled every `interval` seconds.
    pub(in crate::recording::csv) fn length_unit(&self, interval: f64) -> Suggestion {
        if self.largest < MAX_CERTAIN_METRES {
            Suggestion::Clear("m")
        } else if interval < 1e-3 {
            Suggestion::Guess("um")
        } else {
            Suggestion::Guess("m")
        }
    }
}

impl Suggestion {
    /// The unit.
    pub(in crate::recording::csv) fn unit(self) -> &'static str {
        match self {
            Suggestion::Clear(unit) | Suggestion::Guess(unit) => unit,
        }
    }
}
