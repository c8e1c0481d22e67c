//! How a file is to be read: encoding, delimiter, decimal mark, columns with their units, scales.

use serde::{Deserialize, Serialize};

pub use super::integrate::drift::DriftRemoval;
use crate::recording::Channel;
use crate::recording::combine::Combination;
use crate::recording::error::ImportError;
pub use crate::recording::formats::raw_table::SampleClock;

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
    /// `|`
    Pipe,
    /// One or more blanks.
    Spaces,
    /// Nothing: cells end at the characters of [`ImportSettings::cell_ends`].
    FixedWidth,
    /// Commas, semicolons, tabulators or blanks, with a name before each number: `t:0 x:1.5`.
    Labels,
}

impl Delimiter {
    /// All delimiters, for a chooser.
    pub const ALL: [Delimiter; 7] = [
        Delimiter::Comma,
        Delimiter::Semicolon,
        Delimiter::Tab,
        Delimiter::Pipe,
        Delimiter::Spaces,
        Delimiter::FixedWidth,
        Delimiter::Labels,
    ];

    /// The byte that separates cells. Where it is no single byte, the rows are rewritten with
    /// tabulators before they are read.
    #[must_use]
    pub fn byte(self) -> u8 {
        match self {
            Delimiter::Comma => b',',
            Delimiter::Semicolon => b';',
            Delimiter::Pipe => b'|',
            Delimiter::Tab | Delimiter::Spaces | Delimiter::FixedWidth | Delimiter::Labels => b'\t',
        }
    }

    /// What it is called.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Delimiter::Comma => "comma",
            Delimiter::Semicolon => "semicolon",
            Delimiter::Tab => "tab",
            Delimiter::Pipe => "pipe",
            Delimiter::Spaces => "spaces",
            Delimiter::FixedWidth => "fixed width",
            Delimiter::Labels => "label:value",
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
    /// `1,5`. With comma-separated cells the numbers must be quoted.
    Comma,
}

/// What the numbers of a motion column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// A displacement \[m\].
    #[default]
    Displacement,
    /// A velocity \[m/s\]; integrated once.
    Velocity,
    /// An acceleration \[m/s^2\]; integrated twice.
    Acceleration,
}

impl Quantity {
    /// The SI unit.
    #[must_use]
    pub fn base_unit(self) -> &'static str {
        match self {
            Quantity::Displacement => "m",
            Quantity::Velocity => "m/s",
            Quantity::Acceleration => "m/s^2",
        }
    }

    /// The quantity that a unit belongs to; a displacement if it is none of a motion.
    #[must_use]
    pub fn of_unit(unit: &str) -> Self {
        let all = [Quantity::Velocity, Quantity::Acceleration];
        let mut known = all.into_iter();
        let fits =
            |kind: &Quantity| crate::model::unit::unit_factor(unit, kind.base_unit()).is_some();
        known.find(fits).unwrap_or_default()
    }

    /// What it is called.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Quantity::Displacement => "displacement",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
        }
    }
}

/// Which column holds a quantity, and in what unit.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ColumnChoice {
    /// Index of the column, from 0.
    pub index: usize,
    /// Unit of its numbers, such as `ms` or `um`. A time may also be in `min`, `h` or `days`, be a
    /// `clock` time (`14:03:12.5`, with or without a date), or a `sample` number
    /// ([`ImportSettings::clock`] says the interval).
    pub unit: String,
    /// What the numbers of a motion are.
    #[serde(default, skip_serializing_if = "is_displacement")]
    pub kind: Quantity,
    /// What one unit of the column stands for where it is a unit of another quantity, such as
    /// `0.5um/V`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<String>,
}

fn is_displacement(kind: &Quantity) -> bool {
    *kind == Quantity::Displacement
}

impl ColumnChoice {
    /// A column of numbers in `unit`.
    #[must_use]
    pub fn new(index: usize, unit: impl Into<String>) -> Self {
        Self {
            index,
            unit: unit.into(),
            ..Self::default()
        }
    }
}

/// Character encodings of text files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)] // Each is its name.
pub enum Encoding {
    Utf8,
    Utf16Le,
    Utf16Be,
    Windows1250,
    Windows1251,
    Windows1252,
    Macintosh,
    Gbk,
    Big5,
    ShiftJis,
    EucKr,
}

impl Encoding {
    /// All encodings, for a chooser.
    pub const ALL: [Encoding; 11] = [
        Encoding::Utf8,
        Encoding::Utf16Le,
        Encoding::Utf16Be,
        Encoding::Windows1250,
        Encoding::Windows1251,
        Encoding::Windows1252,
        Encoding::Macintosh,
        Encoding::Gbk,
        Encoding::Big5,
        Encoding::ShiftJis,
        Encoding::EucKr,
    ];

    /// The decoder.
    pub(super) fn decoder(self) -> &'static encoding_rs::Encoding {
        match self {
            Encoding::Utf8 => encoding_rs::UTF_8,
            Encoding::Utf16Le => encoding_rs::UTF_16LE,
            Encoding::Utf16Be => encoding_rs::UTF_16BE,
            Encoding::Windows1250 => encoding_rs::WINDOWS_1250,
            Encoding::Windows1251 => encoding_rs::WINDOWS_1251,
            Encoding::Windows1252 => encoding_rs::WINDOWS_1252,
            Encoding::Macintosh => encoding_rs::MACINTOSH,
            Encoding::Gbk => encoding_rs::GBK,
            Encoding::Big5 => encoding_rs::BIG5,
            Encoding::ShiftJis => encoding_rs::SHIFT_JIS,
            Encoding::EucKr => encoding_rs::EUC_KR,
        }
    }

    /// The name, such as `windows-1252`.
    #[must_use]
    pub fn label(self) -> &'static str {
        self.decoder().name()
    }

    /// The encoding of a name as people write it (`latin1`, `cp1252`, `UTF-16LE`, `gb2312`).
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let name = name.trim().to_lowercase();
        let label = name
            .strip_prefix("cp125")
            .map(|n| format!("windows-125{n}"));
        let found = encoding_rs::Encoding::for_label(label.unwrap_or(name).as_bytes())?;
        Self::ALL.into_iter().find(|e| e.decoder() == found)
    }
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

/// Settings that were stored before losses were asked about had accepted them.
fn accepted_in_stored_settings() -> bool {
    true
}

/// How a file is to be read; what the import dialog edits and remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ImportSettings {
    /// The encoding of the text; `None` recognises it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<Encoding>,
    /// What separates the cells.
    pub delimiter: Delimiter,
    /// Where cells of a fixed width end \[characters\]; the last one ends with the line.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cell_ends: Vec<usize>,
    /// The decimal mark, where the numbers of a column do not say it themselves.
    pub decimal: Decimal,
    /// Lines before the first row of numbers, header and comments included.
    pub skip_lines: usize,
    /// The time column; required unless there is a [`Self::clock`].
    pub time: Option<ColumnChoice>,
    /// Column with the dates of clock times.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date_column: Option<usize>,
    /// Evenly spaced samples: in place of a time column, or the meaning of a `sample` number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock: Option<SampleClock>,
    /// Which recording of a file that holds several, from 1. `None` where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial: Option<usize>,
    /// Whether rows may be lost that are more than a few.
    #[serde(default = "accepted_in_stored_settings")]
    pub accept_losses: bool,
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
    /// What is taken out of an integrated velocity or acceleration.
    #[serde(skip_serializing_if = "DriftRemoval::is_none")]
    pub drift: DriftRemoval,
    /// What else the recording is made of than the rows of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub combine: Option<Combination>,
}

impl Default for ImportSettings {
    fn default() -> Self {
        Self {
            encoding: None,
            delimiter: Delimiter::Comma,
            cell_ends: Vec::new(),
            decimal: Decimal::Point,
            skip_lines: 0,
            time: None,
            date_column: None,
            clock: None,
            trial: None,
            accept_losses: false,
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
            drift: DriftRemoval::None,
            combine: None,
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
    #[must_use]
    pub fn scaling(&self, channel: Channel) -> (f64, f64) {
        match channel {
            Channel::Voltage => (self.voltage_scale, 0.0),
            Channel::ProofMass => (self.xp_scale, self.xp_offset),
            Channel::Cantilever => (self.xc_scale, self.xc_offset),
        }
    }

    pub(super) fn check(&self, file: &str) -> Result<(), ImportError> {
        let clock = self.clock.unwrap_or(SampleClock {
            start: 0.0,
            interval: 1.0,
        });
        let numbers = [
            ("time_offset", self.time_offset),
            ("voltage_scale", self.voltage_scale),
            ("xp_scale", self.xp_scale),
            ("xp_offset", self.xp_offset),
            ("xc_scale", self.xc_scale),
            ("xc_offset", self.xc_offset),
            ("clock.start", clock.start),
            ("clock.interval", clock.interval),
        ];
        let corner = match self.drift {
            DriftRemoval::HighPass { corner } => corner.unwrap_or(1.0),
            _ => 1.0,
        };
        let numbers = numbers.into_iter().chain([("drift.corner", corner)]);
        let bad = |name: &str, value: f64| {
            let is_positive = ["clock.interval", "drift.corner"].contains(&name);
            !value.is_finite() || (is_positive && value <= 0.0)
        };
        match numbers.into_iter().find(|(name, value)| bad(name, *value)) {
            Some((setting, value)) => Err(ImportError::BadSetting {
                file: file.into(),
                setting,
                value: value.to_string().into(),
            }),
            None => Ok(()),
        }
    }
}
