//! The Explore workspace: how the steady response depends on drive and coefficients, one panel for
//! each question.

mod axis_picker;
mod basins;
mod case;
mod fields;
mod gait;
mod map;
mod orbit;
mod progress;
mod readout;
mod robustness;
#[cfg(test)]
mod tests;
mod waveform;

pub use self::gait::gait_of;

use eframe::egui::{CentralPanel, Panel, RichText, Ui};

use crate::app::setup::command::Command;
use crate::app::setup::explore::ExplorePanel;
use crate::app::state::State;

/// Draws the workspace.
pub fn show(ui: &mut Ui, state: &mut State) {
    Panel::top("explore tabs").show(ui, |ui| tabs(ui, state));
    CentralPanel::default().show(ui, |ui| match state.view.explore_panel {
        ExplorePanel::Waveform => waveform::show(ui, state),
        ExplorePanel::Gait => gait::show(ui, state),
        ExplorePanel::Map => map::show(ui, state),
        ExplorePanel::Orbit => orbit::show(ui, state),
        ExplorePanel::Basins => basins::show(ui, state),
        ExplorePanel::Robustness => robustness::show(ui, state),
    });
}

fn tabs(ui: &mut Ui, state: &mut State) {
    ui.add_space(2.0);
    ui.horizontal_wrapped(|ui| {
        for panel in ExplorePanel::ALL {
            let is_shown = state.view.explore_panel == panel;
            let text = RichText::new(panel.title()).size(14.0);
            let tab = ui.selectable_label(is_shown, text);
            if tab.on_hover_text(panel.help()).clicked() {
                state.ask(Command::Explore(panel));
            }
        }
        ui.separator();
        let model = &state.setup.preset.model;
        let with = match model.effects.len() {
            0 => String::new(),
            1 => format!(" with {}", model.effects[0].spec.name),
            n => format!(" with {n} effects"),
        };
        ui.weak(format!("Device: {}{with}", model.name))
            .on_hover_text("The device of the Tune workspace; its sliders are there");
    });
    ui.add_space(2.0);
}
