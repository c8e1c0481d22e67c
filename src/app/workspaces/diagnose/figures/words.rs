//! TODO-doc

use eframe::egui::Ui;

use crate::app::widgets::text::small;

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

pub(crate) fn meaning(quantity: &str) -> String {
    let text = match quantity {
        "xp'" => "velocity of the proof mass, positive upwards",
        "xp" => "position of the proof mass",
        "V" => "drive voltage",
        other => other,
    };
    format!("Draw it against: {text}")
}
