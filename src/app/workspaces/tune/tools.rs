//! The tools of the workspace: drive editor, fit, identification, sensitivity, Table A.1, kept curves.
//! They dock between the plots and the readouts, so that they cover nothing that they change. Each
//! keeps its own width. Several share the place as tabs. In a window without room for both, the
//! readouts are a tab as well.

use eframe::egui::{Align, Id, Layout, Panel, ScrollArea, Ui};

use super::drive::editor;
use super::drive::place::Place;
use super::{fit, kept_curves, readouts, recordings, sensitivity, table_a1};
use crate::app::state::State;
use crate::app::widgets::icon::{Icon, icon_button};

/// Least width that is left for the plots \[points\].
const MIN_PLOT_WIDTH: f32 = 300.0;
/// Width of the readouts, before a person changes it, and their limits \[points\].
const READOUT_WIDTH: f32 = 300.0;
const READOUT_WIDTHS: (f32, f32) = (250.0, 480.0);
/// Least width of a tool \[points\].
const MIN_TOOL_WIDTH: f32 = 260.0;

/// What can be docked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tool {
    Drive,
    Fit,
    Identification,
    Sensitivity,
    Table,
    Kept,
    /// Recordings and readouts, in a window without room for a panel of their own.
    Readouts,
}

impl Tool {
    const ALL: [Self; 7] = [
        Self::Readouts,
        Self::Drive,
        Self::Fit,
        Self::Identification,
        Self::Sensitivity,
        Self::Table,
        Self::Kept,
    ];

    /// Title of its tab.
    fn title(self) -> &'static str {
        match self {
            Self::Drive => "Drive editor",
            Self::Fit => "Fit",
            Self::Identification => "Identification",
            Self::Sensitivity => "Sensitivity",
            Self::Table => "Table A.1",
            Self::Kept => "Kept curves",
            Self::Readouts => "Recordings",
        }
    }

    /// Width before a person changes it \[points\].
    fn usual_width(self) -> f32 {
        match self {
            Self::Readouts => READOUT_WIDTH,
            Self::Drive => 360.0,
            Self::Fit => 430.0,
            Self::Identification => 470.0,
            Self::Sensitivity => 420.0,
            Self::Table => 640.0,
            Self::Kept => 620.0,
        }
    }

    /// Whether it is open.
    fn open(self, state: &mut State) -> &mut bool {
        match self {
            Self::Drive => &mut state.drive_editor_open,
            Self::Fit => &mut state.fitting.open,
            Self::Identification => &mut state.identification.open,
            Self::Sensitivity => &mut state.sensing.open,
            Self::Table => &mut state.validation_open,
            Self::Kept => &mut state.kept_open,
            Self::Readouts => &mut state.view.side_panel,
        }
    }

    fn content(self, ui: &mut Ui, state: &mut State) {
        match self {
            Self::Readouts => return side_panel(ui, state),
            Self::Table => return table_a1::panel::show(ui, state),
            Self::Drive | Self::Fit | Self::Identification | Self::Sensitivity | Self::Kept => {}
        }
        // In both directions: content wider than the panel would push it out of the window, and
        // the plots under it.
        ScrollArea::both()
            .id_salt(("tool", self.title()))
            .auto_shrink([false, false])
            .show(ui, |ui| match self {
                Self::Drive => editor::show(ui, state, Place::Window),
                Self::Fit => fit::show(ui, state),
                Self::Identification => fit::steps::show(ui, state),
                Self::Sensitivity => sensitivity::show(ui, state),
                Self::Kept => kept_curves::show(ui, state),
                Self::Table | Self::Readouts => {}
            });
    }
}

/// The tools that were open in the last frame, and the one in front.
#[derive(Debug, Clone, Default)]
struct Docked {
    open: Vec<Tool>,
    front: Option<Tool>,
}

/// Draws the readouts and the open tools on the right.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    let room = ui.available_width();
    let is_open = |tool: Tool, state: &mut State| *tool.open(state);
    let mut open: Vec<Tool> = Tool::ALL
        .into_iter()
        .filter(|&tool| tool != Tool::Readouts && is_open(tool, state))
        .collect();
    let widest = open.iter().map(|tool| tool.usual_width());
    let widest = widest.fold(0.0, f32::max);
    let has_room = room >= widest + READOUT_WIDTH + MIN_PLOT_WIDTH;
    if open.is_empty() || has_room {
        readout_panel(ui, state, room);
    } else if state.view.side_panel {
        open.insert(0, Tool::Readouts);
    }
    let key = Id::unique("docked tools");
    let before: Docked = ui.data(|data| data.get_temp(key)).unwrap_or_default();
    // The one opened last is in front, else the one that was.
    let opened = open
        .iter()
        .rev()
        .find(|&tool| !before.open.contains(tool) && *tool != Tool::Readouts);
    let mut front = opened
        .copied()
        .or(before.front.filter(|tool| open.contains(tool)))
        .or(open.last().copied());
    if let Some(tool) = front {
        let most = (ui.available_width() - MIN_PLOT_WIDTH).max(MIN_TOOL_WIDTH);
        Panel::right(("tool", tool.title()))
            // The plots, which the tool is for, get at least as much.
            .default_size(tool.usual_width().min(0.5 * ui.available_width()).min(most))
            .size_range(MIN_TOOL_WIDTH.min(most)..=most)
            .show(ui, |ui| {
                tabs(ui, state, &open, &mut front);
                ui.separator();
                tool.content(ui, state);
            });
    }
    ui.data_mut(|data| data.insert_temp(key, Docked { open, front }));
}

/// The panel of recordings and readouts.
fn readout_panel(ui: &mut Ui, state: &mut State, room: f32) {
    let (least, most) = READOUT_WIDTHS;
    let most = (room - MIN_PLOT_WIDTH).clamp(least, most);
    let mut is_open = state.view.side_panel;
    Panel::right("tune readouts")
        .default_size(READOUT_WIDTH.min(most))
        .size_range(least..=most)
        .show_collapsible(ui, &mut is_open, |ui| side_panel(ui, state));
    state.view.side_panel = is_open;
}

/// One tab for each open tool, and the button that closes the one in front.
fn tabs(ui: &mut Ui, state: &mut State, open: &[Tool], front: &mut Option<Tool>) {
    // The button is placed first, so that a narrow panel wraps the tabs instead of cutting it off.
    ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
        if let Some(tool) = *front {
            let label = format!("close {}", tool.title());
            if icon_button(ui, Icon::Remove, &label).clicked() {
                *tool.open(state) = false;
            }
        }
        let wrapped = Layout::left_to_right(Align::Min).with_main_wrap(true);
        ui.with_layout(wrapped, |ui| {
            for &tool in open {
                let tab = ui.selectable_label(*front == Some(tool), tool.title());
                if tab.clicked() {
                    *front = Some(tool);
                }
            }
        });
    });
}

/// Recordings, readouts and the current case of Table A.1.
fn side_panel(ui: &mut Ui, state: &mut State) {
    ScrollArea::vertical()
        .id_salt("side")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            ui.set_max_width(ui.available_width() - 6.0);
            readouts::section(ui, "Recordings", |ui| recordings::show(ui, state));
            readouts::show(ui, state);
            if state.setup.preset.model.has_ground {
                readouts::section(ui, "Table A.1", |ui| table_a1::case_picker::show(ui, state));
            }
            ui.add_space(12.0);
        });
}
