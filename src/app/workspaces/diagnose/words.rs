//! Parts that the steps share: placeholder text, scrolled columns, headings, and the words
//! for the role of a recording.

use eframe::egui::{ScrollArea, Ui};

use crate::diagnose::Diagnosis;

/// Says what a step will show once there is an answer.
pub(crate) fn placeholder(ui: &mut Ui, text: &str) {
    ui.add_space(4.0);
    ui.weak(text);
}

/// The rest of a column, with a scroll bar if it is too long.
pub(crate) fn scrolled(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ScrollArea::vertical()
        .id_salt(name)
        .auto_shrink([false, false])
        .show(ui, |ui| {
            // Room for the scroll bar, which would cover numbers.
            ui.set_max_width(ui.available_width() - 8.0);
            content(ui);
        });
}

/// How a recording is used, in a word or two.
pub(crate) fn role_text(held_out: bool) -> &'static str {
    if held_out { "held out" } else { "fitted" }
}

/// Name of the curves of the model that was found.
pub(crate) fn after_text(d: &Diagnosis) -> &'static str {
    if d.named.len() > 1 {
        "with the new effects"
    } else {
        "with the new effect"
    }
}
