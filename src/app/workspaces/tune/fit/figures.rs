//! The figures of the identification steps: data, fitted curves, and the numbers below.

use eframe::egui::{Grid, Ui};
use egui_plot::{Corner, Legend, Line, LineStyle, Plot, PlotPoints, Points};

use crate::app::plots::frame::style;
use crate::app::widgets::text::{error_color, small};
use crate::fit::FitResult;
use crate::fit::contact_readings::Release;
use crate::fit::paper_steps::adhesion::Adhesion;
use crate::fit::paper_steps::drive::DriveFit;
use crate::fit::paper_steps::film::Film;
use crate::fit::paper_steps::model_distance_warning;
use crate::fit::paper_steps::restitution::Restitution;
use crate::fit::paper_steps::sensitivity::{Sensitivity, TABLE_2_ROWS};
use crate::model::parameter::ParameterId;
use crate::model::piezo::Branch;
use crate::model::unit::{counted, format_quantity};

/// Points of a fitted curve.
const CURVE_POINTS: usize = 120;

pub(super) fn plot<'a>(name: &'a str, x: &'a str, y: &'a str) -> Plot<'a> {
    bare(name, x, y).legend(
        Legend::default()
            .position(Corner::RightTop)
            .background_alpha(0.6),
    )
}

/// A figure without a legend.
fn bare<'a>(name: &'a str, x: &'a str, y: &'a str) -> Plot<'a> {
    Plot::new(name)
        .height(250.0)
        .x_axis_label(x)
        .y_axis_label(y)
        .x_grid_spacer(crate::app::widgets::text::round_steps())
        .y_grid_spacer(crate::app::widgets::text::round_steps())
        .x_axis_formatter(crate::app::widgets::text::round_text)
        .y_axis_formatter(crate::app::widgets::text::round_text)
        .allow_scroll(false)
}

pub(super) fn drive(ui: &mut Ui, found: &DriveFit) {
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
            let curve: PlotPoints<'_> = (0..=CURVE_POINTS)
                .map(|i| low + (high - low) * i as f64 / CURVE_POINTS as f64)
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

pub(super) fn restitution(ui: &mut Ui, found: &Restitution) {
    let palette = style::palette(ui);
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
        // The ratios are far above zero, so the space below them is free.
        .legend(
            Legend::default()
                .position(Corner::RightBottom)
                .background_alpha(0.6),
        )
        .show(ui, |plot| {
            for (i, b) in found.bounces.iter().enumerate() {
                let bar = vec![
                    [number(i), b.ratio - b.error],
                    [number(i), b.ratio + b.error],
                ];
                let bar = Line::new("", PlotPoints::from(bar));
                plot.line(bar.color(palette.impact).width(1.0));
            }
            let measured = Points::new("measured", points).radius(3.0);
            plot.points(measured.color(palette.impact));
            let mean = vec![[0.5, found.mean], [end + 0.5, found.mean]];
            let mean = Line::new("mean", PlotPoints::from(mean));
            plot.line(mean.color(palette.proof_mass).width(1.5));
        });
    ui.label(format!(
        "alpha = {:.4} \u{b1} {:.4}, scatter {:.4} over {}",
        found.mean,
        found.error,
        found.scatter,
        counted(found.bounces.len(), "bounce")
    ));
    ui.label(small(format!(
        "If alpha is constant, a dependence on speed this strong has probability {:.2}.",
        found.constant
    )));
    if found.aside.count() > 0 {
        ui.label(small(found.aside.to_string()));
    }
    warn(ui, found.off);
}

pub(super) fn adhesion(ui: &mut Ui, found: &Adhesion) {
    let palette = style::palette(ui);
    let longest = found.releases.iter().fold(0.0f64, |a, r| a.max(r.contact));
    let at = |i: usize| 1.05 * longest * i as f64 / CURVE_POINTS as f64;
    let (fitted, read) = (palette.proof_mass, palette.impact);
    // Two plots: the force, and its residual from the line, where band and errors are visible.
    // The band grows outside the measured contact times, so the points set the scale.
    let reach = (found.releases.iter())
        .map(|r| (r.force - found.line.at(r.contact)).abs() + r.error)
        .fold(0.0, f64::max);
    for (name, label, height, line_share) in [
        ("step adhesion", "pull-off force [nN]", 220.0, 1.0),
        ("step adhesion rest", "residual force [nN]", 150.0, 0.0),
    ] {
        let on_line = |contact: f64| line_share * found.line.at(contact);
        let curve = |side: f64| -> PlotPoints<'static> {
            let points: Vec<[f64; 2]> = (0..=CURVE_POINTS)
                .map(|i| {
                    let half = found.band(at(i)).1;
                    [1e3 * at(i), 1e9 * (on_line(at(i)) + side * half)]
                })
                .collect();
            points.into()
        };
        let figure = bare(name, "contact duration [ms]", label).height(height);
        let figure = if line_share > 0.0 {
            // The line rises, so the upper left is free.
            figure.include_y(0.0).legend(
                Legend::default()
                    .position(Corner::LeftTop)
                    .background_alpha(0.6),
            )
        } else {
            // Same colours as above; a legend would cover points.
            figure
                .default_y_bounds(-2.2e9 * reach, 2.2e9 * reach)
                .default_x_bounds(0.0, 1.05e3 * longest)
        };
        figure.show(ui, |plot| {
            for side in [-1.0, 1.0] {
                let band = Line::new("95 % band", curve(side)).color(palette.text);
                plot.line(band.style(LineStyle::dashed_loose()).width(1.0));
            }
            let line = Line::new("Ca t + Ca0", curve(0.0));
            plot.line(line.color(fitted).width(1.5));
            let drawn = |r: &Release| r.force - found.line.at(r.contact) + on_line(r.contact);
            for r in &found.releases {
                let ends = [drawn(r) - r.error, drawn(r) + r.error];
                let bar = ends.map(|force| [1e3 * r.contact, 1e9 * force]).to_vec();
                let bar = Line::new("", PlotPoints::from(bar));
                plot.line(bar.color(read).width(1.0));
            }
            let points: Vec<[f64; 2]> = found
                .releases
                .iter()
                .map(|r| [1e3 * r.contact, 1e9 * drawn(r)])
                .collect();
            let points = Points::new("releases", points).color(read);
            plot.points(points.radius(3.0));
        });
    }
    for (name, (value, error), unit) in [("Ca", found.rate, "N/s"), ("Ca0", found.start, "N")] {
        ui.label(format!("{name} = {}", measured(value, error, unit)));
    }
    ui.label(small(format!(
        "Line through {}; bars: standard errors.",
        counted(found.releases.len(), "release")
    )));
    for sentence in found.set_aside() {
        ui.label(small(format!("Set aside: {sentence}.")));
    }
    warn(ui, found.off);
}

/// Warns if the model is too far from the recordings for the readings to be reliable.
fn warn(ui: &mut Ui, off: f64) {
    if let Some(sentence) = model_distance_warning(off) {
        ui.label(small(sentence).color(error_color(ui)));
    }
}

pub(super) fn film(ui: &mut Ui, found: &Film) {
    if let Some(decay) = &found.decay {
        let palette = style::palette(ui);
        let (with, without) = (palette.proof_mass, palette.impact);
        // The three curves nearly coincide; their differences are plotted below.
        let residual = |values: &[f64]| -> PlotPoints<'static> {
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
                    Line::new("with film", residual(&decay.with_film))
                        .color(with)
                        .width(1.5),
                );
                plot.line(
                    Line::new("without film", residual(&decay.without_film))
                        .color(without)
                        .width(1.0),
                );
            });
    }
    for p in &found.fit.parameters {
        let value = measured(p.value, p.std_error, p.unit);
        ui.label(format!("{} = {value}", p.id));
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

pub(super) fn sensitivity(ui: &mut Ui, found: &Sensitivity) {
    let fits = [&found.original, &found.altered];
    Grid::new("step sensitivity")
        .num_columns(4)
        .striped(true)
        .spacing([20.0, 3.0])
        .show(ui, |ui| {
            for title in ["", "original", "zero 20 \u{b5}m higher", "change"] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for id in TABLE_2_ROWS {
                let spec = id.spec();
                ui.label(spec.symbol).on_hover_text(spec.meaning);
                for fit in fits {
                    ui.label(with_error(fit, id));
                }
                let [a, b] = fits.map(|fit| fit.model.parameters[id]);
                // The gap is measured from the zero position: the film is the same.
                ui.label(if id == ParameterId::Gp {
                    let moved = format_quantity(b - a, spec.unit, 3);
                    format!("+{moved}").replace("+-", "-")
                } else if a != 0.0 {
                    percent(b / a - 1.0)
                } else {
                    String::new()
                });
                ui.end_row();
            }
            ui.label("rms of xp");
            for fit in fits {
                ui.label(format_quantity(fit.train.0.rms, "m", 3));
            }
            ui.end_row();
        });
    ui.add_space(4.0);
    let mut text =
        "All parameters are identified again with the zero position 20 \u{b5}m higher above \
                    the ground: dp grows by 20 \u{b5}m and the drive's gain shifts accordingly, as \
                    in the paper. gp is measured from the zero position and moves with it."
            .to_owned();
    if found.altered.cancelled {
        text += " Cancelled: the second column is not finished.";
    } else if let Some(verdict) = found.verdict() {
        text += &format!(" {verdict}");
    }
    ui.label(small(text));
}

/// A fitted value with its standard error.
fn with_error(fit: &FitResult, id: ParameterId) -> String {
    let spec = id.spec();
    let value = fit.model.parameters[id];
    match fit.parameters.iter().find(|p| p.id == spec.id) {
        Some(fitted) => measured(value, fitted.std_error, spec.unit),
        None => format!("{}, fixed", format_quantity(value, spec.unit, 4)),
    }
}

/// A value with its standard error, which is infinite if the data do not determine the value.
fn measured(value: f64, error: f64, unit: &str) -> String {
    let value = format_quantity(value, unit, 4);
    if error.is_finite() {
        format!("{value} \u{b1} {}", format_quantity(error, unit, 2))
    } else {
        format!("{value}, not determined")
    }
}

/// A relative change in percent, without a sign if it is too small to show.
fn percent(change: f64) -> String {
    if change.abs() < 5e-5 {
        "below 0.01 %".to_owned()
    } else {
        format!("{:+.2} %", 100.0 * change)
    }
}
