//! Icons, drawn with lines because the default fonts have none.

use std::f32::consts::{PI, TAU};

use eframe::egui::{
    Color32, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo,
    pos2, vec2,
};

/// What an icon shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Icon {
    /// A closed padlock.
    Locked,
    /// An open padlock.
    Unlocked,
    /// An arrow that turns back.
    Reset,
    /// A cross.
    Remove,
    /// A triangle to the right.
    Run,
    /// Two bars.
    Pause,
    /// A bar and a triangle.
    Step,
    /// A triangle to a bar on the left.
    Restart,
}

/// Side of the square an icon takes up \[points\].
pub const ICON_SIZE: f32 = 18.0;

/// A frameless button with an icon. `label` is its name for screen readers and tests.
pub fn icon_button(ui: &mut Ui, icon: Icon, label: &str) -> Response {
    icon_widget(ui, icon, label, None, true)
}

/// Like [`icon_button`], but greyed out and inactive unless `enabled`.
pub fn icon_button_enabled(ui: &mut Ui, icon: Icon, label: &str, enabled: bool) -> Response {
    icon_widget(ui, icon, label, None, enabled)
}

/// A button that is on or off.
pub fn icon_toggle(ui: &mut Ui, icon: Icon, label: &str, on: bool) -> Response {
    icon_widget(ui, icon, label, Some(on), true)
}

fn icon_widget(ui: &mut Ui, icon: Icon, label: &str, on: Option<bool>, enabled: bool) -> Response {
    let sense = if enabled {
        Sense::click()
    } else {
        Sense::hover()
    };
    let (rect, response) = ui.allocate_exact_size(vec2(ICON_SIZE, ICON_SIZE), sense);
    response.widget_info(|| match on {
        Some(on) => WidgetInfo::selected(Role::CheckBox, enabled, on, label),
        None => WidgetInfo::labeled(Role::Button, enabled, label),
    });
    if ui.is_rect_visible(rect) {
        let visuals = ui.visuals();
        let color = if !enabled {
            visuals.weak_text_color().gamma_multiply(0.5)
        } else if response.hovered() || response.has_focus() {
            visuals.strong_text_color()
        } else if on == Some(true) {
            visuals.warn_fg_color
        } else {
            visuals.weak_text_color()
        };
        if response.has_focus() {
            ui.painter()
                .rect_stroke(rect, 3.0, visuals.selection.stroke, StrokeKind::Inside);
        } else if enabled && response.hovered() {
            ui.painter()
                .rect_filled(rect, 3.0, visuals.widgets.hovered.weak_bg_fill);
        }
        draw(ui.painter(), icon, rect.shrink(3.0), color);
    }
    response
}

/// Draws an icon into a square.
pub fn draw(painter: &Painter, icon: Icon, rect: Rect, color: Color32) {
    let stroke = Stroke::new(1.4, color);
    let at = |x: f32, y: f32| rect.min + vec2(x * rect.width(), y * rect.height());
    let filled = |points: Vec<Pos2>| Shape::convex_polygon(points, color, Stroke::NONE);
    match icon {
        Icon::Locked | Icon::Unlocked => {
            let body = Rect::from_min_max(at(0.15, 0.48), at(0.85, 1.0));
            let (center, radius) = if icon == Icon::Locked {
                (at(0.5, 0.4), 0.22 * rect.width())
            } else {
                (at(0.72, 0.32), 0.2 * rect.width())
            };
            let mut shackle = vec![pos2(center.x - radius, body.top())];
            shackle.extend(arc(center, radius, PI, TAU));
            if icon == Icon::Locked {
                painter.rect_filled(body, 1.5, color);
                shackle.push(pos2(center.x + radius, body.top()));
            } else {
                painter.rect_stroke(body, 1.5, Stroke::new(1.1, color), StrokeKind::Inside);
            }
            painter.line(shackle, stroke);
        }
        Icon::Reset => {
            let (center, radius) = (rect.center(), 0.38 * rect.width());
            painter.line(arc(center, radius, -0.75 * PI, 0.85 * PI), stroke);
            let tip = center + radius * vec2((-0.75 * PI).cos(), (-0.75 * PI).sin());
            painter.add(filled(vec![
                tip + vec2(-3.0, -2.5),
                tip + vec2(3.2, -2.2),
                tip + vec2(-1.6, 3.6),
            ]));
        }
        Icon::Remove => {
            painter.line_segment([at(0.15, 0.15), at(0.85, 0.85)], stroke);
            painter.line_segment([at(0.85, 0.15), at(0.15, 0.85)], stroke);
        }
        Icon::Run => {
            painter.add(filled(vec![at(0.15, 0.0), at(1.0, 0.5), at(0.15, 1.0)]));
        }
        Icon::Pause => {
            painter.rect_filled(Rect::from_min_max(at(0.1, 0.0), at(0.4, 1.0)), 1.0, color);
            painter.rect_filled(Rect::from_min_max(at(0.6, 0.0), at(0.9, 1.0)), 1.0, color);
        }
        Icon::Step => {
            painter.rect_filled(Rect::from_min_max(at(0.0, 0.0), at(0.2, 1.0)), 1.0, color);
            painter.add(filled(vec![at(0.35, 0.0), at(1.0, 0.5), at(0.35, 1.0)]));
        }
        Icon::Restart => {
            painter.rect_filled(Rect::from_min_max(at(0.0, 0.0), at(0.2, 1.0)), 1.0, color);
            painter.add(filled(vec![at(0.95, 0.0), at(0.95, 1.0), at(0.3, 0.5)]));
        }
    }
}

fn arc(center: Pos2, radius: f32, from: f32, to: f32) -> Vec<Pos2> {
    (0..=16)
        .map(|i| {
            let angle = from + (to - from) * i as f32 / 16.0;
            center + radius * vec2(angle.cos(), angle.sin())
        })
        .collect()
}
