//! The device drawn; stand-in.

use eframe::egui::Ui;

use crate::app::state::State;

/// Draws the device at `time` [s].
pub fn show(ui: &mut Ui, _state: &State, time: Option<f64>) {
    ui.label(format!("device at {time:?}"));
}
