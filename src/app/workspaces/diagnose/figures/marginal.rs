//! How large the residual is against a quantity, before and after.

use eframe::egui::Ui;

use super::frame;
use super::frame::{Axis, Figure, Item};
use super::words::{against, spelled};
use crate::app::analysis::diagnosis_view::Look;
use crate::app::workspaces::diagnose::colors;
use crate::diagnose::Diagnosis;

/// Draws it.
pub fn show(ui: &mut Ui, look: &mut Look, d: &Diagnosis) {
    if d.marginals.is_empty() {
        ui.weak("Too little was compared to say what the residual goes with.");
        return;
    }
    let place = against(
        ui,
        &mut look.marginal,
        d.marginals.iter().map(|m| m.against),
    );
    let m = &d.marginals[place];
    let named = !d.named.is_empty();
    let mut entries = vec![("re-tuned model", colors::before(ui))];
    if named {
        entries.push(("with what was left out", colors::after(ui)));
    }
    frame::legend(ui, &entries);
    // All on one scale, so that they can be compared by switching.
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
        x: Axis::holding(spelled(m.against), m.unit, m.at.iter().copied()),
        y,
        log: true,
        height: (ui.available_height() - 2.0).max(120.0),
        has_x: true,
        items,
    }
    .show(ui);
}
