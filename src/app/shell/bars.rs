//! Menu bar, hint and status bar of the window, and files dropped on it.

use std::path::PathBuf;

use eframe::egui;
use eframe::egui::{Align, Layout, Panel, Ui};

use super::job_list;
use crate::app::actions::menus;
use crate::app::files::built_in;
use crate::app::files::recent::absolute;
use crate::app::plots::frame::layout_note::note;
use crate::app::services::Services;
use crate::app::setup::command::Command;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::simulation::snapshot::LiveState;
use crate::app::theme;
use crate::model::unit::{counted, format_quantity};

/// Draws menus, workspace tabs and the hint of the first start.
pub(super) fn menu_bar(services: &mut Services, ui: &mut Ui) {
    Panel::top("menu").show(ui, |ui| {
        egui::MenuBar::new().ui(ui, |ui| {
            menus::menus(services, ui);
            ui.separator();
            for workspace in WorkspaceId::ALL {
                let is_shown = services.state.view.workspace == workspace.name();
                let tab = ui.selectable_label(is_shown, workspace.title());
                let name = format!("tab {}", workspace.name());
                note(ui.ctx(), &name, tab.rect);
                if tab.on_hover_text(workspace.help()).clicked() {
                    services.state.ask(Command::Workspace(workspace));
                }
            }
        });
    });
    // The hint is about what the first workspace shows.
    let first = WorkspaceId::ALL[0].name();
    if services.shows_hint && services.state.view.workspace == first {
        Panel::top("hint").show(ui, |ui| hint(services, ui));
    }
}

fn hint(services: &mut Services, ui: &mut Ui) {
    // The button comes first, so that a narrow window wraps the lines instead of cutting it off.
    ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
        if ui.button("Got it").clicked() {
            services.shows_hint = false;
        }
        ui.with_layout(Layout::top_down(Align::Min), |ui| {
            for line in built_in::first_start_hint() {
                ui.add(egui::Label::new(line).wrap());
            }
        });
    });
}

/// Width below which the status bar leaves out the figures of the run while it shows something
/// more urgent \[points\].
const NARROW_STATUS_WIDTH: f32 = 900.0;

/// Draws the status bar: what the simulation took, files and jobs in progress, and a refused
/// value.
pub(super) fn status_bar(services: &Services, ui: &mut Ui) {
    Panel::bottom("status").show(ui, |ui| {
        let is_narrow = ui.available_width() < NARROW_STATUS_WIDTH;
        ui.horizontal(|ui| {
            let jobs = job_list::show(services, ui);
            let refusal = services.state.refusal.as_ref();
            if !is_narrow || (jobs == 0 && refusal.is_none()) {
                if jobs > 0 {
                    ui.separator();
                }
                run_figures(services, ui);
            }
            if services.files.pending() > 0 {
                file_progress(services, ui);
            }
            if let Some(refusal) = refusal {
                ui.separator();
                let text = format!("not simulated: {}", refusal.message);
                let color = theme::error(ui.visuals().dark_mode);
                let label = egui::Label::new(egui::RichText::new(&text).color(color)).truncate();
                ui.add(label).on_hover_text(text);
            }
        });
    });
}

/// What the simulation took, or the speed of a live run.
fn run_figures(services: &Services, ui: &mut Ui) {
    let Some(snapshot) = &services.state.snapshot else {
        ui.weak("computing");
        return;
    };
    let trace = &snapshot.trace;
    if let Some(live) = snapshot.live {
        ui.weak(live_speed(live));
    } else {
        ui.weak(format!(
            "{}, {}, {} in {:.1} ms",
            counted(trace.len(), "sample"),
            counted(trace.steps as usize, "step"),
            counted(trace.events.len(), "event"),
            snapshot.cost.as_secs_f64() * 1e3
        ));
    }
}

fn file_progress(services: &Services, ui: &mut Ui) {
    ui.separator();
    ui.spinner();
    let working = services.files.working();
    for work in &working {
        let name = work.path.file_name().unwrap_or_default();
        let mut text = format!("{} {}", work.what, name.to_string_lossy());
        if work.fraction > 0.0 {
            text += &format!(" {:.0} %", 100.0 * work.fraction);
        }
        ui.label(text);
    }
    // Saving, aligning and the like cannot be stopped.
    if working.iter().any(|work| work.can_cancel) && ui.small_button("Cancel").clicked() {
        services.files.cancel();
    }
}

/// Opens files dropped on the window, and invites to drop while some hover over it.
pub(super) fn dropped_files(services: &mut Services, ui: &mut Ui) {
    let (dropped, hovering) = ui.input(|input| {
        let paths: Vec<PathBuf> = input
            .raw
            .dropped_files
            .iter()
            .map(|file| file.path().to_path_buf())
            .collect();
        (paths, !input.raw.hovered_files.is_empty())
    });
    for path in dropped {
        services.requested_files.push(absolute(&path));
        services.files.open(path);
    }
    if hovering {
        let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop"));
        let rect = ui.ctx().content_rect();
        let painter = ui.ctx().layer_painter(layer);
        painter.rect_filled(rect, 0.0, egui::Color32::from_black_alpha(160));
        painter.text(
            rect.center(),
            egui::Align2::CENTER_CENTER,
            "Drop recordings, a preset, a session or a lesson",
            egui::FontId::proportional(26.0),
            egui::Color32::WHITE,
        );
    }
}

/// The speed that a live run reaches.
fn live_speed(live: LiveState) -> String {
    if live.paused {
        "live: paused".to_owned()
    } else if live.speed > 0.0 {
        let takes = format_quantity(1e-3 / live.speed, "s", 2);
        format!("live: 1 ms of device time takes {takes}")
    } else {
        "live: starting".to_owned()
    }
}
