//! The guided identification: the paper's five steps, which of them the recordings allow,
//! and each one's figure.

use eframe::egui::{Button, Grid, RichText, ScrollArea, Ui, Window};
use egui_plot::{Corner, Legend, Line, Plot, PlotPoints, Points};

use super::heading;
use crate::app::identification::Finding;
use crate::app::plots::style;
use crate::app::state::State;
use crate::app::workspaces::tune::{error_color, small};
use crate::fit::steps::adhesion::Adhesion;
use crate::fit::steps::drive::DriveFit;
use crate::fit::steps::film::Film;
use crate::fit::steps::guide::Step;
use crate::fit::steps::restitution::Restitution;
use crate::fit::steps::sensitivity::{ROWS, Sensitivity};
use crate::model::piezo::Branch;
use crate::model::unit::format_quantity;

/// Points of a fitted curve.
const CURVE: usize = 120;
/// Most recordings that are named in the list.
const FEW: usize = 3;

/// Draws the window while it is open.
pub fn show(ui: &mut Ui, state: &mut State) {
    if !state.identification.open {
        return;
    }
    let context = ui.ctx().clone();
    state
        .identification
        .poll(&state.setup, &state.fitting, &context);
    let mut open = true;
    Window::new("Identification, step by step")
        .open(&mut open)
        .default_size([560.0, 640.0])
        .default_pos([365.0, 60.0])
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("identification")
                .auto_shrink([false, true])
                .show(ui, |ui| {
                    list(ui, state);
                    ui.separator();
                    finding(ui, state);
                });
        });
    state.identification.open = open && state.identification.open;
}

fn list(ui: &mut Ui, state: &mut State) {
    ui.label(
        small(
            "The steps of the paper's section 4, with the recordings that the fit panel fits to.",
        )
        .weak(),
    );
    let mut start = None;
    let busy = state.identification.job.is_some();
    for step in Step::ALL {
        let allowance = state
            .identification
            .allowances
            .iter()
            .find(|allowance| allowance.step == step);
        let allowed = allowance.is_some_and(|a| a.by.is_ok());
        ui.horizontal(|ui| {
            let button = ui.add_enabled(allowed && !busy, Button::new("Take"));
            if button
                .on_hover_text(format!("Take the step: {}", step.title()))
                .clicked()
            {
                start = Some(step);
            }
            let chosen = state.identification.chosen == Some(step);
            let title = Button::selectable(chosen, RichText::new(step.title()).strong());
            if ui.add(title).on_hover_text("Show its figure").clicked() {
                state.identification.chosen = Some(step);
            }
            match state.identification.findings.get(step.id()) {
                Some(Ok(_)) => ui.label(small("done")),
                Some(Err(_)) => ui.label(small("failed").color(error_color(ui))),
                None => ui.label(""),
            };
        });
        match allowance.map(|a| &a.by) {
            Some(Err(reason)) => {
                let text = format!("      not yet: {reason}. Record {}.", step.recipe());
                ui.label(small(text).color(ui.visuals().warn_fg_color));
            }
            Some(Ok(names)) if names.len() > FEW => {
                let text = format!("      with {} recordings", names.len());
                ui.label(small(text).weak()).on_hover_text(names.join("\n"));
            }
            Some(Ok(names)) => {
                ui.label(small(format!("      with {}", names.join(", "))).weak());
            }
            None => {}
        }
    }
    if let Some((step, job)) = &state.identification.job {
        ui.horizontal(|ui| {
            ui.spinner();
            let what = step.map_or("looking at the recordings", Step::title);
            ui.label(small(what));
            if step.is_some() && ui.button("Cancel").clicked() {
                job.cancel();
            }
        });
    }
    if let Some(step) = start {
        let context = ui.ctx().clone();
        let (setup, fitting) = (&state.setup, &state.fitting);
        state.identification.start(step, setup, fitting, &context);
    }
}

fn finding(ui: &mut Ui, state: &mut State) {
    let Some(step) = state.identification.chosen else {
        ui.weak("Take a step to see its figure.");
        return;
    };
    heading(ui, step.title());
    match state.identification.findings.get(step.id()).cloned() {
        None => {
            let taken = state.identification.job.as_ref();
            let busy = taken.is_some_and(|(taken, _)| *taken == Some(step));
            ui.weak(if busy {
                "Being taken."
            } else {
                "Not taken yet."
            });
        }
        Some(Err(error)) => {
            ui.colored_label(error_color(ui), error);
        }
        Some(Ok(found)) => {
            if !matches!(found, Finding::Sensitivity(_)) {
                let apply = ui.button("Apply");
                if apply
                    .on_hover_text("Give the device what was found; undo takes it back")
                    .clicked()
                {
                    found.apply(&mut state.setup.preset.model);
                }
            }
            match &found {
                Finding::Drive(found) => drive(ui, found),
                Finding::Restitution(found) => restitution(ui, found),
                Finding::Adhesion(found) => adhesion(ui, found),
                Finding::Film(found) => film(ui, found),
                Finding::Sensitivity(found) => sensitivity(ui, found),
            }
        }
    }
}

fn plot<'a>(name: &'a str, x: &'a str, y: &'a str) -> Plot<'a> {
    Plot::new(name)
        .height(250.0)
        .x_axis_label(x)
        .y_axis_label(y)
        .legend(
            Legend::default()
                .position(Corner::RightTop)
                .background_alpha(0.6),
        )
        .x_grid_spacer(super::round_steps())
        .y_grid_spacer(super::round_steps())
        .allow_scroll(false)
}

fn drive(ui: &mut Ui, found: &DriveFit) {
    let piezo = found.piezo();
    plot("step drive", "V [V]", "gc").show(ui, |plot| {
        for (branch, name, fit) in [
            (Branch::Rising, "rising", &found.rising),
            (Branch::Falling, "falling", &found.falling),
        ] {
            let points: Vec<[f64; 2]> = found
                .points
                .iter()
                .filter(|p| p.branch == branch)
                .map(|p| [p.voltage, p.gain])
                .collect();
            plot.points(Points::new(format!("{name}, measured"), points).radius(2.0));
            let (low, high) = fit.seen;
            let curve: PlotPoints<'_> = (0..=CURVE)
                .map(|i| low + (high - low) * i as f64 / CURVE as f64)
                .map(|v| [v, piezo.gain(v, branch)])
                .collect();
            plot.line(Line::new(format!("{name}, fitted"), curve).width(1.5));
        }
    });
    for (name, fit) in [("rising", &found.rising), ("falling", &found.falling)] {
        let terms: Vec<String> = fit.coefficients.iter().map(|c| format!("{c:.4}")).collect();
        ui.label(small(format!(
            "{name}: coefficients of V^0 to V^3 {}; scatter {:.4}",
            terms.join(", "),
            fit.scatter
        )));
    }
}

fn restitution(ui: &mut Ui, found: &Restitution) {
    let number = |i: usize| (i + 1) as f64;
    let points: Vec<[f64; 2]> = found
        .bounces
        .iter()
        .enumerate()
        .map(|(i, b)| [number(i), b.ratio])
        .collect();
    let end = number(points.len());
    plot("step restitution", "bounce", "-v+ / v-")
        .include_y(0.0)
        .show(ui, |plot| {
            for (i, b) in found.bounces.iter().enumerate() {
                let bar = vec![
                    [number(i), b.ratio - b.error],
                    [number(i), b.ratio + b.error],
                ];
                plot.line(Line::new("", PlotPoints::from(bar)).width(1.0));
            }
            plot.points(Points::new("measured", points).radius(3.0));
            let mean = vec![[0.5, found.mean], [end + 0.5, found.mean]];
            plot.line(Line::new("mean", PlotPoints::from(mean)).width(1.5));
        });
    ui.label(format!(
        "alpha = {:.4} \u{b1} {:.4}, scatter {:.4} over {} bounces",
        found.mean,
        found.error,
        found.scatter,
        found.bounces.len()
    ));
    ui.label(small(format!(
        "If it is constant, a dependence on speed this strong has probability {:.2}.",
        found.constant
    )));
}

fn adhesion(ui: &mut Ui, found: &Adhesion) {
    let longest = found.releases.iter().fold(0.0f64, |a, r| a.max(r.contact));
    let at = |i: usize| 1.05 * longest * i as f64 / CURVE as f64;
    let curve = |side: f64| -> PlotPoints<'static> {
        let points: Vec<[f64; 2]> = (0..=CURVE)
            .map(|i| {
                let (force, half) = found.band(at(i));
                [1e3 * at(i), 1e9 * (force + side * half)]
            })
            .collect();
        points.into()
    };
    plot(
        "step adhesion",
        "contact duration [ms]",
        "pull-off force [nN]",
    )
    .show(ui, |plot| {
        let points: Vec<[f64; 2]> = found
            .releases
            .iter()
            .map(|r| [1e3 * r.contact, 1e9 * r.force])
            .collect();
        plot.points(Points::new("releases", points).radius(3.0));
        plot.line(Line::new("Ca t + Ca0", curve(0.0)).width(1.5));
        for side in [-1.0, 1.0] {
            plot.line(Line::new("95 % band", curve(side)).width(0.7));
        }
    });
    for (name, (value, error), unit) in [("Ca", found.rate, "N/s"), ("Ca0", found.start, "N")] {
        ui.label(format!(
            "{name} = {} \u{b1} {}",
            format_quantity(value, unit, 4),
            format_quantity(error, unit, 2)
        ));
    }
}

fn film(ui: &mut Ui, found: &Film) {
    if let Some(decay) = &found.decay {
        let palette = style::palette(ui);
        let (with, without) = (palette.proof_mass, palette.impact);
        // All three would lie on each other: what tells them apart is drawn below.
        let rest = |values: &[f64]| -> PlotPoints<'static> {
            let points: Vec<[f64; 2]> = (decay.time.iter())
                .zip(values.iter().zip(&decay.measured))
                .map(|(t, (x, measured))| [1e3 * t, 1e6 * (x - measured)])
                .collect();
            points.into()
        };
        let line = |values: &[f64]| -> PlotPoints<'static> {
            let points: Vec<[f64; 2]> = decay
                .time
                .iter()
                .zip(values)
                .map(|(t, x)| [1e3 * t, 1e6 * x])
                .collect();
            points.into()
        };
        plot("step film", "time after break-off [ms]", "xp [\u{b5}m]").show(ui, |plot| {
            plot.line(
                Line::new("recording", line(&decay.measured))
                    .color(palette.text)
                    .width(2.5),
            );
            plot.line(
                Line::new("with film", line(&decay.with_film))
                    .color(with)
                    .width(1.5),
            );
            plot.line(
                Line::new("without film", line(&decay.without_film))
                    .color(without)
                    .width(1.0),
            );
        });
        let name = "model - recording [\u{b5}m]";
        plot("step film residual", "time after break-off [ms]", name)
            .height(170.0)
            .show(ui, |plot| {
                plot.line(
                    Line::new("with film", rest(&decay.with_film))
                        .color(with)
                        .width(1.5),
                );
                plot.line(
                    Line::new("without film", rest(&decay.without_film))
                        .color(without)
                        .width(1.0),
                );
            });
    }
    for p in &found.fit.parameters {
        ui.label(format!(
            "{} = {} \u{b1} {}",
            p.id,
            format_quantity(p.value, p.unit, 4),
            format_quantity(p.std_error, p.unit, 2)
        ));
    }
    ui.label(format!(
        "rms with the film {}, without {}",
        format_quantity(found.with_film.rms, "m", 3),
        format_quantity(found.without_film.rms, "m", 3)
    ));
    for remark in &found.fit.remarks {
        ui.label(small(remark));
    }
}

fn sensitivity(ui: &mut Ui, found: &Sensitivity) {
    Grid::new("step sensitivity")
        .num_columns(3)
        .striped(true)
        .spacing([20.0, 3.0])
        .show(ui, |ui| {
            for title in ["", "original", "dp + 20 \u{b5}m"] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for id in ROWS {
                let spec = id.spec();
                ui.label(spec.symbol);
                for fit in [&found.original, &found.altered] {
                    let value = fit.model.parameters[id];
                    ui.label(format_quantity(value, spec.unit, 4));
                }
                ui.end_row();
            }
        });
}
