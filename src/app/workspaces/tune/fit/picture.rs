//! Correlations as a picture, and how many combinations of parameters the data tell.

use eframe::egui::{Align2, Color32, FontId, Rect, Sense, Ui, pos2, vec2};

use super::choose::symbol;
use super::heading;
use crate::app::workspaces::tune::small;
use crate::fit::FitResult;
use crate::model::unit::format_number;

/// Side of a cell [points], and room for the names.
const CELL: f32 = 30.0;
const NAMES: f32 = 62.0;

/// Draws the matrix of correlations, and Fisher's eigenvalues below.
pub fn correlations(ui: &mut Ui, result: &FitResult) {
    let n = result.parameters.len();
    if n < 2 {
        return;
    }
    heading(ui, "Correlations");
    let side = NAMES + CELL * n as f32;
    let (rect, response) = ui.allocate_exact_size(vec2(side, side - NAMES + 18.0), Sense::hover());
    let painter = ui.painter_at(rect);
    let ink = ui.visuals().text_color();
    let font = FontId::proportional(11.0);
    let at = |i: usize, j: usize| {
        let corner = rect.min + vec2(NAMES + CELL * j as f32, 18.0 + CELL * i as f32);
        Rect::from_min_size(corner, vec2(CELL - 1.0, CELL - 1.0))
    };
    let name = |i: usize| shorten(&symbol(&result.parameters[i].id));
    for i in 0..n {
        let row = at(i, 0);
        painter.text(
            pos2(row.left() - 6.0, row.center().y),
            Align2::RIGHT_CENTER,
            name(i),
            font.clone(),
            ink,
        );
        let column = at(0, i);
        painter.text(
            pos2(column.center().x, column.top() - 3.0),
            Align2::CENTER_BOTTOM,
            name(i),
            font.clone(),
            ink,
        );
        for j in 0..n {
            let value = result.correlations[(i, j)];
            let cell = at(i, j);
            painter.rect_filled(cell, 2.0, color(value, ui.visuals().dark_mode));
            painter.text(
                cell.center(),
                Align2::CENTER_CENTER,
                format!("{value:.1}"),
                FontId::proportional(10.0),
                ink,
            );
        }
    }
    let under = response.hover_pos().and_then(|pointer| {
        let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        places
            .into_iter()
            .find(|&(i, j)| at(i, j).contains(pointer))
    });
    if let Some((i, j)) = under {
        let text = format!(
            "{} and {}: {:.3}",
            result.parameters[i].id,
            result.parameters[j].id,
            result.correlations[(i, j)]
        );
        response.on_hover_text_at_pointer(text);
    }
    eigenvalues(ui, result);
}

/// What the data tell of combinations: standard error of each, best first.
fn eigenvalues(ui: &mut Ui, result: &FitResult) {
    let (Some(best), Some(worst)) = (result.fisher_values.first(), result.fisher_values.last())
    else {
        return;
    };
    let last = result.fisher_values.len() - 1;
    let mut parts: Vec<(f64, String)> = (0..result.parameters.len())
        .map(|i| {
            let share = result.fisher_vectors[(i, last)];
            (share.abs(), symbol(&result.parameters[i].id))
        })
        .collect();
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let names: Vec<String> = parts
        .iter()
        .filter(|(share, _)| *share > 0.3)
        .map(|(_, name)| name.clone())
        .collect();
    let text = format!(
        "Fisher eigenvalues {} to {}: the least certain combination, of {}, is known to {} %.",
        format_number(*best, 2),
        format_number(*worst, 2),
        names.join(", "),
        format_number(100.0 / worst.sqrt(), 2),
    );
    ui.label(small(text).weak());
}

fn shorten(name: &str) -> String {
    name.chars().take(9).collect()
}

/// Blue for negative, orange for positive, deeper where stronger.
fn color(value: f64, dark: bool) -> Color32 {
    let strength = value.abs().clamp(0.0, 1.0) as f32;
    let (full, none) = match (value < 0.0, dark) {
        (true, true) => ([0x1f, 0x6f, 0xb5], 0x22),
        (false, true) => ([0xb8, 0x6a, 0x10], 0x22),
        (true, false) => ([0x7f, 0xb8, 0xea], 0xf4),
        (false, false) => ([0xf5, 0xb4, 0x5f], 0xf4),
    };
    let mix = |full: u8| (none as f32 + (f32::from(full) - none as f32) * strength) as u8;
    Color32::from_rgb(mix(full[0]), mix(full[1]), mix(full[2]))
}
