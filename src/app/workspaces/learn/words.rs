//! How the texts of a step look.

use eframe::egui::{Label, RichText, Ui};

use crate::app::theme;
use crate::learn::prediction::Scored;

/// Size of the text of a lesson \[points\].
pub(super) const TEXT_SIZE: f32 = 15.0;

/// A paragraph of a lesson.
pub(super) fn paragraphs(ui: &mut Ui, text: &str) {
    for paragraph in text.split("\n\n").map(str::trim).filter(|p| !p.is_empty()) {
        ui.add(Label::new(RichText::new(paragraph).size(TEXT_SIZE)).wrap());
        ui.add_space(4.0);
    }
}

/// What is asked.
pub(super) fn strong(ui: &mut Ui, text: &str) {
    ui.add(Label::new(RichText::new(text).size(TEXT_SIZE).strong()).wrap());
    ui.add_space(4.0);
}

/// A remark on how it is done.
pub(super) fn hint(ui: &mut Ui, text: &str) {
    ui.add_space(2.0);
    ui.add(Label::new(RichText::new(text).size(12.5).weak()).wrap());
}

/// How near a prediction came.
pub(super) fn verdict(ui: &mut Ui, scored: &Scored) {
    let dark = ui.visuals().dark_mode;
    let (word, color) = match scored.stars() {
        3 => ("Right.", theme::good(dark)),
        2 => ("Near.", theme::good(dark)),
        1 => ("Not far.", theme::warning(dark)),
        _ => ("Not this time.", theme::warning(dark)),
    };
    let points = format!("{word} {} of 3 points.", scored.stars());
    ui.add(Label::new(RichText::new(points).size(TEXT_SIZE).strong().color(color)).wrap());
    if !scored.difference.is_empty() {
        let text = format!(
            "You: {}. Simulated: {}. Difference: {}.",
            scored.predicted, scored.simulated, scored.difference
        );
        ui.add(Label::new(RichText::new(text).size(13.5)).wrap());
    }
}
