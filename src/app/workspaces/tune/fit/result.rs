//! The result of a fit: values with their errors, goodness of fit, what the data do not
//! determine. It can be applied or discarded.

use eframe::egui::{Button, Grid, RichText, Ui};

use super::choose::symbol;
use super::{picture, profile};
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::app::widgets::result_buttons::{apply_button, discard_button};
use crate::app::widgets::text::{heading, small};
use crate::fit::{FitResult, FittedParameter, Misfit};
use crate::model::unit::{format_number, format_quantity};

/// Draws the result.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(result) = state.fitting.result.clone() else {
        return;
    };
    if result.cancelled {
        ui.label("Ended early: this is the best so far.");
    }
    if let Some(differences) = state.fitting.differences(&state.setup) {
        ui.label(small(differences).color(ui.visuals().warn_fg_color));
    }
    apply_or_discard(ui, state);
    ui.add_space(4.0);
    values(ui, &result);
    ui.add_space(6.0);
    goodness(ui, &result);
    if !result.remarks.is_empty() {
        ui.add_space(6.0);
        heading(ui, "What the data do not determine");
        for remark in &result.remarks {
            ui.label(small(remark));
        }
    }
    ui.add_space(6.0);
    picture::correlations(ui, &result);
    ui.add_space(6.0);
    profile::show(ui, state, &result);
}

fn apply_or_discard(ui: &mut Ui, state: &mut State) {
    let device = &state.setup.preset.model;
    let fits = state
        .fitting
        .result
        .as_ref()
        .is_some_and(|r| r.model.name == device.name);
    ui.horizontal(|ui| {
        if apply_button(ui, fits) {
            state.fitting.apply(&mut state.setup);
        }
        let applied = state.fitting.is_applied(&state.setup);
        let undo = ui.add_enabled(applied, Button::new("Undo"));
        if undo
            .on_hover_text(Command::Undo.with_keys("Undo the last change of the device"))
            .on_disabled_hover_text("The sliders no longer show the fitted values")
            .clicked()
        {
            state.ask(Command::Undo);
        }
        if discard_button(ui) {
            state.fitting.discard();
        }
        ui.checkbox(&mut state.fitting.shown, "Show its curves")
            .on_hover_text("The plots show the fitted device until it is applied or discarded");
    });
}

fn values(ui: &mut Ui, result: &FitResult) {
    heading(ui, "Values");
    Grid::new("fit values")
        .num_columns(5)
        .striped(true)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            for title in ["", "before", "fitted", "std. error", "change"] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for parameter in &result.parameters {
                value(ui, parameter);
                ui.end_row();
            }
        });
}

fn value(ui: &mut Ui, parameter: &FittedParameter) {
    let write = |value: f64, digits| format_quantity(value, parameter.unit, digits);
    ui.label(symbol(&parameter.id)).on_hover_text(&parameter.id);
    ui.label(write(parameter.start, 4));
    let fitted = ui.label(RichText::new(write(parameter.value, 4)).strong());
    if parameter.at_bound {
        fitted.on_hover_text("At the limit of its range: the data favour a value beyond it");
    }
    let is_uncertain = !parameter.std_error.is_finite()
        || parameter.std_error > 0.5 * parameter.value.abs().max(f64::MIN_POSITIVE);
    let text = if parameter.std_error.is_finite() {
        format!("\u{b1} {}", write(parameter.std_error, 2))
    } else {
        "not determined".to_owned()
    };
    let text = RichText::new(text);
    ui.label(if is_uncertain {
        text.color(ui.visuals().warn_fg_color)
    } else {
        text
    });
    let change = 100.0 * (parameter.value / parameter.start - 1.0);
    let mut note = if change.is_finite() {
        format!("{change:+.1} %")
    } else {
        "-".to_owned()
    };
    if parameter.at_bound {
        note.push_str(", at its bound");
    }
    ui.label(small(note));
}

fn goodness(ui: &mut Ui, result: &FitResult) {
    heading(ui, "Goodness of fit");
    Grid::new("fit distances")
        .num_columns(5)
        .striped(true)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            for (title, help) in [
                ("", ""),
                ("rms", "Root mean square of simulation minus recording, xp"),
                ("noise", "The recording's own noise, estimated from it"),
                ("rms / noise", "1 is a perfect model"),
                (
                    "chi2",
                    "Mean square of all residuals in units of their noise",
                ),
            ] {
                let label = ui.label(small(title).strong());
                if !help.is_empty() {
                    label.on_hover_text(help);
                }
            }
            ui.end_row();
            lines(ui, "fitted", &result.train);
            if let Some(held_out) = &result.held_out {
                lines(ui, "held out", held_out);
            }
        });
    set_aside(ui, "fitted", &result.train.0);
    if let Some((held_out, _)) = &result.held_out {
        set_aside(ui, "held out", held_out);
    }
}

/// Says why chi2 may be near 1 although the rms is far above the noise.
fn set_aside(ui: &mut Ui, kind: &str, all: &Misfit) {
    // Smaller shares would be shown as 0 %.
    if all.set_aside < 5e-4 {
        return;
    }
    let text = format!(
        "{kind}: {} % of the samples lie where an event could not be resolved: they count in rms, but not in chi2 or the fit.",
        format_number(100.0 * all.set_aside, 2)
    );
    ui.label(small(text).color(ui.visuals().warn_fg_color));
}

fn lines(ui: &mut Ui, kind: &str, (all, each): &(Misfit, Vec<Misfit>)) {
    let mut line = |name: String, misfit: &Misfit, strong: bool| {
        let text = |text: String| {
            let text = RichText::new(text);
            if strong { text.strong() } else { text }
        };
        ui.label(text(name));
        ui.label(text(format_quantity(misfit.rms, "m", 3)));
        ui.label(text(format_quantity(misfit.noise, "m", 2)));
        let ratio = misfit.rms / misfit.noise;
        ui.label(text(format_number(ratio, 3)));
        ui.label(text(format_number(misfit.chi2, 3)));
        ui.end_row();
    };
    line(format!("{kind}, all"), all, true);
    if each.len() > 1 {
        for misfit in each {
            line(format!("   {}", misfit.name), misfit, false);
        }
    }
}
