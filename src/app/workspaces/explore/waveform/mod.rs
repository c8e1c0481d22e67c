//! The waveform editor: fields on the left, the period with its handles and the steady response in
//! the middle, the numbers of the response on the right.

mod canvas;
mod fields;
mod form;

use std::sync::Arc;

use eframe::egui::{CentralPanel, Panel, ScrollArea, Ui};

use super::readout;
use crate::app::analysis::explore::latest::Answered;
use crate::app::analysis::explore::steady::{SteadyQuestion, SteadyWork};
use crate::app::plots::explore::cycle;
use crate::app::state::State;

/// Width of the fields \[points\].
const FIELDS_WIDTH: f32 = 280.0;
/// Share of the height that the period takes.
const CANVAS_SHARE: f32 = 0.52;

/// Draws the panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    let newest = ask(ui, state);
    Panel::left("waveform fields")
        .exact_size(FIELDS_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("waveform fields")
                .auto_shrink([false, false])
                .show(ui, |ui| fields::show(ui, state));
        });
    Panel::right("waveform numbers")
        .exact_size(readout::READOUT_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("waveform numbers")
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    let waits = state.exploring.drawing.steady.is_waiting();
                    readout::show(ui, newest.as_deref(), waits);
                });
        });
    CentralPanel::default().show(ui, |ui| {
        let size = ui.available_size();
        canvas::show(ui, state, (CANVAS_SHARE * size.y).floor());
        if let Some(Ok(view)) = newest.as_ref().map(|newest| &newest.answer) {
            let room = ui.available_size();
            cycle::show(ui, "drawn waveform", view, [room.x, room.y - 2.0]);
        }
    });
}

/// Asks for the response under the drawn drive; returns the newest answer.
fn ask(ui: &Ui, state: &mut State) -> Option<Arc<Answered<SteadyWork>>> {
    let model = &state.setup.preset.model;
    if model.piezo.is_some()
        && let Ok(drive) = state.setup.explore.drawn.waveform()
    {
        let model = state.exploring.device(model);
        let question = SteadyQuestion { model, drive };
        state.exploring.drawing.steady.ask(question, ui.ctx());
    }
    state.exploring.drawing.steady.newest()
}
