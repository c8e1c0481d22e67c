//! The choice of parameters to fit and of recordings to fit them to.

use std::collections::BTreeSet;

use eframe::egui::{Grid, Ui};

use crate::app::analysis::fit::candidates;
use crate::app::analysis::recording_roles;
use crate::app::plots::frame::style::overlay_color;
use crate::app::setup::overlay::Role;
use crate::app::state::State;
use crate::app::widgets::role_choice::role_choice;
use crate::app::widgets::text::{heading, short, small};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::format_quantity;

/// Columns of the list of parameters.
const PARAMETER_COLUMNS: usize = 4;

/// Check boxes for the parameters.
pub fn parameters(ui: &mut Ui, state: &mut State) {
    heading(ui, "Parameters to fit");
    let setup = &state.setup;
    let model = &setup.preset.model;
    let ids = candidates(model);
    let ticked: BTreeSet<String> = state.fitting.free(setup).into_iter().collect();
    let mut changed = None;
    let busy = state.fitting.job.is_some();
    Grid::new("fit parameters")
        .num_columns(PARAMETER_COLUMNS)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            for (i, id) in ids.iter().enumerate() {
                let locked = setup.locked.contains(id);
                let mut on = ticked.contains(id);
                let before = on;
                let text = symbol(id);
                ui.add_enabled_ui(!busy && !locked, |ui| {
                    let check = ui.checkbox(&mut on, text);
                    let help = if locked {
                        format!("{id} is locked at its slider")
                    } else {
                        hint(model, id)
                    };
                    check.on_hover_text(&help).on_disabled_hover_text(help);
                });
                if on != before {
                    changed = Some((id.clone(), on));
                }
                if i % PARAMETER_COLUMNS == PARAMETER_COLUMNS - 1 {
                    ui.end_row();
                }
            }
        });
    if let Some((id, on)) = changed {
        let mut free = state.fitting.free.clone().unwrap_or(ticked);
        if on {
            free.insert(id);
        } else {
            free.remove(&id);
        }
        state.fitting.free = Some(free);
    }
    if state.fitting.free.is_some() && !busy && ui.small_button("Default choice").clicked() {
        state.fitting.free = None;
    }
}

/// The symbol of a parameter. That of an effect is preceded by the name of the effect.
pub fn symbol(id: &str) -> String {
    match ParameterId::from_id(id) {
        Some(parameter) => parameter.spec().symbol.to_owned(),
        None => id.replace('.', " "),
    }
}

fn hint(model: &Model, id: &str) -> String {
    let value = model.get(id).map_or(String::new(), |value| {
        let unit = model.unit_of(id).unwrap_or("");
        format!(", now {}", format_quantity(value, unit, 4))
    });
    let name = ParameterId::from_id(id).map_or(id, |parameter| parameter.spec().name);
    format!("{name}{value}")
}

/// The role of each recording.
pub fn recordings(ui: &mut Ui, state: &mut State) {
    heading(ui, "Recordings");
    if state.setup.overlays.is_empty() {
        ui.weak("None yet. Drop a CSV file on the window, or open one.");
        return;
    }
    let busy = state.fitting.job.is_some();
    let mut any_held_out = false;
    let mut chosen = None;
    Grid::new("fit recordings")
        .num_columns(4)
        .spacing([12.0, 3.0])
        .show(ui, |ui| {
            for (overlay, role) in recording_roles::of(&state.setup) {
                let color = overlay_color(ui, overlay.color);
                let name = &overlay.recording.name;
                ui.colored_label(color, short(name, 26)).on_hover_text(name);
                ui.add_enabled_ui(!busy, |ui| {
                    if let Some(role) = role_choice(ui, name, role) {
                        chosen = Some((overlay.id, role));
                    }
                });
                any_held_out |= role == Role::HeldOut;
                ui.end_row();
            }
        });
    if let Some((id, role)) = chosen {
        recording_roles::choose(&mut state.setup, id, role);
    }
    if !any_held_out {
        ui.label(small("No recording is held out, so the last third of each is.").weak());
    }
}
