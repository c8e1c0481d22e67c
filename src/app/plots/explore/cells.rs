//! A picture of cells over two axes: an image, stretched so that each cell is centred on its point.
//! Cells without colour show hatching.

use std::sync::Arc;

use eframe::egui::{
    Color32, ColorImage, Id, Pos2, Rect, Shape, Stroke, TextureHandle, TextureOptions, Ui, Vec2,
    pos2,
};

use super::plane::{Plane, PlaneAxis, PlaneOutput};
use crate::app::plots::frame::layer::Layer;
use crate::app::plots::frame::style;

/// Distance of the lines of the hatching \[points\].
const HATCH_SPACING: f32 = 7.0;

/// A picture of cells.
pub struct CellPicture<'a> {
    /// Its id, and the beginning of its name for screen readers.
    pub name: &'a str,
    /// Horizontal and vertical axis; their ranges are those of the first and the last point.
    pub axes: [PlaneAxis; 2],
    /// Points along both.
    pub counts: [usize; 2],
    /// What the colours depend on: they are computed anew when it changes.
    pub version: u64,
}

/// The texture of a picture, with what it was made of.
#[derive(Clone)]
struct Painted {
    version: u64,
    texture: TextureHandle,
}

impl CellPicture<'_> {
    /// Draws it with layers over the cells. `colors` gives the colour of each cell, the first axis
    /// counting fastest; a transparent one is a hole. It is only called when the version changes.
    pub fn show(
        self,
        ui: &mut Ui,
        size: Vec2,
        colors: impl FnOnce() -> Vec<Color32>,
        over: Vec<Layer>,
    ) -> PlaneOutput {
        let texture = self.texture(ui, colors);
        let [x, y] = self.axes.clone();
        let plane = Plane {
            name: self.name,
            x,
            y,
            size,
            has_x: true,
        };
        let hatch = style::palette(ui).text.gamma_multiply(0.5);
        let mut layers = vec![hatching(hatch), self.image(&plane, texture)];
        layers.extend(over);
        plane.show(ui, layers)
    }

    fn texture(&self, ui: &Ui, colors: impl FnOnce() -> Vec<Color32>) -> TextureHandle {
        let key = Id::unique(("cell picture", self.name));
        let known: Option<Painted> = ui.data(|data| data.get_temp(key));
        let [columns, rows] = self.counts;
        let wanted = [columns, rows];
        if let Some(known) = &known
            && known.version == self.version
            && known.texture.size() == wanted
        {
            return known.texture.clone();
        }
        let colors = colors();
        // The first row of an image is the upper one.
        let pixels = (0..rows).rev().flat_map(|j| {
            let start = (j * columns).min(colors.len());
            let end = (start + columns).min(colors.len());
            colors[start..end].iter().copied()
        });
        let mut pixels: Vec<Color32> = pixels.collect();
        pixels.resize(columns * rows, Color32::TRANSPARENT);
        let image = ColorImage::new(wanted, pixels);
        let texture = match known {
            Some(mut known) => {
                known.texture.set(image, TextureOptions::NEAREST);
                known.texture
            }
            None => ui
                .ctx()
                .load_texture(self.name, image, TextureOptions::NEAREST),
        };
        let painted = Painted {
            version: self.version,
            texture: texture.clone(),
        };
        ui.data_mut(|data| data.insert_temp(key, painted));
        texture
    }

    /// The image as a layer: it reaches half a cell beyond the first and the last point.
    fn image(&self, plane: &Plane<'_>, texture: TextureHandle) -> Layer {
        let scales = plane.scales();
        let texture = Arc::new(texture);
        let ends = |axis: &PlaneAxis, scale: super::plane::AxisScale, count: usize| {
            let (a, b) = (scale.place(axis.range.0), scale.place(axis.range.1));
            let half = 0.5 * (b - a) / count.saturating_sub(1).max(1) as f64;
            (a - half, b + half)
        };
        let (left, right) = ends(&self.axes[0], scales.x, self.counts[0]);
        let (low, high) = ends(&self.axes[1], scales.y, self.counts[1]);
        Layer::new(move |_, transform, shapes| {
            // The corners of the first and of the last cell, whichever way the axes run.
            let first = pos2(
                transform.position_from_point_x(left),
                transform.position_from_point_y(low),
            );
            let last = pos2(
                transform.position_from_point_x(right),
                transform.position_from_point_y(high),
            );
            let flip = |is_flipped: bool| if is_flipped { (1.0, 0.0) } else { (0.0, 1.0) };
            let (u0, u1) = flip(first.x > last.x);
            let (v0, v1) = flip(first.y < last.y);
            let uv = Rect::from_min_max(Pos2::new(u0, v0), Pos2::new(u1, v1));
            let place = Rect::from_two_pos(first, last);
            shapes.push(Shape::image(texture.id(), place, uv, Color32::WHITE));
        })
    }
}

/// Diagonal lines over the whole frame; the cells cover them.
fn hatching(color: Color32) -> Layer {
    Layer::new(move |_, transform, shapes| {
        let frame = *transform.frame();
        let stroke = Stroke::new(1.0, color);
        let mut x = frame.left() - frame.height();
        while x < frame.right() {
            let ends = [
                pos2(x, frame.bottom()),
                pos2(x + frame.height(), frame.top()),
            ];
            shapes.push(Shape::line_segment(ends, stroke));
            x += HATCH_SPACING;
        }
    })
}
