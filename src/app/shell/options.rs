//! TODO-doc

use std::path::PathBuf;

use thiserror::Error;

use crate::model::preset::PresetError;

/// What to open the window with.
#[derive(Debug, Clone, Default)]
pub struct WindowOptions {
    /// Recordings, presets, a session.
    pub files: Vec<PathBuf>,
    /// Preset by name or path.
    pub preset: Option<String>,
    /// Workspace by name.
    pub workspace: Option<String>,
    /// Save a picture of the settled window here and end.
    pub screenshot: Option<PathBuf>,
}

/// Why there is no window.
#[derive(Debug, Error)]
pub enum AppError {
    /// There is no display, or none that can be drawn on.
    #[error(
        "no window can be opened ({0}); without a display use a command: impactscope simulate --help"
    )]
    NoWindow(String),
    /// The preset cannot be used.
    #[error(transparent)]
    Preset(#[from] PresetError),
    /// What was named could not be opened; its picture shows the rest.
    #[error("{0}")]
    File(String),
    /// The picture could not be saved.
    #[error("no picture was saved: {0}")]
    Screenshot(String),
}
