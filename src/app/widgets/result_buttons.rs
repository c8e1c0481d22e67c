//! The buttons that apply or discard the result of a fit.

use eframe::egui::{Button, Ui};

/// The button that applies a result; disabled if it is of another device. Returns whether it
/// was pressed.
pub fn apply_button(ui: &mut Ui, is_of_this_device: bool) -> bool {
    ui.add_enabled(is_of_this_device, Button::new("Apply"))
        .on_hover_text("Set the sliders to these values (can be undone)")
        .on_disabled_hover_text("The open device is not the one that was fitted")
        .clicked()
}

/// The button that discards a result. Returns whether it was pressed.
pub fn discard_button(ui: &mut Ui) -> bool {
    ui.button("Discard")
        .on_hover_text("Forget this result; the sliders keep their values")
        .clicked()
}
