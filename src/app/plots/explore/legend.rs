//! What colours stand for: a bar with ticks for numbers, patches with names for categories.

use eframe::egui::{
    Align2, Color32, FontId, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use super::colors::scale_color;
use super::plane::PlaneAxis;
use crate::app::plots::frame::axes::ticks;
use crate::app::plots::frame::style;
use crate::model::unit::format_number;

/// Height of the bar of a scale \[points\].
const BAR_HEIGHT: f32 = 14.0;
/// Steps in which it is painted.
const BAR_STEPS: usize = 96;
/// Side of a patch \[points\].
const PATCH_SIZE: f32 = 11.0;

/// A colour scale, as wide as there is room: bar, ticks and quantity with unit.
pub fn scale(ui: &mut Ui, axis: &PlaneAxis) {
    let font = FontId::proportional(style::AXIS_TEXT);
    let size = vec2(ui.available_width(), BAR_HEIGHT + 36.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let spoken = format!("colour scale: {}", axis.label());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &spoken));
    let palette = style::palette(ui);
    let bar = Rect::from_min_size(rect.min + vec2(10.0, 0.0), vec2(size.x - 20.0, BAR_HEIGHT));
    let painter = ui.painter();
    for i in 0..BAR_STEPS {
        let x = |i: usize| bar.left() + bar.width() * i as f32 / BAR_STEPS as f32;
        let part = Rect::from_min_max(pos2(x(i), bar.top()), pos2(x(i + 1) + 0.5, bar.bottom()));
        let share = (i as f64 + 0.5) / BAR_STEPS as f64;
        painter.rect_filled(part, 0.0, scale_color(share));
    }
    painter.rect_stroke(
        bar,
        0.0,
        Stroke::new(1.0, palette.grid),
        StrokeKind::Outside,
    );
    let scale = axis.scale();
    let (low, high) = (scale.place(axis.range.0), scale.place(axis.range.1));
    let marks: Vec<(f64, String)> = if axis.is_logarithmic {
        decades(low, high)
    } else {
        ticks(low, high, f64::from(bar.width() / 60.0))
    };
    for (place, text) in marks {
        let share = ((place - low) / (high - low)) as f32;
        if !(-0.001..=1.001).contains(&share) {
            continue;
        }
        let x = bar.left() + share * bar.width();
        let stroke = Stroke::new(1.0, palette.text);
        painter.vline(x, bar.bottom()..=bar.bottom() + 3.0, stroke);
        let at = pos2(x, bar.bottom() + 4.0);
        painter.text(at, Align2::CENTER_TOP, text, font.clone(), palette.text);
    }
    let at = pos2(bar.center().x, bar.bottom() + 19.0);
    painter.text(at, Align2::CENTER_TOP, axis.label(), font, palette.text);
}

/// Whole decades, thinned to at most six; both ends if there is none.
fn decades(low: f64, high: f64) -> Vec<(f64, String)> {
    let text = |place: f64| format_number(10f64.powf(place), 2);
    let (first, last) = (low.ceil() as i32, high.floor() as i32);
    let step = ((last - first) / 5).max(1);
    let own: Vec<i32> = (first..=last).step_by(step as usize).collect();
    if own.len() < 2 {
        return [low, high].map(|place| (place, text(place))).into();
    }
    own.into_iter()
        .map(|power| (f64::from(power), text(f64::from(power))))
        .collect()
}

/// A patch, a name and a value at the right end.
pub fn entry(ui: &mut Ui, color: Color32, name: &str, value: &str) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(PATCH_SIZE, PATCH_SIZE), Sense::hover());
        ui.painter().rect_filled(rect, 2.0, color);
        let edge = Stroke::new(0.5, style::palette(ui).grid);
        ui.painter()
            .rect_stroke(rect, 2.0, edge, StrokeKind::Inside);
        ui.label(crate::app::widgets::text::small(name));
        ui.with_layout(
            eframe::egui::Layout::right_to_left(eframe::egui::Align::Center),
            |ui| ui.label(crate::app::widgets::text::small(value).monospace()),
        );
    });
}
