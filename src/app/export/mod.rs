//! The visible plots as a vector or a pixel picture, made anew with plotters: the same
//! ranges, curves and labels, on white.

mod charts;
mod draw;

use std::path::{Path, PathBuf};
use std::sync::Once;

use plotters::prelude::*;
use thiserror::Error;

use super::session::{SessionError, write_atomically};
use super::state::State;

/// Width of a picture [pixels].
const WIDTH: u32 = 1400;
/// Height of each plot in it [pixels].
const ROW: u32 = 340;

/// Why nothing was exported.
#[derive(Debug, Error)]
pub enum ExportError {
    /// There is nothing in view.
    #[error("there is no plot to export; show one in the View menu")]
    Nothing,
    /// The picture could not be drawn.
    #[error("{}: the picture could not be drawn: {reason}", path.display())]
    Drawing { path: PathBuf, reason: String },
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] SessionError),
}

/// The text of pixel pictures needs a font of its own: none of the system's is asked for.
fn font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let bytes = epaint_default_fonts::UBUNTU_LIGHT;
        if plotters::style::register_font("sans-serif", FontStyle::Normal, bytes).is_err() {
            log::warn!("the built-in font was refused");
        }
    });
}

/// Writes the visible plots as SVG.
///
/// # Errors
/// [`ExportError`].
pub fn svg(path: &Path, state: &State) -> Result<(), ExportError> {
    font();
    let charts = charts::of(state);
    let height = height(&charts)?;
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        draw::all(&area, &charts).map_err(|reason| drawing(path, reason))?;
        area.present()
            .map_err(|error| drawing(path, error.to_string()))?;
    }
    Ok(write_atomically(path, text.as_bytes())?)
}

/// Writes the visible plots as PNG.
///
/// # Errors
/// [`ExportError`].
pub fn png(path: &Path, state: &State) -> Result<(), ExportError> {
    font();
    let charts = charts::of(state);
    let height = height(&charts)?;
    let mut pixels = vec![255; (WIDTH * height * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, (WIDTH, height)).into_drawing_area();
        draw::all(&area, &charts).map_err(|reason| drawing(path, reason))?;
        area.present()
            .map_err(|error| drawing(path, error.to_string()))?;
    }
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_raw(WIDTH, height, pixels)
        .ok_or_else(|| drawing(path, "the picture has a wrong size".to_owned()))?
        .write_to(&mut bytes, image::ImageFormat::Png)
        .map_err(|error| drawing(path, error.to_string()))?;
    Ok(write_atomically(path, bytes.get_ref())?)
}

fn height(charts: &[charts::Chart]) -> Result<u32, ExportError> {
    if charts.is_empty() {
        return Err(ExportError::Nothing);
    }
    Ok(ROW * charts.len() as u32)
}

fn drawing(path: &Path, reason: String) -> ExportError {
    ExportError::Drawing {
        path: path.to_owned(),
        reason,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use super::*;
    use crate::app::first_start;
    use crate::app::setup::{Picture, View};
    use crate::app::snapshot::Snapshot;
    use crate::model::drive::Waveform;
    use crate::sim::{Options, simulate};

    fn state() -> State {
        let setup = first_start::setup();
        let drive = Waveform::parse("square:15Hz:8V", 0.2).unwrap();
        let options = Options {
            forces: true,
            ..Options::default()
        };
        let model = Arc::new(setup.preset.model.clone());
        let trace = Arc::new(simulate(&model, &drive, 0.2, &options).unwrap());
        let snapshot = Snapshot::new(1, &model, trace, &setup.overlays, Duration::ZERO);
        let view = View {
            pictures: Picture::ALL.into(),
            ..View::default()
        };
        let mut state = first_start::state(setup, view);
        state.ghost = Some(Arc::new(snapshot.clone()));
        state.snapshot = Some(Arc::new(snapshot));
        state
    }

    #[test]
    fn svg_has_all_plots_with_their_units() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plots.svg");
        svg(&path, &state()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        for label in [
            "V [V]",
            "displacement [µm]",
            "residual",
            "force",
            "velocity",
            "time [ms]",
            "xp",
            "xc",
            "ground",
            "made-up recording",
        ] {
            assert!(text.contains(label), "{label}");
        }
        // Decimated: some hundred kilobytes, not every sample.
        assert!(text.len() < 3_000_000, "{}", text.len());
    }

    #[test]
    fn png_is_a_picture_with_something_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plots.png");
        png(&path, &state()).unwrap();
        let picture = image::open(&path).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (WIDTH, 6 * ROW));
        let drawn = picture.pixels().filter(|p| p.0 != [255; 3]).count();
        assert!(drawn > 50_000, "{drawn}");
    }

    #[test]
    fn faults_are_named() {
        let mut state = state();
        let nowhere = Path::new("/no/such/folder/plots.svg");
        let error = svg(nowhere, &state).unwrap_err().to_string();
        assert!(error.contains("/no/such/folder"), "{error}");
        state.view.pictures = [Picture::Device].into();
        let error = svg(nowhere, &state).unwrap_err();
        assert!(matches!(error, ExportError::Nothing));
    }
}
