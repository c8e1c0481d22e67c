//! Lines, areas and text in points, onto any backend of plotters.

use eframe::egui::Color32;
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, IntoFont, RGBAColor, ShapeStyle, TextStyle};

use super::error::ExportError;

/// Name of the font. Viewers of an SVG know this generic name.
pub const FONT: &str = "sans-serif";
/// The size that plotters takes for a font of one point.
const FONT_UNIT: f64 = 1.24;
/// Length of a dash and of the gap after it \[points\].
const DASH_AND_GAP: [f64; 2] = [6.0, 4.0];

/// A position \[points\] from the upper left corner.
pub type Place = [f64; 2];

/// Where text lies relative to its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Starts at the position, centred vertically.
    Left,
    /// Ends at the position, centred vertically.
    Right,
    /// Centred at the position.
    Middle,
    /// Rotated to read upwards, centred at the position.
    Upwards,
}

/// A rectangle \[points\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Left upper corner.
    pub min: Place,
    /// Right lower corner.
    pub max: Place,
}

impl Frame {
    /// The part of the segment from `a` to `b` that lies inside (Liang and Barsky 1984).
    pub fn clip(&self, a: Place, b: Place) -> Option<(Place, Place)> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for axis in 0..2 {
            let step = b[axis] - a[axis];
            for (side, distance) in [
                (-step, a[axis] - self.min[axis]),
                (step, self.max[axis] - a[axis]),
            ] {
                if side == 0.0 {
                    if distance < 0.0 {
                        return None;
                    }
                } else if side < 0.0 {
                    from = from.max(distance / side);
                } else {
                    to = to.min(distance / side);
                }
            }
        }
        let at = |share: f64| [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
        (from <= to).then(|| (at(from), at(to)))
    }
}

fn plain(color: Color32) -> RGBAColor {
    let [r, g, b, a] = color.to_srgba_unmultiplied();
    RGBAColor(r, g, b, f64::from(a) / 255.0)
}

/// A style of text of plotters.
fn style(color: Color32, size: f64, anchor: Anchor) -> TextStyle<'static> {
    let (h, v) = match anchor {
        Anchor::Left => (HPos::Left, VPos::Center),
        Anchor::Right => (HPos::Right, VPos::Center),
        Anchor::Middle | Anchor::Upwards => (HPos::Center, VPos::Center),
    };
    let font = (FONT, FONT_UNIT * size).into_font();
    let font = match anchor {
        Anchor::Upwards => font.transform(FontTransform::Rotate270),
        _ => font,
    };
    TextStyle {
        font,
        color: plain(color).to_backend_color(),
        pos: Pos::new(h, v),
    }
}

/// Width of a text \[points\].
pub fn text_width(text: &str, size: f64) -> Result<f64, ExportError> {
    // Measured at ten times the size, because plotters answers in whole numbers.
    let font = (FONT, 10.0 * FONT_UNIT * size).into_font();
    let (width, _) = font.box_size(text).map_err(refused)?;
    Ok(f64::from(width) / 10.0)
}

fn refused(error: impl std::fmt::Display) -> ExportError {
    ExportError::Drawing(error.to_string())
}

/// Something to draw on.
pub struct Canvas<B: DrawingBackend> {
    backend: B,
    scale: f64,
    paths: bool,
}

impl<B: DrawingBackend> Canvas<B> {
    /// A canvas with `scale` backend units per point. Without `paths` a line is drawn
    /// segment by segment: the bitmap backend of plotters draws wide paths with sharp
    /// turns badly.
    pub fn new(backend: B, scale: f64, paths: bool) -> Self {
        Self {
            backend,
            scale,
            paths,
        }
    }

    fn place(&self, at: Place) -> (i32, i32) {
        let unit = |x: f64| (x * self.scale).round() as i32;
        (unit(at[0]), unit(at[1]))
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, frame: Frame, color: Color32) -> Result<(), ExportError> {
        let (min, max) = (self.place(frame.min), self.place(frame.max));
        self.backend
            .draw_rect(min, max, &plain(color), true)
            .map_err(refused)
    }

    /// Fills a convex polygon.
    pub fn polygon(&mut self, corners: &[Place], color: Color32) -> Result<(), ExportError> {
        let corners: Vec<_> = corners.iter().map(|&corner| self.place(corner)).collect();
        self.backend
            .fill_polygon(corners, &plain(color))
            .map_err(refused)
    }

    /// Draws a line, `width` points wide.
    pub fn line(
        &mut self,
        points: &[Place],
        color: Color32,
        width: f64,
    ) -> Result<(), ExportError> {
        let stroke = ShapeStyle {
            color: plain(color),
            filled: false,
            stroke_width: (width * self.scale).round().max(1.0) as u32,
        };
        if self.paths {
            let path: Vec<_> = points.iter().map(|&point| self.place(point)).collect();
            return self.backend.draw_path(path, &stroke).map_err(refused);
        }
        for pair in points.windows(2) {
            // Each segment is extended under the next one, so that turns are closed.
            let step = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let length = step[0].hypot(step[1]).max(1e-9);
            let reach = step.map(|s| 0.3 * width * s / length);
            let from = self.place([pair[0][0] - reach[0], pair[0][1] - reach[1]]);
            let to = self.place([pair[1][0] + reach[0], pair[1][1] + reach[1]]);
            self.backend.draw_line(from, to, &stroke).map_err(refused)?;
        }
        Ok(())
    }

    /// Draws a dashed line.
    pub fn dashed(
        &mut self,
        points: &[Place],
        color: Color32,
        width: f64,
    ) -> Result<(), ExportError> {
        for dash in dashes(points) {
            self.line(&dash, color, width)?;
        }
        Ok(())
    }

    /// Writes text of `size` points.
    pub fn text(
        &mut self,
        text: &str,
        at: Place,
        size: f64,
        color: Color32,
        anchor: Anchor,
    ) -> Result<(), ExportError> {
        let style = style(color, size * self.scale, anchor);
        let at = self.place(at);
        self.backend.draw_text(text, &style, at).map_err(refused)
    }

    /// Ends the drawing.
    pub fn finish(&mut self) -> Result<(), ExportError> {
        self.backend.present().map_err(refused)
    }
}

/// Cuts a line into dashes.
fn dashes(points: &[Place]) -> Vec<Vec<Place>> {
    let mut all = Vec::new();
    let mut dash: Vec<Place> = points.first().copied().into_iter().collect();
    let (mut drawing, mut remaining) = (true, DASH_AND_GAP[0]);
    for pair in points.windows(2) {
        let (mut a, b) = (pair[0], pair[1]);
        let mut length = (b[0] - a[0]).hypot(b[1] - a[1]);
        while length > remaining {
            let share = remaining / length;
            a = [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
            length -= remaining;
            if drawing {
                dash.push(a);
                all.push(std::mem::take(&mut dash));
            } else {
                dash = vec![a];
            }
            drawing = !drawing;
            remaining = DASH_AND_GAP[usize::from(!drawing)];
        }
        remaining -= length;
        if drawing {
            dash.push(b);
        }
    }
    if dash.len() > 1 {
        all.push(dash);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::canvas::*;

    #[test]
    fn lines_are_cut_at_the_frame() {
        let frame = Frame {
            min: [0.0, 0.0],
            max: [10.0, 10.0],
        };
        assert_eq!(
            frame.clip([-5.0, 5.0], [15.0, 5.0]),
            Some(([0.0, 5.0], [10.0, 5.0]))
        );
        assert_eq!(frame.clip([-5.0, 5.0], [-1.0, 5.0]), None);
        assert_eq!(frame.clip([2.0, 20.0], [8.0, 20.0]), None);
        let inside = ([1.0, 1.0], [2.0, 9.0]);
        assert_eq!(frame.clip(inside.0, inside.1), Some(inside));
    }

    #[test]
    fn dashes_have_their_lengths() {
        let cut = dashes(&[[0.0, 0.0], [3.0, 0.0], [13.0, 0.0]]);
        assert_eq!(cut.len(), 2);
        assert_eq!(cut[0], [[0.0, 0.0], [3.0, 0.0], [6.0, 0.0]]);
        assert_eq!(cut[1], [[10.0, 0.0], [13.0, 0.0]]);
    }
}
