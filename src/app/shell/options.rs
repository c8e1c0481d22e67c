//! What the window is opened with, and why it cannot be opened.

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
    /// Save a picture of the settled window here, then end.
    pub screenshot: Option<PathBuf>,
}

/// Why there is no window.
#[derive(Debug, Error)]
pub enum AppError {
    /// There is no usable display.
    #[error(
        "no window can be opened ({0}); without a display use a command: impactscope simulate --help"
    )]
    NoWindow(String),
    /// The preset cannot be used.
    #[error(transparent)]
    Preset(#[from] PresetError),
    /// A named file could not be opened; the screenshot was saved without it.
    #[error("{0}")]
    File(String),
    /// The picture could not be saved.
    #[error("no picture was saved: {0}")]
    Screenshot(String),
}
