//! Triangles as pixels, without a graphics card: what a film needs of it. Colours are blended as the
//! window blends them, in gamma space with premultiplied alpha.

use std::collections::HashMap;

use eframe::egui::epaint::textures::TexturesDelta;
use eframe::egui::epaint::{ClippedPrimitive, ImageData, Primitive, Vertex};
use eframe::egui::{Color32, ColorImage, Rect, TextureId};
use image::{Rgba, RgbaImage};

/// A picture being painted.
pub(super) struct Raster {
    size: [u32; 2],
    /// Premultiplied red, green, blue; the picture is opaque.
    pixels: Vec<[f32; 3]>,
    textures: HashMap<TextureId, ColorImage>,
}

impl Raster {
    /// A black picture of `size` \[pixels\].
    pub(super) fn new(size: [u32; 2]) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            size,
            pixels: vec![[0.0; 3]; count],
            textures: HashMap::new(),
        }
    }

    /// Fills it.
    pub(super) fn clear(&mut self, color: Color32) {
        let [r, g, b, _] = color.to_array().map(f32::from);
        self.pixels.fill([r, g, b]);
    }

    /// Takes changed textures: the letters.
    pub(super) fn take_textures(&mut self, delta: &TexturesDelta) {
        for (id, changes) in &delta.set {
            for change in changes {
                let ImageData::Color(image) = &change.image;
                match change.pos {
                    None => {
                        self.textures.insert(*id, image.as_ref().clone());
                    }
                    Some([x, y]) => {
                        if let Some(texture) = self.textures.get_mut(id) {
                            patch(texture, image, [x, y]);
                        }
                    }
                }
            }
        }
    }

    /// Paints triangles given in points.
    pub(super) fn paint(&mut self, clipped: &ClippedPrimitive, scale: f32) {
        let Primitive::Mesh(mesh) = &clipped.primitive else {
            return;
        };
        let texture = self.textures.get(&mesh.texture_id).cloned();
        let clip = clipped.clip_rect * scale;
        for corners in mesh.indices.chunks_exact(3) {
            let vertex = |i: usize| {
                let index = *corners.get(i)? as usize;
                let vertex = mesh.vertices.get(index)?;
                Some(Vertex {
                    pos: (vertex.pos.to_vec2() * scale).to_pos2(),
                    ..*vertex
                })
            };
            if let (Some(a), Some(b), Some(c)) = (vertex(0), vertex(1), vertex(2)) {
                self.triangle([a, b, c], texture.as_ref(), clip);
            }
        }
    }

    fn triangle(&mut self, [a, b, c]: [Vertex; 3], texture: Option<&ColorImage>, clip: Rect) {
        let twice_area = cross(a, b, c);
        if twice_area == 0.0 || !twice_area.is_finite() {
            return;
        }
        let [width, height] = self.size.map(|n| n as f32);
        let low = |values: [f32; 3], from: f32, limit: f32| {
            let least = values.into_iter().fold(f32::INFINITY, f32::min);
            least.max(from).floor().clamp(0.0, limit) as usize
        };
        let high = |values: [f32; 3], to: f32, limit: f32| {
            let most = values.into_iter().fold(f32::NEG_INFINITY, f32::max);
            most.min(to).ceil().clamp(0.0, limit) as usize
        };
        let (xs, ys) = ([a.pos.x, b.pos.x, c.pos.x], [a.pos.y, b.pos.y, c.pos.y]);
        let columns = low(xs, clip.left(), width)..high(xs, clip.right(), width);
        let rows = low(ys, clip.top(), height)..high(ys, clip.bottom(), height);
        let is_flat = a.color == b.color && b.color == c.color;
        let colors = [a.color, b.color, c.color].map(|color| color.to_array().map(f32::from));
        for y in rows {
            for x in columns.clone() {
                let at = eframe::egui::pos2(x as f32 + 0.5, y as f32 + 0.5);
                if !clip.contains(at) {
                    continue;
                }
                let here = Vertex { pos: at, ..a };
                let (u, v) = (
                    cross(here, b, c) / twice_area,
                    cross(a, here, c) / twice_area,
                );
                let w = 1.0 - u - v;
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let mut color = colors[0];
                if !is_flat {
                    for (i, channel) in color.iter_mut().enumerate() {
                        *channel = u * colors[0][i] + v * colors[1][i] + w * colors[2][i];
                    }
                }
                if let Some(texture) = texture {
                    let uv = a.uv.to_vec2() * u + b.uv.to_vec2() * v + c.uv.to_vec2() * w;
                    let texel = texel(texture, [uv.x, uv.y]);
                    for (channel, factor) in color.iter_mut().zip(texel) {
                        *channel *= factor / 255.0;
                    }
                }
                self.blend(x, y, color);
            }
        }
    }

    fn blend(&mut self, x: usize, y: usize, [r, g, b, a]: [f32; 4]) {
        let place = y * self.size[0] as usize + x;
        if let Some(pixel) = self.pixels.get_mut(place) {
            let rest = 1.0 - a / 255.0;
            for (channel, new) in pixel.iter_mut().zip([r, g, b]) {
                *channel = new + *channel * rest;
            }
        }
    }

    /// The picture.
    pub(super) fn picture(&self) -> RgbaImage {
        let [width, height] = self.size;
        RgbaImage::from_fn(width, height, |x, y| {
            let place = y as usize * width as usize + x as usize;
            let [r, g, b] = self.pixels.get(place).copied().unwrap_or_default();
            let byte = |value: f32| value.round().clamp(0.0, 255.0) as u8;
            Rgba([byte(r), byte(g), byte(b), 255])
        })
    }
}

/// Twice the signed area of a triangle.
fn cross(a: Vertex, b: Vertex, c: Vertex) -> f32 {
    let (ab, ac) = (b.pos - a.pos, c.pos - a.pos);
    ab.x * ac.y - ab.y * ac.x
}

/// The colour of a texture between its nearest four pixels.
fn texel(texture: &ColorImage, [u, v]: [f32; 2]) -> [f32; 4] {
    let [width, height] = texture.size;
    let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let (across, down) = (x - left, y - top);
    let at = |dx: f32, dy: f32| {
        let column = (left + dx).clamp(0.0, width as f32 - 1.0) as usize;
        let row = (top + dy).clamp(0.0, height as f32 - 1.0) as usize;
        let color = texture.pixels.get(row * width + column);
        color.map_or([0.0; 4], |color| color.to_array().map(f32::from))
    };
    let mut mixed = [0.0; 4];
    for (dx, dy, weight) in [
        (0.0, 0.0, (1.0 - across) * (1.0 - down)),
        (1.0, 0.0, across * (1.0 - down)),
        (0.0, 1.0, (1.0 - across) * down),
        (1.0, 1.0, across * down),
    ] {
        for (sum, value) in mixed.iter_mut().zip(at(dx, dy)) {
            *sum += weight * value;
        }
    }
    mixed
}

/// Replaces a part of a texture.
fn patch(texture: &mut ColorImage, part: &ColorImage, [x, y]: [usize; 2]) {
    let width = texture.size[0];
    let [columns, rows] = part.size;
    for row in 0..rows {
        let to = (y + row) * width + x;
        let from = row * columns;
        if let (Some(to), Some(from)) = (
            texture.pixels.get_mut(to..to + columns),
            part.pixels.get(from..from + columns),
        ) {
            to.copy_from_slice(from);
        }
    }
}
