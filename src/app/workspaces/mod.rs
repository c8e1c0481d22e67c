//! What the window shows at a time: one workspace a folder, and a line in the list.

use eframe::egui::Ui;

use super::state::State;

pub mod tune;

/// Names of the workspaces, as on the command line, in the order of the tabs.
pub const NAMES: [&str; 1] = ["tune"];

/// Title of a workspace's tab.
pub fn title(name: &str) -> &'static str {
    debug_assert_eq!(name, NAMES[0]);
    "Tune"
}

/// Draws the workspace of that name.
pub fn show(name: &str, ui: &mut Ui, state: &mut State) {
    // Tune is the only one so far; a further one is a further arm.
    debug_assert_eq!(name, NAMES[0]);
    tune::show(ui, state);
}
