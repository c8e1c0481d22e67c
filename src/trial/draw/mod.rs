//! Drawing a trial: device, instruments, what is concealed and at which size, recordings.

pub(crate) mod attempt;
pub(crate) mod size;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::concealed::concealed_effects::{CATALOGUE, OUTSIDE};
use super::instrument::StructureKind;
use super::truth::{Class, Envelope, Truth};
use crate::recording::Recording;

/// Devices that are drawn before a seed is given up.
const MAX_ATTEMPTS: u64 = 12;

/// Why there is no trial.
#[derive(Debug, Error)]
pub enum TrialError {
    /// No device of this seed could be followed.
    #[error("seed {seed}: no trial device could be followed ({last}); use another seed")]
    NoDevice {
        /// The seed.
        seed: u64,
        /// What stopped the last one.
        last: String,
    },
    /// An effect was asked for that cannot be concealed.
    #[error(
        "\"{0}\" cannot be concealed; name an effect of the catalogue or one that begins with outside_"
    )]
    UnknownEffect(String),
    /// The noise or the rate make no sense.
    #[error("{what} = {value:e} cannot be used; {remedy}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        remedy: &'static str,
    },
    /// The voltages of recordings could not be exchanged.
    #[error("the voltage of {recording} cannot be given to another recording: {reason}")]
    Shuffle {
        /// The recording whose voltage it is.
        recording: String,
        /// Why not.
        reason: String,
    },
    /// The truth could not be written.
    #[error("the truth cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file could not be written.
    #[error("cannot write {path}: {reason}; check the folder and the disk")]
    Write {
        /// Which file.
        path: String,
        /// Why.
        reason: String,
    },
}

/// What trials are drawn from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mix {
    /// A quarter nothing, half one effect, the rest two or outside the catalogue.
    Standard,
    /// Always this class.
    Only(Class),
    /// Always this one effect.
    Effect(String),
}

/// How trials are made.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The kind of device; drawn if `None`.
    pub structure: Option<StructureKind>,
    /// Whether the cantilever is read together with the proof mass.
    pub cantilever: bool,
    /// Rms of the noise \[m\].
    pub noise: f64,
    /// Samples per second.
    pub rate: f64,
    /// What is concealed.
    pub mix: Mix,
    /// Effects keep the size that they have on real devices, in place of one around the
    /// smallest visible.
    pub realistic: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            structure: Some(StructureKind::Lumped),
            cantilever: true,
            noise: 20e-9,
            rate: 50e3,
            mix: Mix::Standard,
            realistic: false,
        }
    }
}

/// The recordings of a trial, and nothing else.
#[derive(Debug, Clone)]
pub struct Recordings {
    /// To fit.
    pub train: Vec<Arc<Recording>>,
    /// Held out.
    pub held_out: Vec<Arc<Recording>>,
}

/// A trial: recordings, and the envelope with what they conceal.
#[derive(Debug, Clone)]
pub struct Case {
    recordings: Recordings,
    envelope: Envelope,
}

impl Case {
    /// Draws the trial of `seed`.
    ///
    /// # Errors
    /// [`TrialError`] if the settings make no sense or no device can be followed.
    pub fn draw(seed: u64, settings: &Settings) -> Result<Self, TrialError> {
        let bad = |what, value, remedy| {
            Err(TrialError::Setting {
                what,
                value,
                remedy,
            })
        };
        if !(settings.noise > 0.0 && settings.noise < 1e-5) {
            return bad("noise", settings.noise, "give metres above 0, below 10 um");
        }
        if !(1e3..=1e7).contains(&settings.rate) {
            return bad("rate", settings.rate, "give 1 kHz to 10 MHz");
        }
        if let Mix::Effect(id) = &settings.mix
            && !CATALOGUE.contains(&id.as_str())
            && !OUTSIDE.contains(&id.as_str())
        {
            return Err(TrialError::UnknownEffect(id.clone()));
        }
        let mut last = String::from("the structure is singular");
        for attempt in 0..MAX_ATTEMPTS {
            match Self::attempt(seed, attempt, settings) {
                Ok(Some(parts)) => return parts.seal(),
                Ok(None) => {}
                Err(error) => last = error.to_string(),
            }
        }
        Err(TrialError::NoDevice { seed, last })
    }

    /// The recordings alone: what a diagnosis is given.
    #[must_use]
    pub fn recordings(&self) -> &Recordings {
        &self.recordings
    }

    /// SHA-256 of the truth file.
    #[must_use]
    pub fn seal(&self) -> &str {
        self.envelope.seal()
    }

    /// The truth: opens the trial.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        self.envelope.peek()
    }

    /// Recordings and envelope apart, so that the truth can be kept elsewhere.
    #[must_use]
    pub fn into_parts(self) -> (Recordings, Envelope) {
        (self.recordings, self.envelope)
    }
}
