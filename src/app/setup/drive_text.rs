//! A drive as it is written in a session file.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::drive_choice::DriveChoice;
use super::own_drive::OwnDrive;
use crate::model::drive::{DriveReading, VoltageTable, Waveform};
use crate::recording::measured_drive::drive_of_samples;

/// The drive of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveEntry {
    /// As on the command line: `square:15Hz:8V`.
    Waveform(String),
    /// A chirp with the duration of its sweep \[s\].
    Chirp { text: String, sweep: f64 },
    /// Voltages \[V\] at times \[s\].
    Table {
        name: String,
        time: Vec<f64>,
        voltage: Vec<f64>,
        /// Period after which points come again \[s\].
        #[serde(default, skip_serializing_if = "Option::is_none")]
        period: Option<f64>,
        /// How samples of a file were read; points have none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        reading: Option<DriveReading>,
    },
    /// The voltage of a recording, by its number.
    Recorded(u64),
}

impl DriveEntry {
    /// The form of a drive in a file.
    pub fn of(drive: &DriveChoice) -> Self {
        match drive {
            DriveChoice::Recorded(id) => Self::Recorded(*id),
            DriveChoice::Waveform(Waveform::Table(table)) => {
                let name = table.name.clone();
                let (time, voltage) = match (table.points(), table.source()) {
                    (Some((time, voltage)), _) => (time.to_vec(), voltage.to_vec()),
                    (None, Some(source)) => (source.time.clone(), source.voltage.clone()),
                    (None, None) => (Vec::new(), Vec::new()),
                };
                Self::Table {
                    name,
                    time,
                    voltage,
                    period: table.period(),
                    reading: table.source().map(|s| s.reading),
                }
            }
            DriveChoice::Waveform(waveform @ Waveform::Chirp { duration, .. }) => Self::Chirp {
                text: waveform.to_string(),
                sweep: *duration,
            },
            DriveChoice::Waveform(waveform) => Self::Waveform(waveform.to_string()),
        }
    }

    /// Reads it back, for a run of `duration` \[s\].
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(self, duration: f64) -> Result<DriveChoice, String> {
        let parse = |text: &str, sweep| {
            Waveform::parse(text, sweep)
                .map(DriveChoice::Waveform)
                .map_err(|error| error.to_string())
        };
        let table = |table| Waveform::Table(Arc::new(table));
        match self {
            Self::Recorded(id) => Ok(DriveChoice::Recorded(id)),
            Self::Waveform(text) => parse(&text, duration),
            Self::Chirp { text, sweep } => parse(&text, sweep),
            Self::Table {
                name,
                time,
                voltage,
                period,
                reading,
            } => {
                let waveform = match (reading, period) {
                    (Some(reading), _) => drive_of_samples(&name, time, voltage, reading),
                    (None, None) => VoltageTable::new(name, time, voltage).map(table),
                    (None, Some(period)) => VoltageTable::new(name, time, voltage)
                        .and_then(|points| points.repeating(period))
                        .map(table),
                };
                waveform
                    .map(DriveChoice::Waveform)
                    .map_err(|error| error.to_string())
            }
        }
    }
}

/// The drive of a recording's own run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OwnDriveEntry {
    /// Its measured voltage, read this way.
    Measured(DriveReading),
    /// The drive of the simulation.
    Shared,
    /// A waveform of its own.
    Chosen(DriveEntry),
}

impl OwnDriveEntry {
    /// The form in a file; `None` for the usual one.
    pub fn of(drive: &OwnDrive) -> Option<Self> {
        match drive {
            usual if *usual == OwnDrive::default() => None,
            OwnDrive::Measured(reading) => Some(Self::Measured(*reading)),
            OwnDrive::Shared => Some(Self::Shared),
            OwnDrive::Chosen(waveform) => Some(Self::Chosen(DriveEntry::of(
                &DriveChoice::Waveform(waveform.clone()),
            ))),
        }
    }

    /// Reads it back, for a run of `duration` \[s\].
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(self, duration: f64) -> Result<OwnDrive, String> {
        match self {
            Self::Measured(reading) => Ok(OwnDrive::Measured(reading)),
            Self::Shared => Ok(OwnDrive::Shared),
            Self::Chosen(entry) => match entry.read(duration)? {
                DriveChoice::Waveform(waveform) => Ok(OwnDrive::Chosen(waveform)),
                DriveChoice::Recorded(_) => {
                    Err("a recording's own drive cannot be another recording's".to_owned())
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Through the text of a file and back.
    fn restored(drive: &DriveChoice) -> DriveChoice {
        #[derive(Serialize, Deserialize)]
        struct File {
            drive: DriveEntry,
        }
        let text = toml::to_string(&File {
            drive: DriveEntry::of(drive),
        })
        .unwrap();
        let file: File = toml::from_str(&text).unwrap();
        file.drive.read(0.4).unwrap()
    }

    fn points() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
        prop::collection::vec((1e-7..1e-2f64, -10.0..10.0f64), 1..300).prop_map(|pairs| {
            let mut t = -0.01;
            pairs
                .into_iter()
                .map(|(step, volts)| {
                    t += step;
                    (t, volts)
                })
                .unzip()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_table_is_restored_to_the_last_bit(
            (time, voltage) in points(),
            extra in prop::option::of(0.0..0.1f64),
            reading in prop::sample::select(DriveReading::ALL.to_vec()),
        ) {
            let span = time[time.len() - 1] - time[0];
            let points = VoltageTable::new("edited", time.clone(), voltage.clone()).unwrap();
            let table = match extra {
                Some(extra) if span + extra > 0.0 => points.repeating(span + extra).unwrap(),
                _ => points,
            };
            let drive = DriveChoice::Waveform(Waveform::Table(Arc::new(table)));
            prop_assert_eq!(&restored(&drive), &drive);
            // Samples of a file, as they are read; noise and all.
            let drive = drive_of_samples("file", time, voltage, reading).unwrap();
            let drive = DriveChoice::Waveform(drive);
            prop_assert_eq!(&restored(&drive), &drive);
        }
    }
}
