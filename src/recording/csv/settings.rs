//! How a file is to be read: delimiter, decimal mark, columns with their units, scales.

use serde::{Deserialize, Serialize};

use crate::recording::Channel;
use crate::recording::error::ImportError;

/// What separates the cells of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Delimiter {
    /// `,`
    #[default]
    Comma,
    /// `;`
    Semicolon,
    /// A tabulator.
    Tab,
}

impl Delimiter {
    /// All delimiters, for a chooser.
    pub const ALL: [Delimiter; 3] = [Delimiter::Comma, Delimiter::Semicolon, Delimiter::Tab];

    /// The byte that separates cells.
    #[must_use]
    pub fn byte(self) -> u8 {
        match self {
            Delimiter::Comma => b',',
            Delimiter::Semicolon => b';',
            Delimiter::Tab => b'\t',
        }
    }
}

/// The decimal mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decimal {
    /// `1.5`
    #[default]
    Point,
    /// `1,5` (a point is still understood). With comma-separated cells the numbers
    /// must be quoted.
    Comma,
}

/// Which column holds a quantity, and in what unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ColumnChoice {
    /// Index of the column, from 0.
    pub index: usize,
    /// Unit of its numbers, such as `ms` or `um`.
    pub unit: String,
}

/// What counts as t = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeZero {
    /// The first row. It is the instant that every file has, whatever its clock counts from,
    /// and the one from which the recording is simulated.
    #[default]
    FirstRow,
    /// The zero of the file, for a person who knows that it means something (a trigger).
    File,
}

impl TimeZero {
    /// Settings that were stored before there was a choice meant the file's zero, and the time
    /// shifts that were stored with them count from there.
    fn of_stored_settings() -> Self {
        TimeZero::File
    }
}

/// How a file is to be read; what the import dialog edits and remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ImportSettings {
    /// What separates the cells.
    pub delimiter: Delimiter,
    /// The decimal mark.
    pub decimal: Decimal,
    /// Lines before the first row of numbers, header and comments included.
    pub skip_lines: usize,
    /// The time column; required.
    pub time: Option<ColumnChoice>,
    /// The voltage column.
    pub voltage: Option<ColumnChoice>,
    /// The proof mass column; required.
    pub proof_mass: Option<ColumnChoice>,
    /// The cantilever column.
    pub cantilever: Option<ColumnChoice>,
    /// What counts as t = 0, before the offset.
    #[serde(default = "TimeZero::of_stored_settings")]
    pub time_zero: TimeZero,
    /// Whether times are used as written even where they are an even clock's but for rounding or
    /// jitter.
    pub times_as_written: bool,
    /// Added to the times \[s\].
    pub time_offset: f64,
    /// The voltage is multiplied by this; negative turns it over.
    pub voltage_scale: f64,
    /// The proof mass is multiplied by this, before the offset.
    pub xp_scale: f64,
    /// Added to the scaled proof mass \[m\].
    pub xp_offset: f64,
    /// The cantilever is multiplied by this, before the offset.
    pub xc_scale: f64,
    /// Added to the scaled cantilever \[m\].
    pub xc_offset: f64,
}

impl Default for ImportSettings {
    fn default() -> Self {
        Self {
            delimiter: Delimiter::Comma,
            decimal: Decimal::Point,
            skip_lines: 0,
            time: None,
            voltage: None,
            proof_mass: None,
            cantilever: None,
            time_zero: TimeZero::FirstRow,
            times_as_written: false,
            time_offset: 0.0,
            voltage_scale: 1.0,
            xp_scale: 1.0,
            xp_offset: 0.0,
            xc_scale: 1.0,
            xc_offset: 0.0,
        }
    }
}

impl ImportSettings {
    /// The column chosen for a channel.
    #[must_use]
    pub fn choice(&self, channel: Channel) -> Option<&ColumnChoice> {
        match channel {
            Channel::Voltage => self.voltage.as_ref(),
            Channel::ProofMass => self.proof_mass.as_ref(),
            Channel::Cantilever => self.cantilever.as_ref(),
        }
    }

    /// Scale and offset of a channel.
    pub(super) fn scaling(&self, channel: Channel) -> (f64, f64) {
        match channel {
            Channel::Voltage => (self.voltage_scale, 0.0),
            Channel::ProofMass => (self.xp_scale, self.xp_offset),
            Channel::Cantilever => (self.xc_scale, self.xc_offset),
        }
    }

    pub(super) fn check(&self, file: &str) -> Result<(), ImportError> {
        let numbers = [
            ("time_offset", self.time_offset),
            ("voltage_scale", self.voltage_scale),
            ("xp_scale", self.xp_scale),
            ("xp_offset", self.xp_offset),
            ("xc_scale", self.xc_scale),
            ("xc_offset", self.xc_offset),
        ];
        match numbers.iter().find(|(_, value)| !value.is_finite()) {
            Some((setting, value)) => Err(ImportError::BadSetting {
                file: file.into(),
                setting,
                value: value.to_string().into(),
            }),
            None => Ok(()),
        }
    }
}
