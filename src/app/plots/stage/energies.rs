//! Bars of energies at a moment: what is stored, and what was lost so far, on one scale for the run.

use eframe::egui::{Align2, Color32, FontId, Rect, Role, Sense, Ui, Vec2, WidgetInfo, pos2, vec2};

use super::Stage;
use crate::app::plots::frame::style;
use crate::learn::energy::Energies;
use crate::model::unit::format_quantity;

/// Height of a bar with its text, at most \[points\].
const MAX_ROW_HEIGHT: f32 = 44.0;
/// Energies below this share of the scale are not listed if they stay so.
const SHOWN_SHARE: f64 = 1e-4;
/// Size of the text over a bar \[points\].
const TEXT_SIZE: f32 = 12.5;

/// Names of the bars with their values.
fn parts(energies: &Energies) -> [(&'static str, f64); 7] {
    [
        ("kinetic", energies.kinetic),
        ("elastic", energies.elastic),
        ("lost in the film", energies.film),
        ("lost in bounces", energies.bounces),
        ("lost in sticking (adhesion)", energies.sticking),
        ("lost in damping", energies.damping),
        ("lost in friction, soft ground", energies.other),
    ]
}

fn colors(ui: &Ui) -> [Color32; 7] {
    let palette = style::palette(ui);
    [
        palette.proof_mass,
        palette.cantilever,
        palette.forces[1],
        palette.impact,
        palette.stick,
        palette.ground,
        palette.release,
    ]
}

/// The energies in words, for screen readers.
fn energy_words(energies: &Energies) -> String {
    let named = parts(energies)
        .into_iter()
        .filter(|(_, value)| *value > 0.0);
    let words = named.map(|(name, value)| format!("{name} {}", format_quantity(value, "J", 2)));
    format!("Energies: {}", words.collect::<Vec<_>>().join(", "))
}

/// Draws the bars.
pub(super) fn show(ui: &mut Ui, stage: &Stage<'_>, size: Vec2) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let trace = &stage.result.run.energies;
    let Some(now) = trace.at(stage.time) else {
        return;
    };
    let words = energy_words(&now);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &words));
    response.on_hover_text(
        "What is stored, and what was lost since the beginning, on one scale for the whole run",
    );
    let scale = trace.largest();
    if !ui.is_rect_visible(rect) || scale <= 0.0 {
        return;
    }
    let last = parts(&trace.last());
    let shown: Vec<usize> = (0..last.len())
        .filter(|i| *i < 2 || last.get(*i).is_some_and(|(_, v)| *v > SHOWN_SHARE * scale))
        .collect();
    let row = (rect.height() / shown.len().max(1) as f32).min(MAX_ROW_HEIGHT);
    let colors = colors(ui);
    let painter = ui.painter_at(rect);
    let text_color = ui.visuals().text_color();
    for (place, i) in shown.into_iter().enumerate() {
        let (Some((name, value)), Some(color)) = (parts(&now).get(i).copied(), colors.get(i))
        else {
            continue;
        };
        let top = rect.top() + place as f32 * row;
        let text = format!("{name} {}", format_quantity(value, "J", 2));
        let font = FontId::proportional(TEXT_SIZE);
        let at = pos2(rect.left() + 4.0, top + 1.0);
        painter.text(at, Align2::LEFT_TOP, text, font, text_color);
        let height = (row - TEXT_SIZE - 9.0).clamp(3.0, 16.0);
        let whole = rect.width() - 10.0;
        let corner = pos2(rect.left() + 4.0, top + TEXT_SIZE + 5.0);
        let frame = Rect::from_min_size(corner, vec2(whole, height));
        painter.rect_filled(frame, 2.0, ui.visuals().extreme_bg_color);
        let share = (value / scale).clamp(0.0, 1.0) as f32;
        let bar = Rect::from_min_size(corner, vec2(share * whole, height));
        painter.rect_filled(bar, 2.0, *color);
    }
}
