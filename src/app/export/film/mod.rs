//! A film of a scene: the same pictures as in the window, drawn without one, a picture after the
//! other. As a GIF, or as numbered PNG files.

mod frames;
mod raster;
mod request;
#[cfg(test)]
mod tests;

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, ImageFormat, RgbaImage};

use self::frames::Studio;
use self::request::FILM_RATE;
pub use self::request::{FilmError, FilmRequest};
use crate::app::analysis::explore::latest::Answers;
use crate::app::analysis::learning::runs::{SceneQuestion, SceneRuns};
use crate::app::files::atomic_write::write_atomically;

/// Width and height of a film \[pixels\].
const FILM_SIZE: [u32; 2] = [1280, 720];
/// How long the last picture stands \[ms\], so that a loop is seen to end.
const LAST_FRAME_TIME: u32 = 1000;
/// Effort of the search for 256 colours: 1 is the most, 30 the least.
const GIF_SPEED: i32 = 20;

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
