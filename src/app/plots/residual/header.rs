//! The row above the residual: its unit, and whether its scale follows the curve or stays.

use eframe::egui::{Button, Id, Ui, vec2};

use crate::app::setup::command::Command;
use crate::app::setup::view::{FIXED_NOISE, ResidualUnit};
use crate::app::state::State;
use crate::app::widgets::quantity_field::QuantityField;

/// Height of a row of controls \[points\].
const ROW_HEIGHT: f32 = 24.0;
/// Width that all controls take in one row \[points\].
const ROW_WIDTH: f32 = 390.0;
/// Width of the field for the limits \[points\].
const FIELD_WIDTH: f32 = 84.0;

/// Its height for a `width` \[points\].
pub fn height(width: f32) -> f32 {
    if width < ROW_WIDTH {
        2.0 * ROW_HEIGHT
    } else {
        ROW_HEIGHT
    }
}

/// Draws it; `range` is the values in view, SI.
pub fn show(ui: &mut Ui, state: &mut State, range: (f64, f64)) {
    let size = vec2(ui.available_width(), height(ui.available_width()));
    ui.allocate_ui(size, |ui| {
        ui.set_min_size(size);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = vec2(4.0, 2.0);
            ui.spacing_mut().button_padding.y = 1.0;
            unit(ui, state);
            ui.separator();
            scale(ui, state, range);
        });
    });
}

fn unit(ui: &mut Ui, state: &mut State) {
    let help = Command::ResidualUnit.with_keys(Command::ResidualUnit.text().1);
    for (unit, text) in [
        (ResidualUnit::Length, "\u{b5}m"),
        (ResidualUnit::Noise, "x noise"),
    ] {
        let is_on = state.view.residual_unit == unit;
        let button = ui.selectable_label(is_on, text);
        if button.on_hover_text(&help).clicked() {
            state.view.residual_unit = unit;
        }
    }
}

fn scale(ui: &mut Ui, state: &mut State, range: (f64, f64)) {
    let name = state.view.residual_scale();
    let is_chosen = state.view.value_ranges.contains_key(name);
    let automatic = ui.add(Button::selectable(!is_chosen, "automatic"));
    let help = "The scale follows the curve: it grows at once, and shrinks after a drag. \
         Press again to fix it as it is.";
    if automatic.on_hover_text(help).clicked() {
        if is_chosen {
            state.view.release_values(name);
        } else {
            state.view.fix_values(name, range);
        }
    }
    ui.label("\u{b1}");
    let unit = state.view.residual_unit.base();
    let field = QuantityField {
        id: Id::unique("limits of the residual"),
        label: "limits of the residual",
        value: range.0.abs().max(range.1.abs()),
        unit,
        width: FIELD_WIDTH,
        enabled: true,
    };
    let check = |half: f64| {
        let is_good = crate::app::plots::value_range::is_valid((-half, half));
        (!is_good).then(|| "the limits must be above 0; type for example 1 um or 5".to_owned())
    };
    let typed = field.show(ui, check);
    if let Some(half) = typed.value {
        state.view.fix_values(name, (-half, half));
    }
    let help = match typed.error {
        Some(reason) => reason,
        None => "Type limits to fix the scale. The wheel on the axis zooms.".to_owned(),
    };
    typed.response.on_hover_text(help);
    let fixed = state.view.value_ranges.get(name) == Some(&(-FIXED_NOISE, FIXED_NOISE));
    let is_on = fixed && state.view.residual_unit == ResidualUnit::Noise;
    let text = format!("\u{b1}{FIXED_NOISE} x noise");
    let button = ui.add(Button::selectable(is_on, text));
    if button
        .on_hover_text(Command::FixResidual.text().1)
        .clicked()
    {
        state.view.fix_residual_in_noise();
    }
}
