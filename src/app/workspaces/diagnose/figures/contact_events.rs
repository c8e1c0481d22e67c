//! The contact events one by one, with the laws that they should follow.

use eframe::egui::Ui;

use super::frame;
use super::frame::{Axis, Figure, Item};
use crate::app::analysis::diagnosis_view::{EventPlot, Look};
use crate::app::widgets::text::small;
use crate::app::workspaces::diagnose::colors;
use crate::app::workspaces::diagnose::words::after_text;
use crate::diagnose::Diagnosis;
use crate::diagnose::report::ground::{GroundLaws, Seen, grid, without_large_errors};

/// A contact law: value at an abscissa, both in SI units.
type Law = fn(&GroundLaws, f64) -> f64;

/// One kind of event as it is plotted: axes with their SI units, law and points.
struct Kind {
    x: (&'static str, &'static str),
    y: (&'static str, &'static str),
    law: Option<Law>,
    /// What to expect if nothing is missing.
    expected: &'static str,
    points: Vec<Seen>,
}

/// Draws the chosen kind of event.
pub fn show(ui: &mut Ui, look: &mut Look, d: &Diagnosis) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = eframe::egui::vec2(3.0, 2.0);
        for plot in EventPlot::ALL {
            let count = kind(d, plot).points.len();
            let text = small(format!("{} ({count})", plot.text()));
            ui.selectable_value(&mut look.events, plot, text)
                .on_hover_text(format!("{} against {}", plot.text(), kind(d, plot).x.0));
        }
    });
    let kind = kind(d, look.events);
    let (points, hidden) = without_large_errors(kind.points.iter().copied());
    if points.is_empty() {
        ui.weak("There are no such events in these recordings.");
        return;
    }
    let named = !d.named.is_empty();
    let mut entries = vec![("measured", colors::measured(ui))];
    if kind.law.is_some() {
        entries.push(("law of the re-tuned model", colors::noise(ui)));
        if named {
            entries.push((after_text(d), colors::law(ui)));
        }
    }
    frame::legend(ui, &entries);
    let mut note = kind.expected.to_owned();
    if hidden > 0 {
        note += &format!(" Not drawn: {hidden} with a large error.");
    }
    ui.label(small(note).weak());
    draw(ui, d, &kind, points);
}

fn draw(ui: &mut Ui, d: &Diagnosis, kind: &Kind, points: Vec<Seen>) {
    let at = grid(points.iter().map(|p| p.x));
    let curve = |laws: &GroundLaws, law: Law| -> Vec<[f64; 2]> {
        at.iter().map(|x| [*x, law(laws, *x)]).collect()
    };
    let mut items = Vec::new();
    let mut heights: Vec<f64> = Vec::new();
    if let Some(law) = kind.law {
        let was = curve(&GroundLaws::of(&d.baseline), law);
        heights.extend(was.iter().map(|p| p[1]));
        items.push(Item::Line {
            points: was,
            color: colors::noise(ui),
            width: 1.4,
            dashed: true,
        });
        if !d.named.is_empty() {
            let now = curve(&GroundLaws::of(&d.model), law);
            heights.extend(now.iter().map(|p| p[1]));
            items.push(Item::Line {
                points: now,
                color: colors::law(ui),
                width: 2.2,
                dashed: false,
            });
        }
    } else {
        heights.push(0.0);
        items.push(Item::Level {
            value: 0.0,
            text: "",
            color: colors::noise(ui),
        });
    }
    heights.extend(points.iter().flat_map(|p| {
        let error = if p.error.is_finite() { p.error } else { 0.0 };
        [p.y - error, p.y + error]
    }));
    let x = Axis::holding(kind.x.0, kind.x.1, points.iter().map(|p| p.x));
    items.push(Item::Dots {
        points,
        color: colors::measured(ui),
    });
    Figure {
        name: "events at the ground",
        x,
        y: Axis::holding(kind.y.0, kind.y.1, heights.into_iter()),
        log: false,
        height: (ui.available_height() - 2.0).max(120.0),
        has_x: true,
        items,
    }
    .show(ui);
}

fn kind(d: &Diagnosis, plot: EventPlot) -> Kind {
    let point = |x, y, error| Seen { x, y, error };
    let (bounces, releases, levels) = (&d.events.bounces, &d.events.releases, &d.events.levels);
    match plot {
        EventPlot::Restitution => Kind {
            x: ("speed of approach", "m/s"),
            y: ("restitution", ""),
            law: Some(GroundLaws::restitution),
            expected: "Rebound speed over impact speed; constant in the base model.",
            points: bounces
                .iter()
                .map(|b| point(b.speed, b.ratio, b.ratio_error))
                .collect(),
        },
        EventPlot::Dwell => Kind {
            x: ("speed of approach", "m/s"),
            y: ("time below ground", "s"),
            law: None,
            expected: "Time below ground level in each bounce; 0 for a rigid ground.",
            points: bounces
                .iter()
                .map(|b| point(b.speed, b.dwell, b.dwell_error))
                .collect(),
        },
        EventPlot::Adhesion => Kind {
            x: ("time on the ground", "s"),
            y: ("pull-off force", "N"),
            law: Some(GroundLaws::adhesion),
            expected: "Pull-off force of each release; a straight line in the base model.",
            points: releases
                .iter()
                .map(|r| point(r.contact, r.force, r.force_error))
                .collect(),
        },
        EventPlot::Level => Kind {
            x: ("time", "s"),
            y: ("height above ground", "m"),
            law: None,
            expected: "Measured minus modelled ground level in each contact; 0 if the ground does not move.",
            points: levels
                .iter()
                .map(|l| point(l.time, l.miss, l.error))
                .collect(),
        },
    }
}
