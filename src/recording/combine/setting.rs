//! How a recording is put together from several, as it is stored with its import settings.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// What else belongs to a recording than the rows of its own file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Combination {
    /// It is the mean of repeated trials.
    Average {
        /// The recordings of the file that are trials, from 1; all of them where none is named.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        trials: Vec<usize>,
        /// Further files with trials of the same motion.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        files: Vec<PathBuf>,
        /// Whether trials that do not belong are left out.
        #[serde(default)]
        leave_out_misfits: bool,
        /// Whether the zeros are made those of the first trial.
        #[serde(default)]
        match_zeros: bool,
    },
    /// The other point of the device is in a second run under the same drive.
    Points {
        /// The file of the second run.
        other: PathBuf,
        /// Whether the second run has the proof mass, and the first one the cantilever.
        #[serde(default)]
        other_is_proof_mass: bool,
        /// To be added to the times of the cantilever's run \[s\]; by the voltages where it is `None`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lag: Option<f64>,
    },
}

impl Combination {
    /// The mean of all recordings of the file, as they are.
    #[must_use]
    pub fn average_of_all() -> Self {
        Combination::Average {
            trials: Vec::new(),
            files: Vec::new(),
            leave_out_misfits: false,
            match_zeros: false,
        }
    }
}
