//! The misfit in one line above the plots. It stays in view while a slider is dragged, whatever
//! panel is open and however small the window is.

use eframe::egui::{Label, RichText, Ui};

use crate::app::plots::frame::style::overlay_color;
use crate::app::setup::drive_choice::Mode;
use crate::app::simulation::snapshot::{OverlayComparison, Snapshot};
use crate::app::state::State;
use crate::app::widgets::text::name_of;
use crate::model::unit::{format_number, format_quantity};

/// Digits of a misfit.
const MISFIT_DIGITS: usize = 3;

/// Draws the line. It has a fixed height, so that the plots do not move.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    let snapshot = state.snapshot.clone();
    let total = snapshot.as_ref().and_then(|s| s.total_misfit());
    let dragging = ui.input(|input| input.pointer.any_down());
    let generation = snapshot.as_ref().map_or(0, |s| s.generation);
    state.misfit_history.follow(total, generation, dragging);
    let head = head(state, snapshot.as_deref(), total);
    ui.horizontal(|ui| {
        ui.add(Label::new(RichText::new(&head).strong()).truncate())
            .on_hover_text(
                "Root mean square of simulation minus recording over all recordings shown, in units of their noise. 1 is a perfect model. It is that of whole runs: one impact that comes a little late spoils all that follows. Between impacts each stretch starts where the readings are: the number of Diagnose's proof.",
            );
        let Some(snapshot) = snapshot else { return };
        if total.is_none() || snapshot.comparisons.len() < 2 {
            return;
        }
        for entry in &snapshot.comparisons {
            let Some(text) = of_one(entry) else { continue };
            let overlay = state.setup.overlays.iter().find(|o| o.id == entry.id);
            let color = overlay.map(|o| overlay_color(ui, o.color));
            let mut text = RichText::new(text);
            if let Some(color) = color {
                text = text.color(color);
            }
            ui.add(Label::new(text).truncate())
                .on_hover_text(hover(state, entry));
        }
    });
}

/// `misfit 1.02 x noise (better, was 5.3)`.
fn head(state: &State, snapshot: Option<&Snapshot>, total: Option<f64>) -> String {
    let Some(snapshot) = snapshot else {
        return "misfit: nothing simulated yet".to_owned();
    };
    if let Some(total) = total {
        let number = format_number(total, MISFIT_DIGITS);
        let history = state.misfit_history.text(total);
        let history = history.map_or(String::new(), |text| format!(" ({text})"));
        let stretches = snapshot
            .total_stretch_misfit()
            .map_or(String::new(), |total| {
                format!(", {} between impacts", format_number(total, MISFIT_DIGITS))
            });
        return format!("misfit {number} x noise{history}{stretches}");
    }
    // Without noise there is no unit but the length.
    let compared: Vec<String> = snapshot
        .comparisons
        .iter()
        .filter_map(|entry| {
            let rms = entry.comparison.as_ref().ok()?.rms;
            let name = name_of(&state.setup, entry.id);
            Some(format!("rms {} ({name})", format_quantity(rms, "m", 3)))
        })
        .collect();
    if !compared.is_empty() {
        return format!("misfit: {}", compared.join("; "));
    }
    let failed = snapshot.comparisons.iter().find_map(|entry| {
        let reason = entry.comparison.as_ref().err()?;
        Some(format!(
            "misfit: {}: {reason}",
            name_of(&state.setup, entry.id)
        ))
    });
    failed.unwrap_or_else(|| {
        if state.view.mode == Mode::Live && !state.setup.overlays.is_empty() {
            "misfit: recordings are compared in whole-span mode".to_owned()
        } else {
            "misfit: no recording is compared".to_owned()
        }
    })
}

/// The misfit of one recording, or that it has none.
fn of_one(entry: &OverlayComparison) -> Option<String> {
    match (entry.misfit(), &entry.comparison) {
        (Some(misfit), _) => Some(format_number(misfit, MISFIT_DIGITS)),
        (None, Ok(comparison)) => Some(format_quantity(comparison.rms, "m", 2)),
        (None, Err(_)) => Some("none".to_owned()),
    }
}

fn hover(state: &State, entry: &OverlayComparison) -> String {
    let name = name_of(&state.setup, entry.id);
    match &entry.comparison {
        Ok(comparison) => format!(
            "{name}: rms {}, drive: {}",
            format_quantity(comparison.rms, "m", 3),
            entry
                .drive_text
                .as_deref()
                .unwrap_or("that of the simulation")
        ),
        Err(reason) => format!("{name}: {reason}"),
    }
}
