//! What a file of a binary or structured format holds, before anyone decides what each column is.

use serde::{Deserialize, Serialize};

/// A table of columns as a file gives it, before anyone decides what each column is.
#[derive(Debug, Clone, PartialEq)]
pub struct RawTable {
    /// Path inside the file (group, sheet, variable), or the file's name where it has but one table.
    pub name: String,
    /// All equally long; shorter ones are padded with NaN, and [`Self::notes`] says so.
    pub columns: Vec<RawColumn>,
    /// Where the file gives a rate instead of a column of times.
    pub clock: Option<SampleClock>,
    /// What was scaled, left out, guessed or padded, in whole sentences for the user.
    pub notes: Vec<String>,
}

/// One column of a [`RawTable`].
#[derive(Debug, Clone, PartialEq)]
pub struct RawColumn {
    /// Name as the file writes it.
    pub name: String,
    /// Unit as the file writes it, where the format has a place for it. Text in brackets inside a
    /// name stays in the name.
    pub unit: Option<String>,
    /// Numbers in [`Self::unit`]; NaN is a missing one.
    pub values: Vec<f64>,
}

/// Evenly spaced samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SampleClock {
    /// Time of the first sample \[s\].
    pub start: f64,
    /// Time between two samples \[s\], positive and finite.
    pub interval: f64,
}

impl SampleClock {
    /// A clock; `None` unless the interval is positive and both numbers are finite.
    ///
    /// # Examples
    /// ```
    /// use impactscope::recording::formats::raw_table::SampleClock;
    /// assert!(SampleClock::new(0.0, 2e-5).is_some());
    /// assert!(SampleClock::new(0.0, 0.0).is_none());
    /// ```
    #[must_use]
    pub fn new(start: f64, interval: f64) -> Option<Self> {
        (start.is_finite() && interval.is_finite() && interval > 0.0)
            .then_some(Self { start, interval })
    }
}

impl RawTable {
    /// Number of rows: the length of the longest column.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns
            .iter()
            .map(|column| column.values.len())
            .max()
            .unwrap_or(0)
    }

    /// Makes all columns equally long, and notes which were shorter.
    pub(crate) fn pad(&mut self) {
        let rows = self.rows();
        for column in &mut self.columns {
            let missing = rows - column.values.len();
            if missing > 0 {
                self.notes.push(format!(
                    "\"{}\" has {} of {rows} values; the {missing} at its end are missing.",
                    column.name,
                    column.values.len()
                ));
                column.values.resize(rows, f64::NAN);
            }
        }
    }
}
