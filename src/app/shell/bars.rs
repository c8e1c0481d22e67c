//! Menu bar, hint and status bar of the window; what is dropped on it.

use std::path::PathBuf;

use eframe::egui;
use eframe::egui::{Panel, Ui};

use super::window::Shell;
use crate::app::actions::run;
use crate::app::files::built_in;
use crate::app::files::open::absolute;
use crate::app::setup::command::Command;
use crate::app::simulation::snapshot::LiveState;
use crate::app::{theme, workspaces};
use crate::model::unit::format_quantity;

impl Shell {
    /// Menus, workspace tabs and the first start's hint.
    pub(super) fn top(&mut self, ui: &mut Ui) {
        Panel::top("menu").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                run::menus(self, ui);
                ui.separator();
                for workspace in &workspaces::ALL {
                    let here = self.state.view.workspace == workspace.name;
                    let tab = ui.selectable_label(here, workspace.title);
                    crate::app::plots::frame::layout_note::note(
                        ui.ctx(),
                        &format!("tab {}", workspace.name),
                        tab.rect,
                    );
                    if tab.on_hover_text(workspace.help).clicked() {
                        self.state.ask(Command::Workspace(workspace.name));
                    }
                }
            });
        });
        // It is about what is seen in the first workspace.
        if self.hint && self.state.view.workspace == workspaces::NAMES[0] {
            Panel::top("hint").show(ui, |ui| self.hint(ui));
        }
    }

    fn hint(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.vertical(|ui| {
                for line in built_in::HINT {
                    ui.label(line);
                }
            });
            if ui.button("Got it").clicked() {
                self.hint = false;
            }
        });
    }

    /// What the simulation cost, files in work, what is refused.
    pub(super) fn bottom(&self, ui: &mut Ui) {
        Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                let Some(snapshot) = &self.state.snapshot else {
                    ui.weak("computing");
                    return;
                };
                let trace = &snapshot.trace;
                if let Some(live) = snapshot.live {
                    ui.weak(live_speed(live));
                } else {
                    ui.weak(format!(
                        "{} samples, {} steps, {} events in {:.1} ms",
                        trace.len(),
                        trace.steps,
                        trace.events.len(),
                        snapshot.cost.as_secs_f64() * 1e3
                    ));
                }
                if self.files.pending() > 0 {
                    ui.separator();
                    ui.spinner();
                    for work in self.files.working() {
                        let name = work.path.file_name().unwrap_or_default();
                        let mut text = format!("{} {}", work.what, name.to_string_lossy());
                        if work.fraction > 0.0 {
                            text += &format!(" {:.0} %", 100.0 * work.fraction);
                        }
                        ui.label(text);
                    }
                    if ui.small_button("Cancel").clicked() {
                        self.files.cancel();
                    }
                }
                let running = self.state.diagnosing.running.as_ref();
                if let Some(progress) = running.and_then(|r| r.job.progress()) {
                    ui.separator();
                    ui.spinner();
                    ui.label(format!("diagnosing {:.0} %", 100.0 * progress.done));
                }
                if let Some(refusal) = &self.state.refusal {
                    ui.separator();
                    let color = theme::error(ui.visuals().dark_mode);
                    ui.colored_label(color, format!("not shown: {}", refusal.message));
                }
            });
        });
    }

    /// Opens what was dropped; says so while something hovers.
    pub(super) fn dropped(&mut self, ui: &mut Ui) {
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
            self.order.push(absolute(path.clone()));
            self.files.open(path);
        }
        if hovering {
            let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop"));
            let rect = ui.ctx().content_rect();
            let painter = ui.ctx().layer_painter(layer);
            painter.rect_filled(rect, 0.0, egui::Color32::from_black_alpha(160));
            painter.text(
                rect.center(),
                egui::Align2::CENTER_CENTER,
                "Drop recordings, a preset or a session",
                egui::FontId::proportional(26.0),
                egui::Color32::WHITE,
            );
        }
    }
}

/// How fast a live run really goes.
fn live_speed(live: LiveState) -> String {
    if live.paused {
        "live: paused".to_owned()
    } else if live.speed > 0.0 {
        let takes = format_quantity(1e-3 / live.speed, "s", 2);
        format!("live: 1 ms of the device takes {takes}")
    } else {
        "live: starting".to_owned()
    }
}
