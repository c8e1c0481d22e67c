//! What the window shows at a time: one workspace a folder, and a line in the list.

use eframe::egui::Ui;

use super::state::State;

pub mod diagnose;
pub mod tune;

/// A workspace.
pub struct Workspace {
    /// Its name, as on the command line.
    pub name: &'static str,
    /// The title of its tab.
    pub title: &'static str,
    /// What it is for, in a line.
    pub help: &'static str,
    /// Draws it.
    pub show: fn(&mut Ui, &mut State),
}

/// All workspaces, in the order of the tabs.
pub const ALL: [Workspace; 2] = [
    Workspace {
        name: "tune",
        title: "Tune",
        help: "Sliders, curves and recordings: simulate, compare, fit",
        show: tune::show,
    },
    Workspace {
        name: diagnose::NAME,
        title: "Diagnose",
        help: "What the model leaves out, from recordings, with the proof",
        show: diagnose::show,
    },
];

/// Their names.
pub const NAMES: [&str; ALL.len()] = names();

const fn names() -> [&'static str; ALL.len()] {
    let mut names = [""; ALL.len()];
    let mut i = 0;
    while i < ALL.len() {
        names[i] = ALL[i].name;
        i += 1;
    }
    names
}

/// Draws the workspace that is in view; the first if there is none of its name.
pub fn show(ui: &mut Ui, state: &mut State) {
    let [first, ..] = &ALL;
    let workspace = ALL.iter().find(|w| w.name == state.view.workspace);
    (workspace.unwrap_or(first).show)(ui, state);
}
