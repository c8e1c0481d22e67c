//! The force that the measured motion in flight calls for by the balance of forces, against a quantity.

use eframe::egui::Ui;

use super::frame;
use super::frame::{Axis, Figure, Item};
use super::words::{axis_name, quantity_picker};
use crate::app::analysis::diagnosis_view::Look;
use crate::app::widgets::text::small;
use crate::app::workspaces::diagnose::colors;
use crate::diagnose::Diagnosis;
use crate::diagnose::diagnosis::{BalanceForces, ForceCurve};
use crate::diagnose::report::force_balance::{absorbed_sentence, curve_sentence};
use crate::diagnose::report::ground::Seen;
use crate::diagnose::report::words::listed;

/// Two buttons: which measurement of the missing force is drawn.
pub fn switch(ui: &mut Ui, look: &mut Look) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        ui.label(small("measured by"));
        for (by_balance, name, help) in [
            (
                false,
                "simulation",
                "The force that, added to the simulation, removes most of the residual",
            ),
            (
                true,
                "force balance",
                "The force that the measured motion in flight calls for: nothing is simulated",
            ),
        ] {
            ui.selectable_value(&mut look.by_balance, by_balance, small(name))
                .on_hover_text(help);
        }
    });
}

/// Draws the curve of the chosen quantity with its band, the law of the named effects and what they
/// leave.
pub fn show(ui: &mut Ui, look: &mut Look, (d, found): (&Diagnosis, &BalanceForces)) {
    let all = found.before.iter().map(|c| c.curve.against);
    let c = &found.before[quantity_picker(ui, &mut look.force, all)];
    let left = found.after_over(c.quantity);
    let names: Vec<&str> = d.named.iter().map(|n| n.name.as_str()).collect();
    let law = format!("{}, fitted", listed(&names));
    let has_law = !c.curve.law.is_empty() && !names.is_empty();
    let (measured, color_left) = (colors::measured(ui), colors::verdict(ui, d.verdict));
    let mut entries = vec![("measured, with standard error", measured)];
    if has_law {
        entries.push((law.as_str(), colors::law(ui)));
    }
    if left.is_some() {
        entries.push(("still missing", color_left));
    }
    frame::legend(ui, &entries);
    let line = format!("{} {}", curve_sentence(c), absorbed_sentence(c));
    ui.label(small(line).weak());
    let points = seen(&c.curve);
    let left = left.map_or_else(Vec::new, |left| seen(&left.curve));
    let mut items = vec![
        Item::Level {
            value: 0.0,
            text: "",
            color: colors::noise(ui),
        },
        Item::Band {
            points: points.clone(),
            color: measured.gamma_multiply(0.25),
        },
    ];
    if has_law {
        let law = c.curve.at.iter().zip(&c.curve.law);
        items.push(Item::Line {
            points: law.map(|(x, y)| [*x, *y]).collect(),
            color: colors::law(ui),
            width: 2.2,
            dashed: false,
        });
    }
    let ends = points
        .iter()
        .chain(&left)
        .filter(|p| p.error.is_finite())
        .flat_map(|p| [p.y - p.error, p.y + p.error])
        .chain(c.curve.law.iter().copied());
    let y = Axis::holding("missing force in flight", "N", ends.chain([0.0]));
    items.push(Item::Dots {
        points,
        color: measured,
    });
    if !left.is_empty() {
        items.push(Item::Dots {
            points: left,
            color: color_left,
        });
    }
    let at = c.curve.at.iter().copied();
    Figure {
        name: "missing force by the balance",
        x: Axis::holding(axis_name(c.curve.against), c.curve.unit, at),
        y,
        log: false,
        height: (ui.available_height() - 2.0).max(120.0),
        has_x: true,
        items,
    }
    .show(ui);
}

/// The points of a curve with their errors.
pub fn seen(curve: &ForceCurve) -> Vec<Seen> {
    (0..curve.at.len().min(curve.force.len()))
        .map(|i| Seen {
            x: curve.at[i],
            y: curve.force[i],
            error: curve.std_error.get(i).copied().unwrap_or(f64::NAN),
        })
        .collect()
}
