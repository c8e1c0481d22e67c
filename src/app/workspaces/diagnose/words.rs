//! TODO-doc

use eframe::egui::{RichText, ScrollArea, Ui};

/// What a step will show once there is an answer.
pub(crate) fn promise(ui: &mut Ui, text: &str) {
    ui.add_space(4.0);
    ui.weak(text);
}

/// The rest of a column, scrolled where it is longer than the room.
pub(crate) fn scrolled(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ScrollArea::vertical()
        .id_salt(name)
        .auto_shrink([false, false])
        .show(ui, |ui| {
            // The bar must not lie over numbers.
            ui.set_max_width(ui.available_width() - 8.0);
            content(ui);
        });
}

/// The title of a part of a step.
pub(crate) fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).strong());
}
