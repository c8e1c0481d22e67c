//! A trial before it is sealed.

use std::sync::Arc;

use super::case::{Case, Recordings, TrialError};
use crate::model::preset::{Preset, PresetError};
use crate::recording::Recording;
use crate::recording::csv::{import_bytes_auto, write_recording};
use crate::trial::rescale::UnitFactors;
use crate::trial::truth::{Envelope, Truth};

/// What a recording shows: written times, voltage, proof mass, cantilever.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    pub(crate) time: Vec<f64>,
    pub(crate) voltage: Option<Vec<f64>>,
    pub(crate) proof_mass: Vec<f64>,
    pub(crate) cantilever: Option<Vec<f64>>,
}

/// A trial before it is sealed.
pub(crate) struct Parts {
    pub(crate) truth: Truth,
    pub(crate) columns: Vec<Columns>,
    /// The text of the device's preset, if it is none of those that come with the program.
    pub(crate) preset: Option<String>,
}

impl Parts {
    /// The same trial in other units.
    ///
    /// # Errors
    /// [`PresetError`] if no preset can hold the device in these units.
    pub(crate) fn in_other_units(mut self, units: UnitFactors) -> Result<Self, PresetError> {
        let preset = match &self.preset {
            Some(text) => Preset::parse("the preset of the trial", text)?,
            None => Preset::default(),
        };
        self.preset = Some(units.preset(&preset)?.to_toml());
        let multiply = |values: &mut Vec<f64>, factor: f64| {
            values.iter_mut().for_each(|value| *value *= factor);
        };
        for columns in &mut self.columns {
            multiply(&mut columns.time, units.time);
            multiply(&mut columns.proof_mass, units.length);
            if let Some(cantilever) = &mut columns.cantilever {
                multiply(cantilever, units.length);
            }
        }
        // Their names say frequencies that are no longer theirs.
        for (i, note) in self.truth.recordings.iter_mut().enumerate() {
            note.name = format!("recording {}", i + 1);
        }
        self.truth.units = Some(units);
        Ok(self)
    }

    pub(crate) fn seal(self) -> Result<Case, TrialError> {
        let mut recordings = Recordings {
            train: Vec::new(),
            held_out: Vec::new(),
        };
        let seed = self.truth.seed;
        let failed = |last: String| TrialError::NoDevice { seed, last };
        let jitters = self.truth.instruments.imperfections.stamp_jitter > 0.0;
        for (note, columns) in self.truth.recordings.iter().zip(self.columns) {
            let mut recording = Recording::new(
                &note.name,
                columns.time,
                columns.voltage,
                columns.proof_mass,
                columns.cantilever,
            )
            .map_err(|error| failed(error.to_string()))?;
            if jitters {
                recording = as_file(&recording).map_err(failed)?;
            }
            let group = if note.held_out {
                &mut recordings.held_out
            } else {
                &mut recordings.train
            };
            group.push(Arc::new(recording));
        }
        Ok(Case::new(
            recordings,
            self.preset,
            Envelope::close(self.truth)?,
        ))
    }
}

/// The recording as it is read from its file: that is where uneven times are judged.
fn as_file(recording: &Recording) -> Result<Recording, String> {
    let mut bytes = Vec::new();
    write_recording(&mut bytes, recording).map_err(|error| error.to_string())?;
    let mut read = import_bytes_auto(&recording.name, &bytes).map_err(|error| error.to_string())?;
    read.name.clone_from(&recording.name);
    Ok(read)
}
