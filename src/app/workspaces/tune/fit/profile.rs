//! Profile likelihood of a parameter on request: how much worse the fit becomes if the
//! parameter is fixed at other values and the rest is refitted.

use eframe::egui::{Button, ComboBox, Ui};
use egui_plot::{HLine, Line, Plot, PlotPoints, Points};

use super::choose::symbol;
use crate::app::state::State;
use crate::app::widgets::job_progress::cancel_button;
use crate::app::widgets::text::{error_color, heading, small};
use crate::fit::FitResult;
use crate::fit::thresholds::CHI2_95_ONE_DOF;
use crate::model::unit::prefix_for;

/// Draws the choice, and the profile that was made last.
pub fn show(ui: &mut Ui, state: &mut State, result: &FitResult) {
    heading(ui, "Profile likelihood");
    let (setup, fitting) = (&state.setup, &mut state.fitting);
    let ids: Vec<String> = result.parameters.iter().map(|p| p.id.clone()).collect();
    let Some(first) = ids.first() else {
        return;
    };
    // An earlier choice may not be among the parameters of this fit.
    let kept = fitting.profile.id.clone().filter(|id| ids.contains(id));
    let mut chosen = kept.unwrap_or(first.clone());
    let is_running = fitting.profile.job.is_some();
    ui.horizontal(|ui| {
        ui.add_enabled_ui(!is_running, |ui| {
            ComboBox::from_id_salt("profile parameter")
                .width(110.0)
                .selected_text(symbol(&chosen))
                .show_ui(ui, |ui| {
                    for id in &ids {
                        ui.selectable_value(&mut chosen, id.clone(), symbol(id));
                    }
                })
                .response
                .on_hover_text("Parameter to vary")
                .on_disabled_hover_text("The profile of this parameter is running");
        });
        fitting.profile.id = Some(chosen);
        if let Some((_, job)) = &fitting.profile.job {
            ui.spinner();
            cancel_button(ui, job, "Stop and keep the points so far");
        } else {
            let why_not = fitting.profile_obstacle(setup);
            let button = ui.add_enabled(why_not.is_none(), Button::new("Profile"));
            if button
                .on_hover_text("Fix it at values around the best fit and refit the others")
                .on_disabled_hover_text(why_not.unwrap_or_default())
                .clicked()
            {
                fitting.start_profile(setup, ui.ctx());
            }
        }
    });
    match &fitting.profile.result {
        None => {}
        Some((_, Err(error))) => {
            ui.colored_label(error_color(ui), error);
        }
        Some((id, Ok(points))) => {
            if fitting.profile.is_incomplete {
                let text = small("Cancelled: the profile is incomplete.");
                ui.label(text.color(ui.visuals().warn_fg_color));
            }
            let unit = result
                .parameters
                .iter()
                .find(|p| p.id == *id)
                .map_or("", |p| p.unit);
            let largest = points.iter().fold(0.0f64, |a, p| a.max(p.value.abs()));
            let (factor, unit) = axis_unit(largest, unit);
            let axis = format!("{} [{unit}]", symbol(id));
            let line: Vec<[f64; 2]> = points.iter().map(|p| [p.value / factor, p.rise]).collect();
            Plot::new("profile")
                .height(180.0)
                .x_axis_label(axis)
                .y_axis_label("increase of the cost")
                .x_grid_spacer(crate::app::widgets::text::round_steps())
                .x_axis_formatter(crate::app::widgets::text::round_text)
                .include_y(0.0)
                .include_y(1.3 * CHI2_95_ONE_DOF)
                .allow_scroll(false)
                .show(ui, |plot| {
                    plot.line(Line::new("profile", PlotPoints::from(line.clone())).width(1.5));
                    plot.points(Points::new("refitted", line).radius(3.0));
                    plot.hline(HLine::new("95 %", CHI2_95_ONE_DOF).width(0.8));
                });
            ui.label(small("Values below the line lie in the 95 % confidence interval. A flat profile means that the data do not determine the parameter.").weak());
        }
    }
}

/// Factor and name of a unit in which values up to `largest` have few digits: with a prefix,
/// or with a power of ten if the unit takes no prefix.
fn axis_unit(largest: f64, unit: &str) -> (f64, String) {
    let (prefix, factor) = prefix_for(largest, unit);
    let shown = largest / factor;
    if shown == 0.0 || (1e-2..1e4).contains(&shown) {
        return (factor, format!("{prefix}{unit}"));
    }
    let power = shown.log10().floor() as i32;
    let text = format!("1e{power} {prefix}{unit}");
    (factor * 10f64.powi(power), text.trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::axis_unit;

    #[test]
    fn axis_units_give_numbers_with_few_digits() {
        assert_eq!(axis_unit(7e-5, "m").1, "\u{b5}m");
        assert_eq!(axis_unit(0.38, ""), (1.0, String::new()));
        let (factor, text) = axis_unit(2.8e-21, "N m^2 s");
        assert_eq!(text, "1e-21 N m^2 s");
        assert!((factor / 1e-21 - 1.0).abs() < 1e-9);
    }
}
