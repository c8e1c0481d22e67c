//! The picker for the quantity on the horizontal axis, and the words for each quantity.

use eframe::egui::Ui;

use crate::app::widgets::text::small;

/// Buttons for the quantities that a figure can be plotted against. Returns the index of the
/// chosen one, or 0 if `chosen` is not among them.
pub fn quantity_picker(
    ui: &mut Ui,
    chosen: &mut Option<&'static str>,
    all: impl Iterator<Item = &'static str>,
) -> usize {
    let all: Vec<&'static str> = all.collect();
    let mut index = all.iter().position(|a| Some(*a) == *chosen).unwrap_or(0);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = eframe::egui::vec2(3.0, 2.0);
        ui.label(small("against"));
        for (i, quantity) in all.iter().enumerate() {
            let button = ui.selectable_label(index == i, small(axis_name(quantity)));
            if button.on_hover_text(quantity_help(quantity)).clicked() {
                *chosen = Some(quantity);
                index = i;
            }
        }
    });
    index
}

/// The name of a quantity on the axes.
pub fn axis_name(quantity: &'static str) -> &'static str {
    match quantity {
        "xp'" => "velocity xp'",
        "xp" => "position xp",
        "V" => "drive V",
        "t" => "time t",
        other => other,
    }
}

/// Explains the button of a quantity.
fn quantity_help(quantity: &str) -> String {
    let text = match quantity {
        "xp'" => "velocity of the proof mass, positive upwards",
        "xp" => "position of the proof mass",
        "V" => "drive voltage",
        "t" => "time in the recording",
        other => other,
    };
    format!("Plot against: {text}")
}
