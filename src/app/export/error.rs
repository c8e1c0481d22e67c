//! Why plots could not be exported.

use std::path::PathBuf;

use thiserror::Error;

/// Why there is no file.
#[derive(Debug, Error)]
pub enum ExportError {
    /// Nothing but the device is shown.
    #[error("no plot is shown that could be exported; switch one on, for example the trajectory")]
    NothingShown,
    /// The drawing library refused.
    #[error("the plots could not be drawn: {0}")]
    Drawing(String),
    /// The picture could not be encoded.
    #[error("the picture could not be encoded: {0}")]
    Encoding(#[from] image::ImageError),
    /// The file could not be written; an older one of that name is untouched.
    #[error("{path}: {reason}", path = path.display())]
    Writing {
        /// Which file.
        path: PathBuf,
        /// The system's words and what to do.
        reason: String,
    },
}
