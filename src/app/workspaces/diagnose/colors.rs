//! Colours of the workspace: regimes, before and after, verdicts.

use eframe::egui::{Color32, Ui};

use crate::app::plots::frame::style;
use crate::diagnose::Verdict;
use crate::diagnose::diagnosis::Regime;

const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

/// Colour of a motion regime.
pub fn regime(ui: &Ui, regime: Regime) -> Color32 {
    let (dark, light) = match regime {
        Regime::FarFlight => (0x56b4e9, 0x3a8fc7),
        Regime::NearGroundApproach => (0xe69f00, 0xd08c00),
        Regime::Impact => (0xe8602a, 0xc44a00),
        Regime::Contact => (0xb0aca4, 0x8a857c),
        Regime::Release => (0x2fc59b, 0x009570),
        Regime::NearGroundDeparture => (0xcc79a7, 0xb0528a),
    };
    rgb(if ui.visuals().dark_mode { dark } else { light })
}

/// The re-tuned model, before anything is added.
pub fn before(ui: &Ui) -> Color32 {
    style::overlay_color(ui, 0)
}

/// The model with the effects that were found.
pub fn after(ui: &Ui) -> Color32 {
    style::palette(ui).proof_mass
}

/// Measured points.
pub fn measured(ui: &Ui) -> Color32 {
    style::overlay_color(ui, 0)
}

/// The curve of a law.
pub fn law(ui: &Ui) -> Color32 {
    style::palette(ui).proof_mass
}

/// The noise level.
pub fn noise(ui: &Ui) -> Color32 {
    style::palette(ui).ground
}

/// The mark of a verdict.
pub fn verdict(ui: &Ui, verdict: Verdict) -> Color32 {
    let palette = style::palette(ui);
    match verdict {
        Verdict::Adequate => palette.release,
        Verdict::MissingPhysics => palette.impact,
        Verdict::PartlyExplained => palette.cursor[1],
        Verdict::Unexplained => palette.stick,
    }
}
