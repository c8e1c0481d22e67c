//! Notices over the window. Information disappears by itself; errors and remarks on a
//! recording stay until they are dismissed. Notices move nothing else.

use std::time::Duration;

use eframe::egui::{Align, Align2, Area, Frame, Id, Layout, Order, RichText, Ui, vec2};

use crate::app::dialogs::Target;
use crate::app::services::Services;
use crate::app::setup::command::Command;
use crate::app::setup::notice::{About, Notice};
use crate::app::setup::overlay::OverlayId;
use crate::app::theme;

/// How many notices are shown at once; older ones are only counted.
const MAX_SHOWN: usize = 4;
/// Width of a notice \[points\].
const NOTICE_WIDTH: f32 = 400.0;
/// Height left free for the status bar below \[points\].
const STATUS_BAR_HEIGHT: f32 = 34.0;

/// What was clicked.
enum Clicked {
    Dismiss(usize),
    DismissAll,
    Import(OverlayId),
    Locate(OverlayId),
    /// Remove a missing recording from the session.
    Forget(OverlayId),
}

/// Draws the notices over the lower right corner.
pub(super) fn show(services: &mut Services, ui: &Ui) {
    let now = ui.input(|input| input.time);
    expire(&mut services.state.notices, now, ui);
    if services.state.notices.is_empty() {
        return;
    }
    let area = Area::new(Id::unique("notices"))
        .order(Order::Foreground)
        .anchor(Align2::RIGHT_BOTTOM, vec2(-10.0, -STATUS_BAR_HEIGHT))
        .show(ui.ctx(), |ui| {
            ui.set_width(NOTICE_WIDTH);
            stack(services, ui)
        });
    if area.response.contains_pointer() {
        // A notice under the pointer is being read: it stays.
        for notice in &mut services.state.notices {
            notice.since = None;
        }
    }
    match area.inner {
        None => {}
        Some(Clicked::Dismiss(i)) => {
            services.state.notices.remove(i);
        }
        Some(Clicked::DismissAll) => services.state.notices.clear(),
        Some(Clicked::Locate(id)) => services.dialogs.ask_file(Target::Lost(id)),
        Some(Clicked::Forget(id)) => services.forget_missing(|entry| entry.id == id),
        Some(Clicked::Import(id)) => {
            services.state.selected = Some(id);
            services.state.ask(Command::ImportSettings);
        }
    }
}

fn stack(services: &Services, ui: &mut Ui) -> Option<Clicked> {
    let mut clicked = None;
    let notices = &services.state.notices;
    let first = notices.len().saturating_sub(MAX_SHOWN);
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
            ui.set_width(NOTICE_WIDTH - 18.0);
            ui.label(RichText::new(&notice.text).color(color));
            ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
                if ui.small_button("Dismiss").clicked() {
                    clicked = Some(Clicked::Dismiss(i));
                }
                let shown = |id| services.state.setup.overlays.iter().any(|o| o.id == id);
                match notice.about {
                    Some(About::Recording(id))
                        if shown(id) && ui.small_button("Import settings...").clicked() =>
                    {
                        clicked = Some(Clicked::Import(id));
                    }
                    Some(About::Lost(id)) => {
                        if ui.small_button("Locate...").clicked() {
                            clicked = Some(Clicked::Locate(id));
                        }
                        if ui.small_button("Remove from session").clicked() {
                            clicked = Some(Clicked::Forget(id));
                        }
                    }
                    _ => {}
                }
            });
        });
    }
    clicked
}
/// Removes notices that were shown long enough, and requests a frame for the next removal.
fn expire(notices: &mut Vec<Notice>, now: f64, ui: &Ui) {
    notices.retain_mut(|notice| {
        let Some(stays) = notice.seconds() else {
            return true;
        };
        let remaining = *notice.since.get_or_insert(now) + stays - now;
        if remaining > 0.0 {
            ui.ctx()
                .request_repaint_after(Duration::from_secs_f64(remaining + 0.01));
        }
        remaining > 0.0
    });
}
