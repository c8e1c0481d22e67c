//! The measured force on the mass that the re-tuned model lacks, against a quantity.

use eframe::egui::Ui;

use super::force_balance;
use super::force_balance::seen;
use super::frame;
use super::frame::{Axis, Figure, Item};
use super::words::{axis_name, quantity_picker};
use crate::app::analysis::diagnosis_view::Look;
use crate::app::widgets::text::small;
use crate::app::workspaces::diagnose::colors;
use crate::diagnose::Diagnosis;
use crate::diagnose::report::ground::law_through;
use crate::diagnose::report::words::listed;

/// Draws it.
pub fn show(ui: &mut Ui, look: &mut Look, d: &Diagnosis) {
    let balance = d.balance.as_ref().filter(|b| !b.before.is_empty());
    if let Some(found) = balance {
        force_balance::switch(ui, look);
        if look.by_balance {
            force_balance::show(ui, look, (d, found));
            return;
        }
    }
    if d.forces.is_empty() {
        ui.weak("The recordings are too short or too few to measure the missing force.");
        return;
    }
    let index = quantity_picker(ui, &mut look.force, d.forces.iter().map(|f| f.against));
    let curve = &d.forces[index];
    let names: Vec<&str> = d.named.iter().map(|n| n.name.as_str()).collect();
    let law = format!("{}, fitted", listed(&names));
    let through = law_through(curve);
    let has_law = !through.is_empty() && !names.is_empty();
    let left = d.remaining.as_ref().and_then(|left| left.force.as_ref());
    let left = left.filter(|left| left.against == curve.against && !names.is_empty());
    let mut entries = vec![("measured, with standard error", colors::measured(ui))];
    let color_left = colors::verdict(ui, d.verdict);
    if has_law {
        entries.push((law.as_str(), colors::law(ui)));
    }
    if left.is_some() {
        entries.push(("still missing", color_left));
    }
    frame::legend(ui, &entries);
    if has_law {
        let line = "The law is determined up to a constant and a slope, which re-tuning absorbs.";
        ui.label(small(line).weak());
    } else if d.forces.iter().any(|f| !f.law.is_empty()) {
        let line = "Each point assumes a constant force over that time; no law is drawn.";
        ui.label(small(line).weak());
    } else {
        ui.label(small("No named effect acts as a force, so no law is drawn.").weak());
    }
    let points = seen(curve);
    let left = left.map_or_else(Vec::new, seen);
    let ends = points.iter().chain(&left).flat_map(|p| {
        let error = if p.error.is_finite() { p.error } else { 0.0 };
        [p.y - error, p.y + error]
    });
    let y = Axis::holding(
        "missing force",
        "N",
        ends.chain(through.iter().copied()).chain([0.0]),
    );
    let color = colors::measured(ui);
    let mut items = vec![
        Item::Level {
            value: 0.0,
            text: "",
            color: colors::noise(ui),
        },
        Item::Band {
            points: points.clone(),
            color: color.gamma_multiply(0.25),
        },
    ];
    if has_law {
        let law = curve.at.iter().zip(&through);
        items.push(Item::Line {
            points: law.map(|(x, y)| [*x, *y]).collect(),
            color: colors::law(ui),
            width: 2.2,
            dashed: false,
        });
    }
    items.push(Item::Dots { points, color });
    if !left.is_empty() {
        items.push(Item::Dots {
            points: left,
            color: color_left,
        });
    }
    Figure {
        name: "missing force",
        x: Axis::holding(
            axis_name(curve.against),
            curve.unit,
            curve.at.iter().copied(),
        ),
        y,
        log: false,
        height: (ui.available_height() - 2.0).max(120.0),
        has_x: true,
        items,
    }
    .show(ui);
}
