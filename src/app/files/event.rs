//! TODO-doc

use std::path::PathBuf;
use std::sync::Arc;

use super::session_text::{Loaded, RecordingEntry};
use crate::app::setup::overlay::OverlayId;
use crate::app::setup::reference_curve::Kept;
use crate::app::simulation::snapshot::Snapshot;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::recording::align::Aligned;
use crate::recording::csv::{ImportSettings, Preview};

/// What became of a file.
#[derive(Debug)]
pub enum FileEvent {
    /// A recording, and how its columns were read.
    Recording {
        path: PathBuf,
        settings: ImportSettings,
        recording: Arc<Recording>,
        /// What a session remembers of it, if it came from one.
        entry: Option<RecordingEntry>,
    },
    /// A recording whose columns the person must name.
    Ask { path: PathBuf, preview: Preview },
    /// A preset.
    Preset { preset: Box<Preset> },
    /// A session, its recordings still to come.
    Session { path: PathBuf, loaded: Box<Loaded> },
    /// It could not be opened: what, where, what to do.
    Failed { message: String },
    /// It was saved.
    Saved { purpose: Purpose, path: PathBuf },
    /// A recording's shift onto the simulation was found.
    Aligned { id: OverlayId, found: Aligned },
    /// A recording of a session that is not there.
    Lost { id: OverlayId, message: String },
    /// A drive read from a file.
    Drive { waveform: Waveform },
    /// A session's kept curve was computed again.
    Kept {
        kept: Box<Kept>,
        run: Result<Arc<Snapshot>, String>,
    },
    /// The system has no file dialog: the path must be typed. `None` is for opening.
    TypePath { purpose: Option<Purpose> },
    /// A place to save to was chosen.
    SaveTo { purpose: Purpose, path: PathBuf },
}

/// What a file is saved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The session.
    Session,
    /// The device as a preset.
    Preset,
    /// The visible plots.
    Svg,
    /// The visible plots.
    Png,
    /// The simulated trace.
    Trace,
    /// The events.
    Events,
    /// The diagnosed device as a preset.
    Diagnosed,
    /// The report of the diagnosis.
    Report,
    /// The diagnosis for programs.
    Diagnosis,
}

impl Purpose {
    /// Suggested file name.
    pub fn file_name(self) -> &'static str {
        match self {
            Purpose::Session => "session.impactscope.toml",
            Purpose::Preset => "device.toml",
            Purpose::Svg => "plots.svg",
            Purpose::Png => "plots.png",
            Purpose::Trace => "trace.csv",
            Purpose::Events => "events.csv",
            Purpose::Diagnosed => "diagnosed-device.toml",
            Purpose::Report => "diagnosis.html",
            Purpose::Diagnosis => "diagnosis.json",
        }
    }
}

pub(crate) fn failed(error: &dyn std::error::Error) -> FileEvent {
    FileEvent::Failed {
        message: error.to_string(),
    }
}
