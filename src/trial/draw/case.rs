//! A trial as it is handed out: recordings, the device's preset, and the sealed truth.

use std::sync::Arc;

use thiserror::Error;

use crate::recording::Recording;
use crate::trial::truth::{Envelope, Truth};

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
    /// A rig was asked for that there is not.
    #[error("there is no rig \"{name}\"; there are {known}")]
    UnknownRig {
        /// What was asked for.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// The rig cannot have what is to be concealed.
    #[error("the rig {rig} cannot conceal {what}; it can conceal {instead}")]
    NotInRig {
        /// The rig.
        rig: String,
        /// What was asked for.
        what: String,
        /// What can be asked for.
        instead: String,
    },
    /// The sizes make no sense.
    #[error(
        "sizes {low} to {high} cannot be used; give numbers above 0, at most 1000, the smaller one first"
    )]
    Sizes {
        /// The smallest size.
        low: f64,
        /// The largest.
        high: f64,
    },
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

impl TrialError {
    /// Whether other settings are needed, whatever the seed.
    #[must_use]
    pub fn is_of_settings(&self) -> bool {
        matches!(
            self,
            Self::UnknownEffect(_)
                | Self::UnknownRig { .. }
                | Self::NotInRig { .. }
                | Self::Sizes { .. }
                | Self::Setting { .. }
        )
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
    preset: Option<String>,
    envelope: Envelope,
}

impl Case {
    pub(crate) fn new(recordings: Recordings, preset: Option<String>, envelope: Envelope) -> Self {
        Self {
            recordings,
            preset,
            envelope,
        }
    }

    /// The recordings alone: what a diagnosis is given.
    #[must_use]
    pub fn recordings(&self) -> &Recordings {
        &self.recordings
    }

    /// Text of the preset that a person with this device would have, as far as it is none of those
    /// that come with the program.
    #[must_use]
    pub fn preset(&self) -> Option<&str> {
        self.preset.as_deref()
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
