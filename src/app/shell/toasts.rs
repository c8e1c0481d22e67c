//! Notices over the window. Information disappears by itself; errors and remarks on a
//! recording stay until they are dismissed. Notices move nothing else, and a click on one goes
//! to what is under it: only their buttons take clicks. They are shown over the lower edge of
//! the plots, beside the panels that they speak of.

use std::time::Duration;

use eframe::egui::{
    Align, Align2, Area, Context, Frame, Id, Label, LayerId, Layout, Order, Rect, RichText, Ui,
    vec2,
};

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
/// Height of the row of buttons in a notice \[points\].
const BUTTON_ROW_HEIGHT: f32 = 22.0;

/// A row of buttons: of the notice with this index, or of all of them.
type ButtonRow = (Option<usize>, Rect);

/// What was clicked.
enum Clicked {
    Dismiss(usize),
    DismissAll,
    Import(OverlayId),
    Locate(OverlayId),
    /// Remove a missing recording from the session.
    Forget(OverlayId),
}

/// Draws the notices over the middle of the lower edge.
pub(super) fn show(services: &mut Services, ui: &Ui) {
    let now = ui.input(|input| input.time);
    expire(&mut services.state.notices, now, ui);
    if services.state.notices.is_empty() {
        return;
    }
    // A dialog asks for something: nothing may lie over it.
    let order = if services.dialogs.is_open() {
        Order::Middle
    } else {
        Order::Foreground
    };
    let width = NOTICE_WIDTH.min(ui.ctx().content_rect().width() - 20.0);
    let area = Area::new(Id::unique("notices"))
        .order(order)
        .interactable(false)
        .anchor(Align2::CENTER_BOTTOM, vec2(0.0, -STATUS_BAR_HEIGHT))
        .show(ui.ctx(), |ui| {
            ui.set_width(width);
            texts(services, ui, width)
        });
    let pointer = ui.input(|input| input.pointer.hover_pos());
    if pointer.is_some_and(|pos| area.response.rect.contains(pos)) {
        // A notice under the pointer is being read: it stays.
        for notice in &mut services.state.notices {
            notice.since = None;
        }
    }
    let mut layers = vec![area.response.layer_id];
    let clicked = area.inner.into_iter().fold(None, |clicked, row| {
        let (own, layer) = buttons(services, ui, row, order);
        layers.push(layer);
        own.or(clicked)
    });
    if order == Order::Middle {
        lay_below(ui.ctx(), &layers);
    }
    match clicked {
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

/// Draws the notices without their buttons. Returns where the buttons belong.
fn texts(services: &Services, ui: &mut Ui, width: f32) -> Vec<ButtonRow> {
    let notices = &services.state.notices;
    let first = notices.len().saturating_sub(MAX_SHOWN);
    let row = |ui: &mut Ui, width| ui.allocate_space(vec2(width, BUTTON_ROW_HEIGHT)).1;
    let mut rows = Vec::new();
    if notices.len() > 1 {
        rows.push((None, row(ui, width)));
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
            ui.set_width(width - 18.0);
            let text = RichText::new(&notice.text).color(color);
            ui.add(Label::new(text).wrap().selectable(false));
            rows.push((Some(i), row(ui, width - 18.0)));
        });
    }
    rows
}

/// Lays `own` layers below all others of their order.
fn lay_below(context: &Context, own: &[LayerId]) {
    let is_other = |layer: &LayerId| layer.order == Order::Middle && !own.contains(layer);
    let others: Vec<LayerId> =
        context.memory(|memory| memory.layer_ids().filter(is_other).collect());
    for layer in others {
        context.move_to_top(layer);
    }
}

/// Draws one row of buttons, over its place in the notice. Returns which one was clicked, and the layer.
fn buttons(
    services: &Services,
    ui: &Ui,
    (of, place): ButtonRow,
    order: Order,
) -> (Option<Clicked>, LayerId) {
    let mut clicked = None;
    // By what it says, not by its place in the list: when an older notice goes while a button is
    // pressed, the button stays the same.
    let notice = of.and_then(|i| services.state.notices.get(i));
    let said = notice.map(|notice| (notice.is_error, notice.about, &notice.text));
    let area = Area::new(Id::unique(("notice buttons", said)))
        .order(order)
        .pivot(Align2::RIGHT_TOP)
        .fixed_pos(place.right_top())
        .show(ui.ctx(), |ui| {
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| match of {
                Some(i) => clicked = buttons_of(services, ui, i),
                None => {
                    let older = services.state.notices.len().saturating_sub(MAX_SHOWN);
                    if older > 0 {
                        ui.weak(format!("and {older} older"));
                    }
                    if ui.button("Dismiss all").clicked() {
                        clicked = Some(Clicked::DismissAll);
                    }
                }
            });
        });
    (clicked, area.response.layer_id)
}

fn buttons_of(services: &Services, ui: &mut Ui, i: usize) -> Option<Clicked> {
    let notice = services.state.notices.get(i)?;
    let mut clicked = None;
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
    if ui.small_button("Dismiss").clicked() {
        clicked = Some(Clicked::Dismiss(i));
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
