//! A film of a scene: the same pictures as in the window, drawn without one, a picture after the
//! other. As a GIF, or as numbered PNG files.

mod frames;
mod raster;
#[cfg(test)]
mod tests;

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, ImageFormat, RgbaImage};
use thiserror::Error;

use self::frames::Studio;
use crate::app::analysis::explore::latest::Answers;
use crate::app::analysis::learning::presenting::SavedScene;
use crate::app::analysis::learning::runs::{SceneQuestion, SceneResult, SceneRuns};
use crate::app::files::atomic_write::{SessionError, write_atomically};
use crate::learn::playback::Playback;

/// Pictures a second.
const FILM_RATE: u32 = 25;
/// Width and height of a film \[pixels\].
const FILM_SIZE: [u32; 2] = [1280, 720];
/// Most pictures of a film: a minute.
const MAX_FRAMES: usize = 60 * FILM_RATE as usize;
/// How long the last picture stands \[ms\], so that a loop is seen to end.
const LAST_FRAME_TIME: u32 = 1000;
/// Effort of the search for 256 colours: 1 is the most, 30 the least.
const GIF_SPEED: i32 = 20;

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
    fn moments(&self, result: &SceneResult) -> Result<Vec<f64>, FilmError> {
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

/// Films and writes to `path`: PNG files beside it if it ends with `.png`, else a GIF. `progress` is
/// told how far it is, from 0 to 1, and answers whether to go on. Returns whether it was finished.
///
/// # Errors
/// [`FilmError`].
pub fn write(
    request: &FilmRequest,
    path: &Path,
    progress: &dyn Fn(f32) -> bool,
) -> Result<bool, FilmError> {
    let question = SceneQuestion {
        scene: request.saved.scene.clone(),
        step: None,
        round: None,
    };
    let result = SceneRuns::default().answer(&question, &|| progress(0.0));
    let result = match result {
        Ok(result) => result,
        Err(_) if !progress(0.0) => return Ok(false),
        Err(error) => return Err(FilmError::Scene(error)),
    };
    let moments = request.moments(&result)?;
    let mut studio = Studio::new(request, FILM_SIZE);
    let is_png = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let mut gif = Vec::new();
    let mut encoder = (!is_png).then(|| GifEncoder::new_with_speed(&mut gif, GIF_SPEED));
    if let Some(encoder) = &mut encoder {
        encoder.set_repeat(Repeat::Infinite)?;
    }
    let count = moments.len();
    for (i, time) in moments.into_iter().enumerate() {
        if !progress(i as f32 / count as f32) {
            return Ok(false);
        }
        let picture = studio.picture(request, &result, time);
        match &mut encoder {
            None => write_atomically(&numbered(path, i + 1), &png(picture)?)?,
            Some(encoder) => {
                let last = i + 1 == count;
                let length = if last {
                    LAST_FRAME_TIME
                } else {
                    1000 / FILM_RATE
                };
                let delay = Delay::from_numer_denom_ms(length, 1);
                encoder.encode_frame(Frame::from_parts(picture, 0, 0, delay))?;
            }
        }
    }
    drop(encoder);
    if !is_png {
        write_atomically(path, &gif)?;
    }
    Ok(true)
}

fn png(picture: RgbaImage) -> Result<Vec<u8>, FilmError> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// `film.png` with the number of a picture: `film-0012.png`.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{number:04}.png"))
}
