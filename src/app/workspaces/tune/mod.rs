//! The Tune workspace: sliders on the left, pictures in the middle, recordings and
//! readouts on the right, time at the top.

pub mod drive_editor;
mod icon;
mod original;
mod parameters;
mod quantity;
mod rail;
mod slider;
mod transport;

pub use parameters::choose_preset;

use eframe::egui::{CentralPanel, Id, Panel, Ui, Window};

use crate::app::plots;
use crate::app::state::State;

/// Draws the workspace.
pub fn show(ui: &mut Ui, state: &mut State) {
    let key = Id::unique("tune side panel");
    let mut side = ui.data_mut(|data| *data.get_persisted_mut_or(key, true));
    transport::show(ui, state, &mut side);
    Panel::left("tune parameters")
        .default_size(330.0)
        .size_range(280.0..=480.0)
        .show(ui, |ui| parameters::show(ui, state));
    Panel::right("tune readouts")
        .default_size(300.0)
        .size_range(250.0..=480.0)
        .show_collapsible(ui, &mut side, |ui| {
            ui.take_available_space();
        });
    ui.data_mut(|data| data.insert_persisted(key, side));
    CentralPanel::default().show(ui, |ui| plots::show(ui, state));
    let mut open = state.drive_editor_open;
    if open {
        Window::new("Drive editor")
            .open(&mut open)
            .default_width(420.0)
            .show(ui, |ui| {
                drive_editor::show(ui, state, drive_editor::Place::Window);
            });
        state.drive_editor_open = open && state.drive_editor_open;
    }
}
