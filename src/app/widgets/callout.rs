//! A remark next to a widget. It is drawn over other widgets, so that nothing moves.

use eframe::egui::{Align2, Area, Frame, Id, Order, Rect, Ui, vec2};

use super::text::small;

/// Greatest width of the text \[points\].
const MAX_TEXT_WIDTH: f32 = 280.0;

/// Says what is wrong with the widget at `widget`, on the side with more room. `salt`
/// distinguishes the remarks. A widget that is scrolled out of view gets none.
pub fn error(ui: &Ui, salt: impl std::hash::Hash + std::fmt::Debug, widget: Rect, text: &str) {
    if !ui.is_rect_visible(widget) {
        return;
    }
    let on_the_right = widget.center().x > ui.ctx().content_rect().center().x;
    let (pivot, at) = if on_the_right {
        (Align2::RIGHT_TOP, widget.left_top() - vec2(8.0, 2.0))
    } else {
        (Align2::LEFT_TOP, widget.right_top() + vec2(8.0, -2.0))
    };
    let color = super::text::error_color(ui);
    Area::new(Id::unique(("callout", salt)))
        .order(Order::Foreground)
        .interactable(false)
        .pivot(pivot)
        .fixed_pos(at)
        .show(ui.ctx(), |ui| {
            let frame = Frame::popup(ui.style()).inner_margin(6);
            frame.stroke((1.0, color)).show(ui, |ui| {
                ui.set_max_width(MAX_TEXT_WIDTH);
                ui.label(small(text).color(color));
            });
        });
}
