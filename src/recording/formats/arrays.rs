//! Named arrays of one file, gathered into tables: those that share a folder, a length and a clock.

use std::collections::HashMap;

use super::error::{FileContext, FormatError};
use super::matrix::MatrixContent;
use crate::recording::error::visible;
use crate::recording::formats::raw_table::{RawColumn, RawTable, SampleClock};

/// A channel joins the table of longer ones with the same clock if it has at least this share of
/// their samples: a recording that was stopped lacks a block, another measurement far more.
const MIN_SHARE_OF_ROWS: f64 = 0.5;

/// Most names in one note.
const MAX_NAMES: usize = 20;

/// Names that say nothing where each folder has one array.
const PLAIN_NAMES: [&str; 5] = ["data", "value", "values", "array", "samples"];

/// Names of a single number that is a sampling rate \[Hz\], lower case without `_` and spaces.
const RATE_NAMES: [&str; 9] = [
    "fs",
    "fsamp",
    "rate",
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "sfreq",
    "srate",
];
/// Names of a single number that is the time between samples \[s\]; `tinterval` is PicoScope's.
const INTERVAL_NAMES: [&str; 8] = [
    "dt",
    "deltat",
    "tinterval",
    "interval",
    "sampleinterval",
    "samplinginterval",
    "sampletime",
    "xincrement",
];
/// Names of a single number that is the time of the first sample \[s\]; `tstart` is PicoScope's.
const START_NAMES: [&str; 4] = ["t0", "tstart", "starttime", "xorigin"];
/// Names of a column of times; where one is, single numbers are not taken for a clock.
const TIME_NAMES: [&str; 6] = ["t", "time", "times", "zeit", "temps", "timestamp"];

/// One array of a file.
#[derive(Debug, Clone)]
pub(crate) struct NamedArray {
    /// Folder it lies in, empty for the file itself.
    pub parent: String,
    /// Its own name.
    pub name: String,
    /// Unit, where the file states one.
    pub unit: Option<String>,
    /// Its numbers.
    pub values: Vec<f64>,
    /// Its clock, where the file gives one.
    pub clock: Option<SampleClock>,
}

/// All that a file holds.
#[derive(Debug, Default)]
pub(crate) struct Arrays {
    /// Columns of numbers.
    pub arrays: Vec<NamedArray>,
    /// Single numbers: folder, name, value.
    pub scalars: Vec<(String, String, f64)>,
    /// What was left out, by name and reason.
    pub left_out: Vec<String>,
    /// Whole sentences that hold for every table.
    pub notes: Vec<String>,
}

/// What the columns of an array share.
#[derive(Debug, Clone, Default)]
pub(crate) struct ArrayLabel {
    /// Folder.
    pub parent: String,
    /// Name of the array.
    pub name: String,
    /// Unit.
    pub unit: Option<String>,
    /// Clock.
    pub clock: Option<SampleClock>,
    /// Names of its columns, where the file gives them.
    pub columns: Vec<String>,
}

impl ArrayLabel {
    /// Folder and name.
    pub fn path(&self) -> String {
        joined(&self.parent, &self.name)
    }
}

/// `parent/name`.
pub(crate) fn joined(parent: &str, name: &str) -> String {
    if parent.is_empty() {
        name.to_owned()
    } else {
        format!("{parent}/{name}")
    }
}

/// A name as it is compared: lower case, letters and digits only.
fn plain(name: &str) -> String {
    name.chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

/// At most [`MAX_NAMES`] of `names`, and how many more.
pub(crate) fn listed(names: &[String]) -> String {
    let shown = names.iter().take(MAX_NAMES).cloned().collect::<Vec<_>>();
    let more = names.len().saturating_sub(MAX_NAMES);
    let text = shown.join(", ");
    if more > 0 {
        format!("{text} and {more} more")
    } else {
        text
    }
}

/// Pads columns and makes notes fit for a screen; every format's last step.
pub(crate) fn finish(mut tables: Vec<RawTable>) -> Vec<RawTable> {
    for table in &mut tables {
        table.pad();
        for note in &mut table.notes {
            *note = visible(note);
        }
    }
    tables
}

impl Arrays {
    /// Adds what an array gave; `false` if its bytes were too short.
    pub fn add(&mut self, label: &ArrayLabel, content: MatrixContent) -> bool {
        match content {
            MatrixContent::Short => return false,
            MatrixContent::Empty => self.left_out.push(format!("{} (empty)", label.path())),
            MatrixContent::Other(what) => {
                self.left_out.push(format!("{} ({what})", label.path()));
            }
            MatrixContent::Scalar(value) => {
                self.scalars
                    .push((label.parent.clone(), label.name.clone(), value));
            }
            MatrixContent::Columns {
                columns,
                along_rows,
            } => {
                let count = columns.len();
                if along_rows && count > 1 {
                    self.notes.push(format!(
                        "\"{}\" holds its {count} channels as rows; each row became a column.",
                        label.path()
                    ));
                }
                for (index, values) in columns.into_iter().enumerate() {
                    let name = match label.columns.get(index) {
                        Some(name) if label.columns.len() == count => name.clone(),
                        _ if count == 1 => label.name.clone(),
                        _ => format!("{} column {}", label.name, index + 1)
                            .trim()
                            .to_owned(),
                    };
                    self.arrays.push(NamedArray {
                        parent: label.parent.clone(),
                        name,
                        unit: label.unit.clone(),
                        values,
                        clock: label.clock,
                    });
                }
            }
        }
        true
    }

    /// The tables; `file_stem` names one that lies in no folder.
    ///
    /// # Errors
    /// [`FormatError::NoNumbers`] if there is no column.
    pub fn into_tables(
        mut self,
        context: &FileContext,
        file_stem: &str,
    ) -> Result<Vec<RawTable>, FormatError> {
        // An array without values is no column.
        for array in self.arrays.extract_if(.., |array| array.values.is_empty()) {
            let name = joined(&array.parent, &array.name);
            self.left_out.push(format!("{name} (no values)"));
        }
        if self.arrays.is_empty() {
            let mut found: Vec<String> = self
                .scalars
                .iter()
                .map(|(parent, name, _)| format!("{} (one number)", joined(parent, name)))
                .collect();
            found.append(&mut self.left_out);
            let found = if found.is_empty() {
                "it is empty".to_owned()
            } else {
                listed(&found)
            };
            return Err(context.no_numbers(visible(&found)));
        }
        if !self.left_out.is_empty() {
            self.notes
                .push(format!("Left out: {}.", listed(&self.left_out)));
        }
        self.merge_lone_arrays();
        let mut tables = self.grouped(file_stem);
        for (parent, table) in &mut tables {
            if table.clock.is_none() {
                self.set_clock(parent, table);
            }
            table.notes.extend(self.notes.iter().cloned());
            let numbers: Vec<String> = self
                .scalars
                .iter()
                .filter(|(of, _, _)| of.is_empty() || of == parent)
                .map(|(_, name, value)| format!("{name} = {value}"))
                .collect();
            if !numbers.is_empty() {
                table
                    .notes
                    .push(format!("Single numbers in the file: {}.", listed(&numbers)));
            }
        }
        Ok(finish(tables.into_iter().map(|(_, table)| table).collect()))
    }

    /// Folders with one array each are channels of one table if their arrays are equally long.
    fn merge_lone_arrays(&mut self) {
        let mut in_folder: HashMap<String, usize> = HashMap::new();
        for array in &self.arrays {
            *in_folder.entry(array.parent.clone()).or_default() += 1;
        }
        let is_lone = |array: &NamedArray| in_folder.get(&array.parent) == Some(&1);
        let key = |array: &NamedArray| (array.values.len(), clock_bits(array.clock));
        let mut alike: HashMap<_, usize> = HashMap::new();
        for array in self.arrays.iter().filter(|array| is_lone(array)) {
            *alike.entry(key(array)).or_default() += 1;
        }
        for array in &mut self.arrays {
            let merges = in_folder.get(&array.parent) == Some(&1)
                && alike.get(&key(array)).is_some_and(|n| *n > 1)
                && !array.parent.is_empty();
            if merges {
                let parent = std::mem::take(&mut array.parent);
                array.name = if PLAIN_NAMES.contains(&plain(&array.name).as_str()) {
                    parent
                } else {
                    joined(&parent, &array.name)
                };
            }
        }
    }

    /// Tables in order of their first array, each with its folder.
    fn grouped(&mut self, file_stem: &str) -> Vec<(String, RawTable)> {
        let mut order: Vec<NamedArray> = std::mem::take(&mut self.arrays);
        let mut longest: HashMap<_, usize> = HashMap::new();
        for array in &order {
            if let Some(bits) = clock_bits(array.clock) {
                let rows = longest.entry((array.parent.clone(), bits)).or_default();
                *rows = (*rows).max(array.values.len());
            }
        }
        let mut tables: Vec<(String, RawTable)> = Vec::new();
        let mut index_of: HashMap<_, usize> = HashMap::new();
        for array in order.drain(..) {
            let bits = clock_bits(array.clock);
            let rows = bits
                .and_then(|bits| longest.get(&(array.parent.clone(), bits)))
                .copied()
                .filter(|rows| array.values.len() as f64 >= MIN_SHARE_OF_ROWS * *rows as f64)
                .unwrap_or(array.values.len());
            let index = *index_of
                .entry((array.parent.clone(), rows, bits))
                .or_insert_with(|| {
                    let name = if array.parent.is_empty() {
                        file_stem.to_owned()
                    } else {
                        array.parent.clone()
                    };
                    let table = RawTable {
                        name,
                        columns: Vec::new(),
                        clock: array.clock,
                        notes: Vec::new(),
                    };
                    tables.push((array.parent.clone(), table));
                    tables.len() - 1
                });
            if let Some((_, table)) = tables.get_mut(index) {
                table.columns.push(RawColumn {
                    name: array.name,
                    unit: array.unit,
                    values: array.values,
                });
            }
        }
        if tables.len() > 1 {
            tell_apart(&mut tables);
        }
        tables
    }

    /// A clock from single numbers such as `fs` or `Tinterval`, if the table has no times.
    fn set_clock(&self, parent: &str, table: &mut RawTable) {
        let is_time = |column: &RawColumn| {
            let first = column.name.split(['[', '(']).next().unwrap_or("");
            TIME_NAMES.contains(&plain(first).as_str())
        };
        if table.columns.iter().any(is_time) {
            return;
        }
        let number = |names: &[&str]| {
            self.scalars
                .iter()
                .find(|(of, name, _)| {
                    (of.is_empty() || of == parent) && names.contains(&plain(name).as_str())
                })
                .map(|(_, name, value)| (name.as_str(), *value))
        };
        let interval = number(&INTERVAL_NAMES);
        let rate = number(&RATE_NAMES).map(|(name, rate)| (name, 1.0 / rate));
        let Some((name, interval)) = interval.or(rate) else {
            return;
        };
        let start = number(&START_NAMES);
        let clock = SampleClock::new(start.map_or(0.0, |(_, start)| start), interval);
        if let Some(clock) = clock {
            table.clock = Some(clock);
            table.notes.push(match start {
                Some((start_name, start)) => format!(
                    "Times were made from the numbers {name} and {start_name}: {start} s, then every {interval} s."
                ),
                None => format!(
                    "Times were made from the number {name}: every {interval} s from 0."
                ),
            });
        }
    }
}

/// A clock as a key of a map.
fn clock_bits(clock: Option<SampleClock>) -> Option<(u64, u64)> {
    clock.map(|clock| (clock.start.to_bits(), clock.interval.to_bits()))
}

/// Adds the number of rows to names of tables that are alike.
fn tell_apart(tables: &mut [(String, RawTable)]) {
    let mut seen: HashMap<String, usize> = HashMap::new();
    for (_, table) in tables.iter() {
        *seen.entry(table.name.clone()).or_default() += 1;
    }
    for (_, table) in tables.iter_mut() {
        if seen.get(&table.name).is_some_and(|n| *n > 1) {
            let first = table.columns.first().map_or("", |c| c.name.as_str());
            table.name = format!("{} ({} rows from \"{first}\")", table.name, table.rows());
        }
    }
}

/// A file's name without folder and extension.
pub(crate) fn stem(file: &str) -> String {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    match name.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem.to_owned(),
        _ => name.to_owned(),
    }
}
