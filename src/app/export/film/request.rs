//! What is filmed, and why there may be no film of it.

use thiserror::Error;

use crate::app::analysis::learning::presenting::SavedScene;
use crate::app::analysis::learning::runs::SceneResult;
use crate::app::files::atomic_write::SessionError;
use crate::learn::playback::Playback;

/// Pictures a second.
pub(super) const FILM_RATE: u32 = 25;
/// Most pictures of a film: a minute.
const MAX_FRAMES: usize = 60 * FILM_RATE as usize;

/// Why there is no film.
#[derive(Debug, Error)]
pub enum FilmError {
    /// The scene has no run.
    #[error("the scene cannot be simulated: {0}")]
    Scene(String),
    /// The span is empty.
    #[error("the film would end before it begins; set its beginning and end anew")]
    EmptySpan,
    /// The film would be too long.
    #[error(
        "the film would have more than {MAX_FRAMES} pictures; play it faster, or choose a shorter span"
    )]
    TooLong,
    /// A picture could not be encoded.
    #[error("a picture could not be encoded: {0}")]
    Encoding(#[from] image::ImageError),
    /// A file could not be written.
    #[error(transparent)]
    Writing(#[from] SessionError),
}

/// What is filmed.
#[derive(Debug, Clone)]
pub struct FilmRequest {
    /// The scene with its pictures.
    pub saved: SavedScene,
    /// First and last moment \[s\].
    pub span: (f64, f64),
    /// Whether it is slow at impacts.
    pub is_slow_at_impacts: bool,
    /// Dark or light.
    pub dark: bool,
}

impl FilmRequest {
    /// A film of a scene over a span \[s\].
    pub fn new(saved: SavedScene, span: (f64, f64), dark: bool) -> Self {
        Self {
            saved,
            span: (span.0.min(span.1), span.0.max(span.1)),
            is_slow_at_impacts: false,
            dark,
        }
    }

    /// Slow at impacts, or not.
    pub fn slow_at_impacts(mut self, is_slow: bool) -> Self {
        self.is_slow_at_impacts = is_slow;
        self
    }

    /// The moments of its pictures \[s\].
    pub(super) fn moments(&self, result: &SceneResult) -> Result<Vec<f64>, FilmError> {
        let (from, to) = self.span;
        let end = to.min(result.run.duration);
        if from >= end {
            return Err(FilmError::EmptySpan);
        }
        let mut play = Playback::new(self.saved.speed);
        play.slows_at_impacts = self.is_slow_at_impacts;
        play.is_playing = true;
        play.time = from;
        let mut moments = Vec::new();
        while play.time < end {
            moments.push(play.time);
            if moments.len() > MAX_FRAMES {
                return Err(FilmError::TooLong);
            }
            play.advance(1.0 / f64::from(FILM_RATE), end, &result.slow);
        }
        moments.push(end);
        Ok(moments)
    }
}
