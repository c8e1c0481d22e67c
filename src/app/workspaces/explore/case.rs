//! The case under the pointer of a map: where it is, one cycle of its response, its numbers.

use eframe::egui::{Button, Label, ScrollArea, Ui};

use super::{fields, readout};
use crate::app::flows::open_case;
use crate::app::plots::explore::cycle;
use crate::app::state::State;
use crate::app::widgets::text::{heading, small};
use crate::model::unit::format_quantity;

/// Height of the picture of a cycle \[points\].
const CYCLE_HEIGHT: f32 = 250.0;

/// Draws it.
pub fn show(ui: &mut Ui, state: &mut State) {
    let path = state.exploring.map.path.len() > 1;
    ui.horizontal(|ui| {
        let can_open = state.exploring.map.point.is_some();
        let button = ui.add_enabled(can_open, Button::new("Open in Tune"));
        let help = "Device and drive of this point become those of the Tune workspace (click or \
                    Enter on the map); it can be undone";
        if button.on_hover_text(help).clicked() {
            open_case::open_point(state);
        }
        let play = ui.add_enabled(path, Button::new("Play the path in Live"));
        let help = "Sweep device and drive along the path drawn through the map, as it runs";
        if play.on_hover_text(help).clicked() {
            open_case::play(state);
        }
    });
    ui.separator();
    ScrollArea::vertical()
        .id_salt("map case")
        .auto_shrink([false, false])
        .show(ui, |ui| content(ui, state));
}

fn content(ui: &mut Ui, state: &mut State) {
    let mapping = &mut state.exploring.map;
    let (Some(index), Some(request)) = (mapping.point, mapping.run.asked().cloned()) else {
        heading(ui, "Under the pointer");
        fields::remark(
            ui,
            "Move the pointer over the map, or press the arrow keys on it.",
        );
        return;
    };
    for (axis, value) in request.axes.iter().zip(request.values_at(index)) {
        let value = format_quantity(value, &axis.unit, 4);
        let text = small(format!("{}: {value}", axis.name));
        ui.add(Label::new(text).truncate());
    }
    let hole = mapping
        .run
        .growing()
        .and_then(|growing| growing.lock().answer.holes.get(&index).cloned());
    if let Some(reason) = hole {
        fields::refusal(ui, &format!("Impossible here: {reason}"));
        return;
    }
    let newest = mapping.steady.newest();
    let waits = mapping.steady.is_waiting();
    let width = ui.available_width();
    if let Some(Ok(view)) = newest.as_ref().map(|newest| &newest.answer) {
        ui.scope(|ui| cycle::show(ui, "map case", view, [width, CYCLE_HEIGHT]));
        ui.add_space(4.0);
    }
    readout::show(ui, newest.as_deref(), waits);
}
