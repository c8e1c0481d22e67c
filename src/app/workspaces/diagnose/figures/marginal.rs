//! The size of the residual against a quantity, before and after.

use eframe::egui::Ui;

use super::frame;
use super::frame::{Axis, Figure, Item};
use super::words::{axis_name, quantity_picker};
use crate::app::analysis::diagnosis_view::Look;
use crate::app::workspaces::diagnose::colors;
use crate::diagnose::Diagnosis;

/// Draws it.
pub fn show(ui: &mut Ui, look: &mut Look, d: &Diagnosis) {
    if d.marginals.is_empty() {
        ui.weak("Too few samples were compared to plot the residual against other quantities.");
        return;
    }
    let index = quantity_picker(
        ui,
        &mut look.marginal,
        d.marginals.iter().map(|m| m.against),
    );
    let m = &d.marginals[index];
    let named = !d.named.is_empty();
    frame::legend(ui, &frame::model_entries(ui, d));
    // One scale for all quantities, so that switching between them compares them.
    let all = d
        .marginals
        .iter()
        .flat_map(|m| m.before.iter().chain(&m.after));
    let y = Axis::holding_log(
        "mean square / noise\u{b2}",
        "",
        all.copied().chain([0.7, 2.0]),
    );
    let line = |values: &[f64], color| Item::Line {
        points: m.at.iter().zip(values).map(|(x, y)| [*x, *y]).collect(),
        color,
        width: 1.8,
        dashed: false,
    };
    let mut items = vec![
        Item::Level {
            value: 1.0,
            text: "noise",
            color: colors::noise(ui),
        },
        line(&m.before, colors::before(ui)),
    ];
    if named {
        items.push(line(&m.after, colors::after(ui)));
    }
    Figure {
        name: "residual against",
        x: Axis::holding(axis_name(m.against), m.unit, m.at.iter().copied()),
        y,
        log: true,
        height: (ui.available_height() - 2.0).max(120.0),
        has_x: true,
        items,
    }
    .show(ui);
}
