//! The figures of the modal identification: Bode magnitude, coherence, and the circle of each mode.

use std::f64::consts::TAU;

use eframe::egui::Ui;
use egui_plot::{Line, PlotPoints, Points};

use super::figures::plot;
use crate::app::plots::frame::style;
use crate::app::widgets::text::small;
use crate::fit::modal::frequency_domain::circle::mobility;
use crate::fit::modal::{IdentifiedMode, ModalFit, Quality};
use crate::model::preset::known_value::with_error;
use crate::model::unit::format_quantity;

/// Points of a drawn circle.
const CIRCLE_POINTS: usize = 90;
/// Names of the readings.
const READINGS: [&str; 2] = ["xp", "xc"];

/// Draws the result of the step.
pub(super) fn show(ui: &mut Ui, found: &ModalFit) {
    bode(ui, found);
    coherence(ui, found);
    for (i, mode) in found.modes.iter().enumerate() {
        numbers(ui, i, mode);
        circles(ui, found, i, mode);
    }
    for remark in &found.remarks {
        ui.label(small(remark));
    }
}

fn bode(ui: &mut Ui, found: &ModalFit) {
    let palette = style::palette(ui);
    let colors = [palette.proof_mass, palette.cantilever];
    plot("step modal bode", "log10 of f [Hz]", "log10 of |H| [m]").show(ui, |plot| {
        for ((c, name), color) in READINGS.into_iter().enumerate().zip(colors) {
            let measured: Vec<[f64; 2]> = found.responses[c]
                .iter()
                .map(|p| [p.frequency.log10(), p.h1[0].hypot(p.h1[1]).log10()])
                .collect();
            let fitted: Vec<[f64; 2]> = found.responses[c]
                .iter()
                .filter_map(|p| {
                    let [re, im] = found.response(c, p.frequency)?;
                    Some([p.frequency.log10(), re.hypot(im).log10()])
                })
                .collect();
            plot.points(
                Points::new(format!("{name}, measured"), measured)
                    .radius(1.5)
                    .color(color),
            );
            let fitted = Line::new(format!("{name}, fitted"), PlotPoints::from(fitted));
            plot.line(fitted.color(color).width(1.5));
        }
    });
}

fn coherence(ui: &mut Ui, found: &ModalFit) {
    plot("step modal coherence", "log10 of f [Hz]", "coherence").show(ui, |plot| {
        for (c, name) in READINGS.into_iter().enumerate() {
            let points: Vec<[f64; 2]> = found.responses[c]
                .iter()
                .map(|p| [p.frequency.log10(), p.coherence])
                .collect();
            plot.line(Line::new(name, PlotPoints::from(points)));
        }
    });
}

fn numbers(ui: &mut Ui, i: usize, mode: &IdentifiedMode) {
    let quality = match mode.quality {
        Quality::Identified => "",
        Quality::Weak => ", seen but not determined",
        Quality::OutsideBand => ", outside the swept band",
    };
    ui.label(format!(
        "mode {}: {}, \u{3b6} = {:.5} \u{b1} {:.1e}{quality}",
        i + 1,
        with_error(mode.frequency.value, mode.frequency.std_error, "Hz"),
        mode.zeta.value,
        mode.zeta.std_error
    ));
}

fn circles(ui: &mut Ui, found: &ModalFit, i: usize, mode: &IdentifiedMode) {
    if mode.circles.iter().all(Option::is_none) {
        return;
    }
    let name = format!("step modal circle {i}");
    let axes = ["Re of mobility [m/s]", "Im of mobility [m/s]"];
    plot(&name, axes[0], axes[1])
        .data_aspect(1.0)
        .show(ui, |plot| {
            for (c, reading) in READINGS.into_iter().enumerate() {
                let Some(circle) = mode.circles[c] else {
                    continue;
                };
                let near = found.responses[c].iter();
                let near =
                    near.filter(|p| p.frequency >= circle.band.0 && p.frequency <= circle.band.1);
                let points: Vec<[f64; 2]> = near.map(mobility).map(|(x, y)| [x, y]).collect();
                plot.points(Points::new(format!("{reading}, measured"), points).radius(2.0));
                let round: PlotPoints<'_> = (0..=CIRCLE_POINTS)
                    .map(|k| TAU * k as f64 / CIRCLE_POINTS as f64)
                    .map(|a| {
                        [
                            circle.center.0 + circle.radius * a.cos(),
                            circle.center.1 + circle.radius * a.sin(),
                        ]
                    })
                    .collect();
                plot.line(Line::new(format!("{reading}, circle"), round).width(1.0));
            }
        });
    for (circle, reading) in mode.circles.iter().zip(READINGS) {
        if let Some(circle) = circle {
            ui.label(small(format!(
                "circle fit of {reading}: {}, \u{3b6} = {:.5}, scatter {:.1} % of the radius, {} to {}",
                with_error(circle.frequency.0, circle.frequency.1, "Hz"),
                circle.zeta.0,
                100.0 * circle.scatter,
                format_quantity(circle.band.0, "Hz", 4),
                format_quantity(circle.band.1, "Hz", 4)
            )));
        }
    }
}
