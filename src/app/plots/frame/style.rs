//! Colours and sizes of all pictures, for the dark and the light theme. The colours follow
//! Okabe and Ito's palette, which colour-blind people can distinguish, darkened where it
//! would be faint on white. Simulated curves are blue, recordings are not.

use eframe::egui::{Color32, Ui};

/// Width of the main curve \[points\].
pub const THICK_LINE: f32 = 2.2;
/// Width of all other curves \[points\].
pub const THIN_LINE: f32 = 1.2;
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
    /// The reference curve (A).
    pub reference: Color32,
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
    reference: rgb(0x9a8fb8),
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
    reference: rgb(0x8a7ab0),
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
