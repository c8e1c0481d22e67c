//! The Tune workspace: sliders on the left, plots in the middle, recordings and readouts on
//! the right, time controls at the top.

pub mod drive;
mod fit;
mod parameters;
mod readouts;
pub(crate) mod recordings;
mod start;
pub mod table_a1;
#[cfg(test)]
mod tests;
pub(crate) mod transport;

pub use self::recordings::remove as remove_recording;
pub use self::start::start_from_recording;
pub use self::transport::usual_speed;
pub use crate::app::setup::current_setup::choose_preset;

use eframe::egui::{CentralPanel, Panel, ScrollArea, Ui, Window};

use crate::app::plots;
use crate::app::state::State;

/// Draws the workspace.
pub fn show(ui: &mut Ui, state: &mut State) {
    transport::show(ui, state);
    Panel::left("tune parameters")
        .default_size(350.0)
        .size_range(280.0..=480.0)
        .show(ui, |ui| parameters::show(ui, state));
    let mut side = state.view.side_panel;
    Panel::right("tune readouts")
        .default_size(300.0)
        .size_range(250.0..=480.0)
        .show_collapsible(ui, &mut side, |ui| {
            side_panel(ui, state);
        });
    state.view.side_panel = side;
    CentralPanel::default().show(ui, |ui| plots::show(ui, state));
    let mut open = state.drive_editor_open;
    if open {
        Window::new("Drive editor")
            .open(&mut open)
            .default_width(420.0)
            .default_pos([380.0, 90.0])
            .show(ui, |ui| {
                drive::editor::show(ui, state, self::drive::place::Place::Window);
            });
        state.drive_editor_open = open && state.drive_editor_open;
    }
    table_a1::panel::show(ui, state);
    fit::show(ui, state);
}

fn side_panel(ui: &mut Ui, state: &mut State) {
    ScrollArea::vertical()
        .id_salt("side")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            ui.set_max_width(ui.available_width() - 6.0);
            readouts::section(ui, "Recordings", |ui| recordings::show(ui, state));
            readouts::show(ui, state);
            if state.setup.preset.model.has_ground {
                readouts::section(ui, "Table A.1", |ui| table_a1::case_picker::show(ui, state));
            }
            ui.add_space(12.0);
        });
}
