//! The evidence panel: tabs for the residual over time, the missing force, the residual
//! against other quantities, and the contact events.

use eframe::egui::Ui;

use super::{contact_events, force, marginal, zoom};
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::analysis::diagnosis_view::Evidence;
use crate::app::state::State;
use crate::app::widgets::text::small;

/// Draws the tabs and the open figure.
pub fn show(ui: &mut Ui, state: &mut State, answer: &Answer) {
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for tab in Evidence::ALL {
            let (title, help) = tab.text();
            ui.selectable_value(&mut state.diagnosing.look.evidence, tab, small(title))
                .on_hover_text(help);
        }
    });
    match state.diagnosing.look.evidence {
        Evidence::Zoom => zoom::show(ui, state, answer),
        Evidence::Force => force::show(ui, &mut state.diagnosing.look, &answer.diagnosis),
        Evidence::Marginal => marginal::show(ui, &mut state.diagnosing.look, &answer.diagnosis),
        Evidence::Events => contact_events::show(ui, &mut state.diagnosing.look, &answer.diagnosis),
    }
}
