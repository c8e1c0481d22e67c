//! Buttons for the role of a recording.

use eframe::egui::Ui;

use super::text::small;
use crate::app::setup::overlay::Role;

/// Roles of a recording: button and explanation.
const ROLE_CHOICES: [(Role, &str, &str); 3] = [
    (Role::Train, "fit", "The model is fitted to it"),
    (
        Role::HeldOut,
        "hold out",
        "Not used for fitting; the result is checked on it",
    ),
    (Role::Unused, "ignore", "Not used"),
];

/// Draws the buttons for the recording `name`, side by side; returns another role if one was
/// chosen.
pub fn role_choice(ui: &mut Ui, name: &str, role: Role) -> Option<Role> {
    let mut chosen = role;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.spacing_mut().button_padding.x = 5.0;
        for (choice, text, help) in ROLE_CHOICES {
            ui.selectable_value(&mut chosen, choice, small(text))
                .on_hover_text(format!("{name}: {help}"));
        }
    });
    (chosen != role).then_some(chosen)
}
