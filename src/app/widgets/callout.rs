//! A remark beside a widget, drawn over what stands there: nothing moves because of it.

use eframe::egui::{Align2, Area, Frame, Id, Order, Rect, Ui, vec2};

use super::text::small;

/// Widest text [points].
const WIDTH: f32 = 280.0;

/// Says what is wrong with the widget at `beside`, on the side where there is room. `salt`
/// tells remarks apart. Nothing is said of a widget that is scrolled out of view.
pub fn error(ui: &Ui, salt: impl std::hash::Hash + std::fmt::Debug, beside: Rect, text: &str) {
    if !ui.is_rect_visible(beside) {
        return;
    }
    let on_the_right = beside.center().x > ui.ctx().content_rect().center().x;
    let (pivot, at) = if on_the_right {
        (Align2::RIGHT_TOP, beside.left_top() - vec2(8.0, 2.0))
    } else {
        (Align2::LEFT_TOP, beside.right_top() + vec2(8.0, -2.0))
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
                ui.set_max_width(WIDTH);
                ui.label(small(text).color(color));
            });
        });
}
