//! The outcome of work on a file, as the window receives it.

use std::path::PathBuf;
use std::sync::Arc;

use super::session_text::{Loaded, RecordingEntry};
use crate::app::setup::overlay::OverlayId;
use crate::explore::waveform::EditableWaveform;
use crate::explore::waveform::export::GeneratorFormat;
use crate::learn::lesson::Lesson;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::recording::align::Aligned;
use crate::recording::csv::{ImportSettings, Preview};

/// The outcome of work on a file.
#[derive(Debug)]
pub enum FileEvent {
    /// A recording was read, with these settings.
    Recording {
        path: PathBuf,
        settings: Box<ImportSettings>,
        recording: Arc<Recording>,
        /// Its entry in the session, if it belongs to one.
        entry: Option<Box<RecordingEntry>>,
    },
    /// A recording whose columns the person must choose.
    Ask {
        path: PathBuf,
        preview: Box<Preview>,
    },
    /// A preset was read.
    Preset { preset: Box<Preset> },
    /// A session was read; its recordings are read next.
    Session { path: PathBuf, loaded: Box<Loaded> },
    /// The work failed: what happened, where, and what to do.
    Failed { message: String },
    /// A file was saved.
    Saved {
        purpose: Purpose,
        path: PathBuf,
        /// What the file does not hold as shown.
        remark: Option<&'static str>,
    },
    /// A recording's shift onto the simulation was found.
    Aligned { id: OverlayId, found: Aligned },
    /// The file of a session's recording is missing.
    Lost { id: OverlayId, message: String },
    /// A drawn waveform was read.
    Drawn { drawn: Box<EditableWaveform> },
    /// A lesson was read.
    Lesson { lesson: Box<Lesson> },
    /// A drive was read.
    Drive { waveform: Waveform },
    /// The system has no file dialog, so the path must be typed; `None` is for opening.
    TypePath { purpose: Option<Purpose> },
    /// The person chose where to save.
    SaveTo { purpose: Purpose, path: PathBuf },
}

/// What is saved to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The session.
    Session,
    /// The device as a preset.
    Preset,
    /// The visible plots as SVG.
    Svg,
    /// The visible plots as PNG.
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
    /// The drawn waveform.
    Waveform,
    /// One period of the drawn waveform for a function generator.
    Generator(GeneratorFormat),
    /// The contacts of a gait.
    GaitContacts,
    /// A map.
    Map,
    /// The answers to all lessons.
    Answers,
    /// A film.
    Film,
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
            Purpose::Waveform => "waveform.toml",
            Purpose::Generator(GeneratorFormat::Keysight) => "waveform.arb",
            Purpose::Generator(_) => "waveform.csv",
            Purpose::GaitContacts => "gait.csv",
            Purpose::Map => "map.csv",
            Purpose::Answers => "answers.csv",
            Purpose::Film => "film.gif",
        }
    }
}

pub(crate) fn failed(error: &dyn std::error::Error) -> FileEvent {
    FileEvent::Failed {
        message: error.to_string(),
    }
}
