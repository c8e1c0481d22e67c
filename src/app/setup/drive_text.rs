//! A drive as it is written in a session file.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::drive_choice::DriveChoice;
use crate::model::drive::{VoltageTable, Waveform};

/// The drive of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
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
                let (time, voltage) = table.points();
                Self::Table {
                    name: table.name.clone(),
                    time: time.to_vec(),
                    voltage: voltage.to_vec(),
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
        match self {
            Self::Recorded(id) => Ok(DriveChoice::Recorded(id)),
            Self::Waveform(text) => parse(&text, duration),
            Self::Chirp { text, sweep } => parse(&text, sweep),
            Self::Table {
                name,
                time,
                voltage,
            } => {
                let table =
                    VoltageTable::new(name, time, voltage, 0.0).map_err(|e| e.to_string())?;
                Ok(DriveChoice::Waveform(Waveform::Table(Arc::new(table))))
            }
        }
    }
}
