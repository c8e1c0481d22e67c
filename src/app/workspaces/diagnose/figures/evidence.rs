//! The picture that supports what is said: a stretch of time, the missing force, what
//! the residual goes with, the events at the ground.

use eframe::egui::Ui;

use super::{contact_events, force, marginal, zoom};
use crate::app::analysis::diagnosis::Answer;
use crate::app::analysis::diagnosis_view::Evidence;
use crate::app::state::State;
use crate::app::workspaces::tune::small;

/// Draws the tabs and the picture that is open.
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

/// Buttons for the quantities that a picture can be drawn against; returns the one that
/// is chosen, which is the first where there is none of that name.
pub fn against(
    ui: &mut Ui,
    chosen: &mut Option<&'static str>,
    all: impl Iterator<Item = &'static str>,
) -> usize {
    let all: Vec<&'static str> = all.collect();
    let mut place = all.iter().position(|a| Some(*a) == *chosen).unwrap_or(0);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = eframe::egui::vec2(3.0, 2.0);
        ui.label(small("against"));
        for (i, quantity) in all.iter().enumerate() {
            let button = ui.selectable_label(place == i, small(spelled(quantity)));
            if button.on_hover_text(meaning(quantity)).clicked() {
                *chosen = Some(quantity);
                place = i;
            }
        }
    });
    place
}

/// A quantity's symbol as on the axes.
pub fn spelled(quantity: &'static str) -> &'static str {
    match quantity {
        "xp'" => "velocity xp'",
        "xp" => "position xp",
        "V" => "drive V",
        other => other,
    }
}

fn meaning(quantity: &str) -> String {
    let text = match quantity {
        "xp'" => "velocity of the proof mass, positive upwards",
        "xp" => "position of the proof mass",
        "V" => "drive voltage",
        other => other,
    };
    format!("Draw it against: {text}")
}
