//! The misfit in one line above the plots. It stays in view while a slider is dragged, whatever
//! panel is open and however small the window is.

use eframe::egui::{Label, RichText, Ui};

use super::readouts::noise_of;
use crate::app::state::State;
use crate::app::widgets::text::name_of;
use crate::model::unit::{format_number, format_quantity};

/// Draws the line. It has a fixed height, so that the plots do not move.
pub(super) fn show(ui: &mut Ui, state: &State) {
    let text = text(ui, state);
    let line = Label::new(RichText::new(&text).strong()).truncate();
    ui.add(line).on_hover_text(text);
}

/// Misfit of each recording: `misfit: rms 313 nm, 16 x noise (synthetic recording)`.
fn text(ui: &Ui, state: &State) -> String {
    let Some(snapshot) = &state.snapshot else {
        return "misfit: nothing simulated yet".to_owned();
    };
    let mut parts = Vec::new();
    for entry in &snapshot.comparisons {
        let Ok(comparison) = &entry.comparison else {
            continue;
        };
        let rms = format_quantity(comparison.rms, "m", 3);
        let noise = match noise_of(ui, state, entry) {
            Some(noise) => format!(", {} x noise", format_number(comparison.rms / noise, 2)),
            None => String::new(),
        };
        parts.push(format!(
            "rms {rms}{noise} ({})",
            name_of(&state.setup, entry.id)
        ));
    }
    if parts.is_empty() {
        "misfit: no recording is compared".to_owned()
    } else {
        format!("misfit: {}", parts.join("; "))
    }
}
