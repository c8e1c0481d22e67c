//! The gait diagram: a row of contact bars for each foot over the common cycle, the feet above
//! their bars, and beneath how many are down.

use eframe::egui::{
    Align2, Color32, FontId, Pos2, Rect, Role, Sense, Shape, Stroke, StrokeKind, Ui, Vec2,
    WidgetInfo, pos2, vec2,
};

use crate::app::plots::frame::axes::{Unit, ticks};
use crate::app::plots::frame::style;
use crate::explore::gait::Gait;

/// Room for the names of the feet \[points\].
const NAME_WIDTH: f32 = 132.0;
/// Room for share of time on the ground \[points\].
const SHARE_WIDTH: f32 = 62.0;
/// Height of a foot's row, at most \[points\].
const ROW_HEIGHT: f32 = 46.0;
/// Height of the drawing of the feet, at most \[points\].
const FEET_HEIGHT: f32 = 380.0;
/// Room for ticks and label beneath \[points\].
const AXIS_HEIGHT: f32 = 36.0;
/// Height of the row of the support count \[points\].
const SUPPORT_HEIGHT: f32 = 64.0;
/// Size of names \[points\].
const NAME_TEXT: f32 = 13.0;

/// What is drawn of a foot besides its bars.
pub struct FootPicture {
    /// Colour of its device.
    pub color: Color32,
    /// Instants of bounces, as shares of the common cycle.
    pub bounces: Vec<f64>,
    /// Height over the ground as a share of the highest, at the moment shown.
    pub height: f32,
    /// Whether it is down at the moment shown.
    pub is_down: bool,
}

/// A gait at a moment.
pub struct GaitPicture<'a> {
    /// The gait.
    pub gait: &'a Gait,
    /// Its feet.
    pub feet: &'a [FootPicture],
    /// The moment, as a share of the common cycle.
    pub moment: f64,
}

/// Where the parts are.
struct Layout {
    chart: Rect,
    feet: Rect,
    row: f32,
}

impl GaitPicture<'_> {
    /// Draws it; returns the moment under the pointer while it is pressed.
    pub fn show(&self, ui: &mut Ui, size: Vec2) -> Option<f64> {
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let spoken = format!(
            "gait: contacts of {} feet over {} s",
            self.feet.len(),
            self.gait.cycle
        );
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &spoken));
        let layout = self.layout(rect);
        self.paint_feet(ui, &layout);
        for i in 0..self.feet.len() {
            self.paint_row(ui, &layout, i);
        }
        let below = self.feet.len() as f32 * layout.row;
        let support = Rect::from_min_max(
            pos2(layout.chart.left(), layout.chart.top() + below + 8.0),
            layout.chart.max,
        );
        self.paint_support(ui, support);
        self.paint_axis(ui, layout.chart);
        let x = layout.chart.left() + self.moment as f32 * layout.chart.width();
        let stroke = Stroke::new(1.5, style::palette(ui).cursor[1]);
        ui.painter().vline(x, layout.chart.y_range(), stroke);
        let pressed = response.is_pointer_button_down_on();
        let at = response.interact_pointer_pos().filter(|_| pressed)?;
        let share = (at.x - layout.chart.left()) / layout.chart.width();
        Some(f64::from(share.clamp(0.0, 1.0)))
    }

    fn layout(&self, rect: Rect) -> Layout {
        let count = self.feet.len().max(1) as f32;
        let room = rect.height() - AXIS_HEIGHT - SUPPORT_HEIGHT - 8.0;
        let row = (0.62 * room / count).clamp(14.0, ROW_HEIGHT);
        let feet_height = (room - row * count).clamp(0.0, FEET_HEIGHT);
        let left = rect.left() + NAME_WIDTH;
        let right = rect.right() - SHARE_WIDTH;
        let top = rect.top() + feet_height;
        let bottom = top + row * count + 8.0 + SUPPORT_HEIGHT;
        Layout {
            chart: Rect::from_min_max(pos2(left, top), pos2(right, bottom)),
            feet: Rect::from_min_max(pos2(left, rect.top()), pos2(right, top - 8.0)),
            row,
        }
    }

    /// The feet at the moment shown, seen from the side: each over the ground as high as it is.
    fn paint_feet(&self, ui: &Ui, layout: &Layout) {
        let area = layout.feet;
        if area.height() < 50.0 {
            return;
        }
        let palette = style::palette(ui);
        let painter = ui.painter();
        let ground = area.bottom() - 18.0;
        painter.hline(area.x_range(), ground, Stroke::new(2.0, palette.ground));
        let stride = area.width() / self.feet.len().max(1) as f32;
        let travel = (ground - area.top() - 34.0).max(8.0);
        let width = (0.5 * stride).min(64.0);
        for (i, foot) in self.feet.iter().enumerate() {
            let x = area.left() + (i as f32 + 0.5) * stride;
            let bottom = ground - 1.0 - foot.height.clamp(0.0, 1.0) * travel;
            let body = Rect::from_min_max(
                pos2(x - 0.5 * width, bottom - 14.0),
                pos2(x + 0.5 * width, bottom),
            );
            let fill = if foot.is_down {
                foot.color
            } else {
                foot.color.gamma_multiply(0.35)
            };
            // The mount above it stays, the foot hangs from it by its beam.
            let hang = [pos2(x, area.top()), pos2(x, body.top())];
            painter.line_segment(hang, Stroke::new(1.5, palette.grid));
            painter.rect_filled(body, 3.0, fill);
            painter.rect_stroke(body, 3.0, Stroke::new(1.0, foot.color), StrokeKind::Inside);
            let name = short_name(&self.gait.names[i]);
            let font = FontId::proportional(11.5);
            let at = pos2(x, ground + 2.0);
            painter.text(at, Align2::CENTER_TOP, name, font, palette.text);
        }
    }

    fn paint_row(&self, ui: &Ui, layout: &Layout, i: usize) {
        let (foot, chart) = (&self.feet[i], layout.chart);
        let painter = ui.painter();
        let ink = ui.visuals().text_color();
        let top = chart.top() + i as f32 * layout.row;
        let row = Rect::from_min_max(
            pos2(chart.left(), top + 2.0),
            pos2(chart.right(), top + layout.row - 2.0),
        );
        painter.rect_filled(row, 2.0, ui.visuals().extreme_bg_color);
        let font = FontId::proportional(NAME_TEXT);
        let name_at = pos2(chart.left() - 8.0, row.center().y);
        painter.text(
            name_at,
            Align2::RIGHT_CENTER,
            &self.gait.names[i],
            font.clone(),
            ink,
        );
        let x = |share: f64| row.left() + share as f32 * row.width();
        for bar in &self.gait.bars[i] {
            let part = Rect::from_min_max(
                pos2(x(bar.start), row.top()),
                pos2(x(bar.end).max(x(bar.start) + 1.5), row.bottom()),
            );
            painter.rect_filled(part, 2.0, foot.color);
        }
        for &at in &foot.bounces {
            painter.add(triangle(
                pos2(x(at), row.center().y),
                style::palette(ui).impact,
            ));
        }
        let down = 100.0 * self.gait.duty_factors[i];
        let at = pos2(chart.right() + 8.0, row.center().y);
        painter.text(at, Align2::LEFT_CENTER, format!("{down:.1} %"), font, ink);
    }

    /// How many feet are down, as steps.
    fn paint_support(&self, ui: &Ui, rect: Rect) {
        let palette = style::palette(ui);
        let painter = ui.painter();
        painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let most = self.feet.len();
        let y = |count: usize| {
            rect.bottom() - 4.0 - (rect.height() - 14.0) * count as f32 / most.max(1) as f32
        };
        let font = FontId::proportional(11.0);
        for count in [0, most] {
            let at = pos2(rect.left() - 8.0, y(count));
            painter.text(
                at,
                Align2::RIGHT_CENTER,
                count.to_string(),
                font.clone(),
                palette.text,
            );
        }
        let at = pos2(rect.left() - 24.0, rect.center().y);
        let ink = ui.visuals().text_color();
        let name = FontId::proportional(NAME_TEXT);
        painter.text(at, Align2::RIGHT_CENTER, "feet down", name, ink);
        let x = |share: f64| rect.left() + share as f32 * rect.width();
        let mut line: Vec<Pos2> = Vec::new();
        for part in &self.gait.support {
            let (from, to) = (x(part.start), x(part.end));
            let area = Rect::from_min_max(pos2(from, y(part.feet)), pos2(to, rect.bottom() - 4.0));
            painter.rect_filled(area, 0.0, palette.release.gamma_multiply(0.25));
            line.extend([pos2(from, y(part.feet)), pos2(to, y(part.feet))]);
        }
        painter.add(Shape::line(line, Stroke::new(1.6, palette.release)));
    }

    fn paint_axis(&self, ui: &Ui, chart: Rect) {
        let palette = style::palette(ui);
        let painter = ui.painter();
        let unit = Unit::of_times(0.0, self.gait.cycle);
        let span = self.gait.cycle / unit.factor;
        let font = FontId::proportional(style::AXIS_TEXT);
        for (value, text) in ticks(0.0, span, f64::from(chart.width() / 80.0)) {
            let x = chart.left() + (value / span) as f32 * chart.width();
            let stroke = Stroke::new(1.0, palette.grid.gamma_multiply(0.35));
            painter.vline(x, chart.y_range(), stroke);
            let at = pos2(x, chart.bottom() + 3.0);
            painter.text(at, Align2::CENTER_TOP, text, font.clone(), palette.text);
        }
        let at = pos2(chart.center().x, chart.bottom() + 18.0);
        let label = unit.label("time in the cycle");
        painter.text(at, Align2::CENTER_TOP, label, font, palette.text);
    }
}

/// A bounce.
fn triangle(at: Pos2, color: Color32) -> Shape {
    let corners = [vec2(-3.5, -3.5), vec2(3.5, -3.5), vec2(0.0, 3.5)];
    let corners = corners.map(|corner| at + corner).to_vec();
    Shape::convex_polygon(corners, color, Stroke::NONE)
}

/// `left front` as `LF`.
fn short_name(name: &str) -> String {
    let letters = name.split_whitespace().filter_map(|w| w.chars().next());
    letters.flat_map(char::to_uppercase).collect()
}
