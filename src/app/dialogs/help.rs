//! The list of keys, made from the commands, and of mouse gestures.

use eframe::egui::{Grid, ScrollArea, Ui, Window};

use super::escape;
use crate::app::setup::command::Command;

/// Mouse and key gestures.
const GESTURES: [(&str, &str); 22] = [
    ("drag in a plot", "move through time"),
    ("wheel in a plot", "zoom in time around the pointer"),
    ("double-click in a plot", "show the whole span"),
    (
        "wheel on the scale of a plot, or Alt + wheel in it",
        "zoom in values around the pointer",
    ),
    ("drag on the scale of a plot", "move through values"),
    ("double-click on the scale of a plot", "show all values"),
    (
        "right-click on the scale of a plot",
        "keep this scale, or let it follow the curve",
    ),
    (
        "double-click on the name of a panel",
        "show this recording alone, or all (small multiples)",
    ),
    (
        "click on the name of a curve above the plots",
        "show or hide the curve",
    ),
    ("click in a plot", "set the cursor"),
    (
        "Shift + click in a plot",
        "set the second cursor, for differences",
    ),
    ("Escape", "clear the cursors"),
    (
        "click on a residual strip",
        "show that part of the recording (Diagnose)",
    ),
    (
        "drag on a residual strip",
        "show the selected part of the recording (Diagnose)",
    ),
    ("double-click a slider", "reset it to the preset's value"),
    ("Shift + drag a slider", "move it finely"),
    ("arrow keys on a slider", "move it step by step"),
    ("1 to 6", "choose an answer (Learn)"),
    (
        "arrow keys",
        "move the mark, or a point of the curve (Learn)",
    ),
    (
        ". and ,",
        "the next point of the curve, the one before (Learn)",
    ),
    ("Enter", "commit the prediction (Learn)"),
    (
        "drag in the plot",
        "draw the predicted curve, move the mark (Learn)",
    ),
];

/// Draws the list while `open`.
pub fn show(ui: &mut Ui, open: &mut bool) {
    if *open && escape(ui) {
        *open = false;
    }
    Window::new("Keyboard and mouse")
        .open(open)
        .default_size([800.0, 600.0])
        .default_pos([300.0, 60.0])
        .show(ui, |ui| {
            ScrollArea::both().max_height(560.0).show(ui, |ui| {
                Grid::new("keys")
                    .num_columns(3)
                    .striped(true)
                    .show(ui, |ui| {
                        for command in Command::all() {
                            let Some(keys) = command.keys() else {
                                continue;
                            };
                            let (name, line) = command.text();
                            ui.monospace(keys);
                            ui.label(name);
                            ui.weak(line);
                            ui.end_row();
                        }
                        for (gesture, line) in GESTURES {
                            ui.monospace("");
                            ui.label(gesture);
                            ui.weak(line);
                            ui.end_row();
                        }
                    });
            });
        });
}
