//! Notices over the window: information goes by itself, errors and remarks on a recording
//! stay until they are dismissed. Nothing else moves because of them.

use std::time::Duration;

use eframe::egui::{Align, Align2, Area, Frame, Id, Layout, Order, RichText, Ui, vec2};

use super::window::Shell;
use crate::app::dialogs::Target;
use crate::app::setup::command::Command;
use crate::app::setup::notice::{About, Notice};
use crate::app::setup::overlay::OverlayId;
use crate::app::theme;

/// Notices shown at once, the newest.
const SHOWN: usize = 4;
/// Width of a notice [points].
const WIDTH: f32 = 400.0;
/// Room for the status bar below [points].
const STATUS: f32 = 34.0;

/// What was clicked.
enum Clicked {
    Dismiss(usize),
    DismissAll,
    Import(OverlayId),
    Locate(OverlayId),
}

impl Shell {
    /// Draws the notices over the lower right corner.
    pub(super) fn toasts(&mut self, ui: &Ui) {
        let now = ui.input(|input| input.time);
        expire(&mut self.state.notices, now, ui);
        if self.state.notices.is_empty() {
            return;
        }
        let area = Area::new(Id::unique("notices"))
            .order(Order::Foreground)
            .anchor(Align2::RIGHT_BOTTOM, vec2(-10.0, -STATUS))
            .show(ui.ctx(), |ui| {
                ui.set_width(WIDTH);
                self.stack(ui)
            });
        if area.response.contains_pointer() {
            // What is being read stays.
            for notice in &mut self.state.notices {
                notice.since = None;
            }
        }
        match area.inner {
            None => {}
            Some(Clicked::Dismiss(i)) => {
                self.state.notices.remove(i);
            }
            Some(Clicked::DismissAll) => self.state.notices.clear(),
            Some(Clicked::Locate(id)) => self.dialogs.ask_file(Target::Lost(id)),
            Some(Clicked::Import(id)) => {
                self.state.selected = Some(id);
                self.state.ask(Command::ImportSettings);
            }
        }
    }

    fn stack(&self, ui: &mut Ui) -> Option<Clicked> {
        let mut clicked = None;
        let notices = &self.state.notices;
        let first = notices.len().saturating_sub(SHOWN);
        if notices.len() > 1 {
            ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
                if ui.button("Dismiss all").clicked() {
                    clicked = Some(Clicked::DismissAll);
                }
                if first > 0 {
                    ui.weak(format!("and {first} older"));
                }
            });
        }
        for (i, notice) in notices.iter().enumerate().skip(first) {
            let color = if notice.is_error {
                theme::error(ui.visuals().dark_mode)
            } else if notice.is_timed() {
                ui.visuals().text_color()
            } else {
                ui.visuals().warn_fg_color
            };
            let frame = Frame::popup(ui.style()).inner_margin(8);
            frame.stroke((1.0, color)).show(ui, |ui| {
                ui.set_width(WIDTH - 18.0);
                ui.label(RichText::new(&notice.text).color(color));
                ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
                    if ui.small_button("Dismiss").clicked() {
                        clicked = Some(Clicked::Dismiss(i));
                    }
                    let shown = |id| self.state.setup.overlays.iter().any(|o| o.id == id);
                    match notice.about {
                        Some(About::Recording(id))
                            if shown(id) && ui.small_button("Import settings...").clicked() =>
                        {
                            clicked = Some(Clicked::Import(id));
                        }
                        Some(About::Lost(id)) if ui.small_button("Locate...").clicked() => {
                            clicked = Some(Clicked::Locate(id));
                        }
                        _ => {}
                    }
                });
            });
        }
        clicked
    }
}

/// Takes away what has been shown long enough, and asks to be drawn when the next is due.
fn expire(notices: &mut Vec<Notice>, now: f64, ui: &Ui) {
    notices.retain_mut(|notice| {
        let Some(stays) = notice.seconds() else {
            return true;
        };
        let left = *notice.since.get_or_insert(now) + stays - now;
        if left > 0.0 {
            ui.ctx()
                .request_repaint_after(Duration::from_secs_f64(left + 0.01));
        }
        left > 0.0
    });
}
