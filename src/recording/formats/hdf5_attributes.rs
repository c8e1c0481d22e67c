//! Attributes of datasets and groups that say a unit, a clock or names of columns.

use hdf5_reader::Attribute;

use crate::recording::formats::raw_table::SampleClock;

/// Names of a unit, lower case.
const UNIT_NAMES: [&str; 4] = ["unit", "units", "unit_string", "y_unit"];
/// Names of a sampling rate \[Hz\], lower case.
const RATE_NAMES: [&str; 9] = [
    "fs",
    "rate",
    "sample_rate",
    "samplerate",
    "sampling_rate",
    "samplingrate",
    "sampling_frequency",
    "sample_frequency",
    "rate_hz",
];
/// Names of the time between samples \[s\], lower case.
const INTERVAL_NAMES: [&str; 9] = [
    "dt",
    "delta_t",
    "interval",
    "wf_increment",
    "sample_interval",
    "sampling_interval",
    "sample_time",
    "xinc",
    "xincrement",
];
/// Names of the time of the first sample \[s\], lower case.
const START_NAMES: [&str; 6] = [
    "t0",
    "start",
    "start_time",
    "wf_start_offset",
    "xorg",
    "xorigin",
];
/// Names of the names of columns, lower case.
const COLUMN_NAMES: [&str; 5] = [
    "columns",
    "column_names",
    "names",
    "channels",
    "channel_names",
];

/// What attributes say.
#[derive(Debug, Clone, Default)]
pub(super) struct Attributes {
    pub unit: Option<String>,
    pub columns: Vec<String>,
    /// MATLAB's class of a variable.
    pub matlab_class: Option<String>,
    pub is_matlab_empty: bool,
    interval: Option<f64>,
    start: Option<f64>,
}

impl Attributes {
    /// Those of `list`; other numbers go to `scalars`, under `path`.
    pub fn of(list: &[Attribute], path: &str, scalars: &mut Vec<(String, String, f64)>) -> Self {
        let mut found = Self::default();
        for attribute in list {
            let name = attribute.name.to_lowercase();
            let has = |names: &[&str]| names.contains(&name.as_str());
            let number = number(attribute);
            if has(&UNIT_NAMES) {
                found.unit = string(attribute);
            } else if has(&COLUMN_NAMES) {
                found.columns = attribute.read_strings().unwrap_or_default();
            } else if name == "matlab_class" {
                found.matlab_class = string(attribute);
            } else if name == "matlab_empty" {
                found.is_matlab_empty = number.is_some_and(|v| v != 0.0);
            } else if let Some(number) = number {
                if has(&INTERVAL_NAMES) {
                    found.interval = Some(number);
                } else if has(&RATE_NAMES) {
                    found.interval = found.interval.or(Some(1.0 / number));
                } else if has(&START_NAMES) {
                    found.start = Some(number);
                } else if !name.starts_with("matlab_") {
                    scalars.push((path.to_owned(), attribute.name.clone(), number));
                }
            }
        }
        found
    }

    /// These, and where they say nothing of a clock, those of the group above.
    pub fn over(self, above: &Self) -> Self {
        if self.interval.is_some() {
            return self;
        }
        Self {
            interval: above.interval,
            start: self.start.or(above.start),
            ..self
        }
    }

    /// The clock, if there is an interval or a rate.
    pub fn clock(&self) -> Option<SampleClock> {
        SampleClock::new(self.start.unwrap_or(0.0), self.interval?)
    }
}

/// A number, alone or in an array of one.
fn number(attribute: &Attribute) -> Option<f64> {
    if attribute.num_elements().ok()? != 1 {
        return None;
    }
    attribute.read_as_f64().ok()
}

/// A text, alone or in an array of one.
fn string(attribute: &Attribute) -> Option<String> {
    let text = attribute
        .read_string()
        .ok()
        .or_else(|| attribute.read_strings().ok()?.into_iter().next())?;
    let text = text.trim_end_matches('\0').trim();
    (!text.is_empty()).then(|| text.to_owned())
}
