//! Colours and sizes of all pictures, for the dark and the light theme. The colours follow
//! Okabe and Ito's palette, which colour-blind people can distinguish, darkened where it
//! would be faint on white. Simulated curves are blue, recordings are not.

use eframe::egui::{Color32, Ui};

use crate::app::setup::kept_curve::MAX_KEPT_CURVES;

/// Width of the main curve \[points\].
pub const THICK_LINE: f32 = 2.2;
/// Width of all other curves \[points\].
pub const THIN_LINE: f32 = 1.2;
/// Width of kept curves \[points\].
pub const KEPT_LINE: f32 = 1.5;
/// Width for ticks and label of a vertical axis \[points\]. It is the same for all pictures,
/// so that equal times are aligned.
pub const AXIS_WIDTH: f32 = 62.0;
/// Size of the text on axes \[points\].
pub const AXIS_TEXT: f32 = 12.0;

/// Colours of one theme.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Palette {
    /// Proof mass, simulated.
    pub proof_mass: Color32,
    /// Cantilever, simulated.
    pub cantilever: Color32,
    /// Drive voltage.
    pub voltage: Color32,
    /// The ground and its text.
    pub ground: Color32,
    /// Time in contact, drawn under the curves.
    pub contact: Color32,
    /// Impacts.
    pub impact: Color32,
    /// Impacts after which the mass sticks.
    pub stick: Color32,
    /// Releases.
    pub release: Color32,
    /// Line where the pointer is.
    pub hover: Color32,
    /// First and second cursor.
    pub cursor: [Color32; 2],
    /// Drive, film, effects, ground, pull-off, adhesion.
    pub forces: [Color32; 6],
    /// Lines of the grid.
    pub grid: Color32,
    /// Text on axes.
    pub text: Color32,
}

const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

const DARK: Palette = Palette {
    proof_mass: rgb(0x56b4e9),
    cantilever: rgb(0x8ea9d8),
    voltage: rgb(0x7fb2ff),
    ground: rgb(0xb0aca4),
    contact: Color32::from_rgba_premultiplied(28, 25, 16, 44),
    impact: rgb(0xff8a5c),
    stick: rgb(0xf0e442),
    release: rgb(0x6fd6b4),
    hover: rgb(0x8a8a8a),
    cursor: [rgb(0xffffff), rgb(0xffc95e)],
    forces: [
        rgb(0xf0e442),
        rgb(0x56b4e9),
        rgb(0xcc79a7),
        rgb(0xb0aca4),
        rgb(0xff8a5c),
        rgb(0x2fc59b),
    ],
    grid: rgb(0x707070),
    text: rgb(0xc4c4c4),
};

const LIGHT: Palette = Palette {
    proof_mass: rgb(0x0072b2),
    cantilever: rgb(0x6078b0),
    voltage: rgb(0x2a5bc0),
    ground: rgb(0x6a655c),
    contact: Color32::from_rgba_premultiplied(44, 37, 18, 48),
    impact: rgb(0xb84500),
    stick: rgb(0x826600),
    release: rgb(0x00785a),
    hover: rgb(0x808080),
    cursor: [rgb(0x101010), rgb(0x9c5500)],
    forces: [
        rgb(0x8a6d00),
        rgb(0x0072b2),
        rgb(0xb0528a),
        rgb(0x6a655c),
        rgb(0xc44a00),
        rgb(0x00785a),
    ],
    grid: rgb(0xa8a8a8),
    text: rgb(0x404040),
};

/// The colours of the theme in use.
pub fn palette(ui: &Ui) -> &'static Palette {
    palette_of(ui.visuals().dark_mode)
}

/// The colours of the dark or the light theme.
pub fn palette_of(dark: bool) -> &'static Palette {
    if dark { &DARK } else { &LIGHT }
}

/// Colours of recordings in the dark or the light theme. Colour-blind people can distinguish the
/// first six. They are also those of the recordings' names.
pub fn overlay_colors(dark: bool) -> [Color32; 12] {
    const DARK: [Color32; 12] = [
        rgb(0xe69f00),
        rgb(0x00b386),
        rgb(0xcc79a7),
        rgb(0xe8602a),
        rgb(0xb5d85a),
        rgb(0xd8c890),
        rgb(0xb18cff),
        rgb(0xff6f91),
        rgb(0xb08c5a),
        rgb(0xe8e8e8),
        rgb(0x66a442),
        rgb(0xe667e4),
    ];
    const LIGHT: [Color32; 12] = [
        rgb(0x946200),
        rgb(0x00785a),
        rgb(0xa3487d),
        rgb(0xb84500),
        rgb(0x597400),
        rgb(0x74603c),
        rgb(0x6a3fd0),
        rgb(0xcc184c),
        rgb(0x54391a),
        rgb(0x303030),
        rgb(0x2f6b12),
        rgb(0xa800a6),
    ];
    if dark { DARK } else { LIGHT }
}

/// Colour of what is simulated or computed for a recording: the recording's own, stronger, so that
/// they are seen to belong together.
pub fn strong_overlay_color(ui: &Ui, index: usize) -> Color32 {
    let color = overlay_color(ui, index);
    if ui.visuals().dark_mode {
        color.lerp_to_gamma(Color32::WHITE, 0.35)
    } else {
        color.lerp_to_gamma(Color32::BLACK, 0.35)
    }
}

/// Colour of a recording by its index in the palette.
pub fn overlay_color(ui: &Ui, index: usize) -> Color32 {
    let colors = overlay_colors(ui.visuals().dark_mode);
    colors[index % colors.len()]
}

/// Colours of kept curves in the dark or the light theme, far from each other and from the
/// simulation in CIELAB. They are also those of the curves' names.
pub fn kept_colors(dark: bool) -> [Color32; MAX_KEPT_CURVES] {
    const DARK: [Color32; MAX_KEPT_CURVES] = [
        rgb(0xa99cd0),
        rgb(0x30f888),
        rgb(0xf8e030),
        rgb(0xf848a8),
        rgb(0x00a0a0),
        rgb(0xf89078),
        rgb(0xa0f0d0),
        rgb(0x989838),
        rgb(0xf098f8),
        rgb(0x4890f8),
        rgb(0xf08008),
        rgb(0x60b000),
    ];
    const LIGHT: [Color32; MAX_KEPT_CURVES] = [
        rgb(0x6b58a0),
        rgb(0xb8007a),
        rgb(0x007078),
        rgb(0x8c4f28),
        rgb(0x103810),
        rgb(0x680018),
        rgb(0x0054d6),
        rgb(0x625a08),
        rgb(0xc8081e),
        rgb(0x400080),
        rgb(0x85505f),
        rgb(0x580048),
    ];
    if dark { DARK } else { LIGHT }
}

/// Colour of a kept curve by its index in the palette.
pub fn kept_color(ui: &Ui, index: usize) -> Color32 {
    let colors = kept_colors(ui.visuals().dark_mode);
    colors[index % colors.len()]
}

#[cfg(test)]
mod tests {
    use super::super::style::*;

    /// Least distance of two colours that are easily distinguished in CIELAB (CIE 1976).
    const LEAST_COLOR_DISTANCE: f64 = 25.0;

    /// CIELAB of an sRGB colour under D65.
    fn lab(color: Color32) -> [f64; 3] {
        let linear = |byte: u8| {
            let value = f64::from(byte) / 255.0;
            if value <= 0.04045 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        };
        let [r, g, b] = [color.r(), color.g(), color.b()].map(linear);
        let root = |t: f64| {
            if t > 216.0 / 24389.0 {
                t.cbrt()
            } else {
                (24389.0 / 27.0 * t + 16.0) / 116.0
            }
        };
        let x = root((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047);
        let y = root(0.2126 * r + 0.7152 * g + 0.0722 * b);
        let z = root((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn distance(a: Color32, b: Color32) -> f64 {
        let pairs = lab(a).into_iter().zip(lab(b));
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    #[test]
    fn kept_curves_differ_from_each_other_and_from_the_simulation() {
        assert!((distance(Color32::BLACK, Color32::WHITE) - 100.0).abs() < 0.1);
        for dark in [true, false] {
            let mut colors = vec![palette_of(dark).proof_mass];
            colors.extend(kept_colors(dark));
            for (i, &a) in colors.iter().enumerate() {
                for &b in &colors[..i] {
                    let found = distance(a, b);
                    assert!(
                        found >= LEAST_COLOR_DISTANCE,
                        "dark {dark}: {a:?} and {b:?} are {found:.1} apart"
                    );
                }
            }
        }
    }
}
