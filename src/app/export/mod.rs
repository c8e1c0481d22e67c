//! The visible pictures in files: SVG for print, PNG for everything else.
//!
//! Both are drawn from the same [`Sheet`], with the ranges, units and curves of the
//! window, on white. The device's picture is not exported: it shows one instant, not a result.

mod canvas;
pub mod error;
pub mod film;
pub(crate) mod map_csv;
mod page;
pub mod sheet;
#[cfg(test)]
mod tests;
pub mod trace_csv;

use std::io::Cursor;
use std::path::Path;
use std::sync::OnceLock;

use image::{ImageFormat, RgbImage};
use plotters::prelude::{BitMapBackend, SVGBackend};
use plotters::style::{FontStyle, register_font};

use self::canvas::Canvas;
use self::error::ExportError;
use self::page::Page;
use self::sheet::Sheet;
use super::files::atomic_write::write_atomically;
use super::state::State;

/// Width of the axes' area of a page \[points\].
const PAGE_WIDTH: f64 = 1100.0;
/// Units of the SVG drawing per point. The backend takes whole numbers only, so tenths of
/// a point keep curves smooth.
const SVG_UNITS: f64 = 10.0;
/// Pixels of the PNG per point.
const PNG_PIXELS: u32 = 2;
/// Pixels drawn per pixel of the PNG, in each direction; their mean smooths edges.
const OVERSAMPLING: u32 = 2;

/// Writes the visible pictures as SVG to `path`.
///
/// # Errors
/// [`ExportError`]; an older file at `path` is then as it was.
pub fn svg(path: &Path, state: &State) -> Result<(), ExportError> {
    write(path, svg_text(&sheet(state)?)?.as_bytes())
}

/// Writes the visible pictures as PNG to `path`, at two pixels a point.
///
/// # Errors
/// [`ExportError`]; an older file at `path` is then as it was.
pub fn png(path: &Path, state: &State) -> Result<(), ExportError> {
    write(path, &png_bytes(&sheet(state)?)?)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    write_atomically(path, bytes).map_err(|error| ExportError::Writing {
        path: path.to_owned(),
        reason: match error {
            super::files::atomic_write::SessionError::Io { source, .. } => {
                format!("{source}; check that the folder exists and can be written")
            }
            other => other.to_string(),
        },
    })
}

fn sheet(state: &State) -> Result<Sheet, ExportError> {
    let sheet = Sheet::of(state, PAGE_WIDTH);
    if sheet.is_empty() {
        return Err(ExportError::NothingShown);
    }
    Ok(sheet)
}

/// Gives plotters the window's font. In an SVG it only serves for measuring.
fn font() -> Result<(), ExportError> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let registered = *REGISTERED.get_or_init(|| {
        let bytes = epaint_default_fonts::UBUNTU_LIGHT;
        register_font(canvas::FONT, FontStyle::Normal, bytes).is_ok()
    });
    let refused = || ExportError::Drawing("the font is refused".to_owned());
    registered.then_some(()).ok_or_else(refused)
}

fn svg_text(sheet: &Sheet) -> Result<String, ExportError> {
    font()?;
    let page = Page::new(sheet, PAGE_WIDTH)?;
    let size = page.size.map(|side| (side * SVG_UNITS).round() as u32);
    let mut text = String::new();
    page.draw(&mut Canvas::new(
        SVGBackend::with_string(&mut text, (size[0], size[1])),
        SVG_UNITS,
        true,
    ))?;
    // Drawn in tenths of a point, shown in points.
    let drawn = format!("width=\"{}\" height=\"{}\"", size[0], size[1]);
    let shown = format!("width=\"{}\" height=\"{}\"", page.size[0], page.size[1]);
    Ok(text.replacen(&drawn, &shown, 1))
}

fn png_bytes(sheet: &Sheet) -> Result<Vec<u8>, ExportError> {
    font()?;
    let page = Page::new(sheet, PAGE_WIDTH)?;
    let [width, height] = page.size.map(|side| (side.ceil() as u32) * PNG_PIXELS);
    let (wide, high) = (width * OVERSAMPLING, height * OVERSAMPLING);
    let mut fine = vec![0u8; wide as usize * high as usize * 3];
    page.draw(&mut Canvas::new(
        BitMapBackend::with_buffer(&mut fine, (wide, high)),
        f64::from(PNG_PIXELS * OVERSAMPLING),
        false,
    ))?;
    let (step, row) = (OVERSAMPLING as usize, wide as usize * 3);
    let image = RgbImage::from_fn(width, height, |x, y| {
        let corner = y as usize * step * row + x as usize * step * 3;
        image::Rgb([0, 1, 2].map(|channel| {
            let sum: usize = (0..step * step)
                .map(|i| corner + (i / step) * row + (i % step) * 3 + channel)
                .map(|at| usize::from(fine[at]))
                .sum();
            (sum / (step * step)) as u8
        }))
    });
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}
