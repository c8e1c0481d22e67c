//! A plot of one quantity against another, with measured points, curves and levels. The units
//! have a prefix that suits the range. Zooming and panning, if any, are up to the caller.

use eframe::egui::{
    Color32, FontId, Rect, Response, RichText, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2,
    vec2,
};
use egui_plot::{AxisHints, GridInput, GridMark, Plot, PlotPoint};

use crate::app::plots::frame::axes::Unit;
use crate::app::plots::frame::layer::Layer;
use crate::app::plots::frame::style::{AXIS_TEXT, AXIS_WIDTH};
use crate::app::plots::frame::{axes, style};
use crate::app::workspaces::diagnose::colors;
use crate::app::workspaces::diagnose::words::after_text;
use crate::diagnose::Diagnosis;
use crate::diagnose::report::ground::Seen;

/// An axis: quantity, SI unit and range.
pub struct Axis<'a> {
    /// Quantity.
    pub quantity: &'a str,
    /// SI unit; empty for a number.
    pub base: &'a str,
    /// Lowest and highest value shown, in the SI unit.
    pub range: (f64, f64),
}

impl<'a> Axis<'a> {
    /// An axis that holds all finite values with a margin.
    pub fn holding(quantity: &'a str, base: &'a str, values: impl Iterator<Item = f64>) -> Self {
        let range = values
            .filter(|v| v.is_finite())
            .map(|v| (v, v))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let least = range.map_or(1.0, |(a, b)| 1e-6 * a.abs().max(b.abs()));
        Self {
            quantity,
            base,
            range: axes::room(range, least.max(1e-15)),
        }
    }

    /// A logarithmic axis that holds all positive values.
    pub fn holding_log(
        quantity: &'a str,
        base: &'a str,
        values: impl Iterator<Item = f64>,
    ) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite() && *v > 0.0)
            .fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
        let range = if low < high {
            (0.8 * low, 1.3 * high)
        } else {
            (0.1, 10.0)
        };
        Self {
            quantity,
            base,
            range,
        }
    }

    fn unit(&self) -> Unit {
        if self.base.is_empty() {
            return Unit {
                text: String::new(),
                factor: 1.0,
            };
        }
        Unit::of_range(self.base, self.range.0, self.range.1)
    }

    fn label(&self, unit: &Unit) -> String {
        if unit.text.is_empty() {
            self.quantity.to_owned()
        } else {
            unit.label(self.quantity)
        }
    }
}

/// One thing that is drawn. All values are in SI units.
pub enum Item {
    /// A line; NaN breaks it.
    Line {
        points: Vec<[f64; 2]>,
        color: Color32,
        width: f32,
        dashed: bool,
    },
    /// Points with bars for their standard errors.
    Dots { points: Vec<Seen>, color: Color32 },
    /// The area within one standard error.
    Band { points: Vec<Seen>, color: Color32 },
    /// A horizontal line with its name.
    Level {
        value: f64,
        text: &'static str,
        color: Color32,
    },
    /// A shaded interval of the horizontal axis.
    Shade { from: f64, to: f64, color: Color32 },
}

/// A plot.
pub struct Figure<'a> {
    /// Its id, and the beginning of its name for screen readers.
    pub name: &'a str,
    /// Horizontal axis.
    pub x: Axis<'a>,
    /// Vertical axis.
    pub y: Axis<'a>,
    /// Whether the vertical axis is logarithmic.
    pub log: bool,
    /// Height with ticks and label \[points\].
    pub height: f32,
    /// Whether the horizontal axis has ticks and a label.
    pub has_x: bool,
    /// What is drawn, from back to front.
    pub items: Vec<Item>,
}

impl Figure<'_> {
    /// Draws it; the response is that of the area inside the axes.
    pub fn show(self, ui: &mut Ui) -> Response {
        let (xu, yu) = (self.x.unit(), self.y.unit());
        let (x_label, y_label) = (self.x.label(&xu), self.y.label(&yu));
        let spoken = format!("{}: {y_label} against {x_label}", self.name);
        let log = self.log;
        let to_y = move |v: f64| {
            let v = v / yu.factor;
            if log { v.max(1e-300).log10() } else { v }
        };
        let plot = Plot::new(("diagnose figure", self.name))
            .width(ui.available_width() - 12.0)
            .sense(Sense::click_and_drag());
        let x_label = self.has_x.then_some(x_label);
        let mut plot = axes::dress(plot, ui, self.height, x_label, y_label.clone());
        if log {
            plot = decades(plot, ui, y_label);
        }
        let x_range = self.x.range.0 / xu.factor..=self.x.range.1 / xu.factor;
        let y_range = to_y(self.y.range.0)..=to_y(self.y.range.1);
        let place = move |[x, y]: [f64; 2]| [x / xu.factor, to_y(y)];
        let reply = plot.show(ui, |plot| {
            plot.set_plot_bounds_x(x_range);
            plot.set_plot_bounds_y(y_range);
            for item in self.items {
                plot.add(layer(item, place));
            }
        });
        let response = reply.response;
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &spoken));
        response
    }
}

fn layer(item: Item, place: impl Fn([f64; 2]) -> [f64; 2] + 'static) -> Layer {
    match item {
        Item::Line {
            points,
            color,
            width,
            dashed,
        } => {
            let broken = |[x, y]: [f64; 2]| {
                if x.is_finite() && y.is_finite() {
                    place([x, y])
                } else {
                    [f64::NAN, f64::NAN]
                }
            };
            let points = points.into_iter().map(broken).collect();
            Layer::line(points, Stroke::new(width, color), dashed)
        }
        Item::Dots { points, color } => Layer::new(move |_, transform, shapes| {
            let at = |p: [f64; 2]| {
                let [x, y] = place(p);
                transform.position_from_point(&PlotPoint::new(x, y))
            };
            for Seen { x, y, error } in points.iter().filter(|p| p.y.is_finite()) {
                let middle = at([*x, *y]);
                if error.is_finite() {
                    let ends = [at([*x, y - error]), at([*x, y + error])];
                    shapes.push(Shape::line_segment(
                        ends,
                        Stroke::new(1.0, color.gamma_multiply(0.6)),
                    ));
                }
                shapes.push(Shape::circle_filled(middle, 2.4, color));
            }
        }),
        Item::Band { points, color } => Layer::new(move |_, transform, shapes| {
            let known: Vec<&Seen> = (points.iter())
                .filter(|p| p.y.is_finite() && p.error.is_finite())
                .collect();
            let at = |x: f64, y: f64| {
                let [x, y] = place([x, y]);
                transform.position_from_point(&PlotPoint::new(x, y))
            };
            for pair in known.windows(2) {
                let (a, b) = (pair[0], pair[1]);
                let corners = vec![
                    at(a.x, a.y + a.error),
                    at(b.x, b.y + b.error),
                    at(b.x, b.y - b.error),
                    at(a.x, a.y - a.error),
                ];
                shapes.push(Shape::convex_polygon(corners, color, Stroke::NONE));
            }
        }),
        Item::Level { value, text, color } => Layer::level(place([0.0, value])[1], text, color),
        Item::Shade { from, to, color } => Layer::new(move |_, transform, shapes| {
            let frame = transform.frame();
            let x = |v: f64| transform.position_from_point_x(place([v, 1.0])[0]);
            let (a, b) = (x(from).max(frame.left()), x(to).min(frame.right()));
            if a <= b {
                let rect =
                    Rect::from_min_max(pos2(a, frame.top()), pos2(b.max(a + 1.0), frame.bottom()));
                shapes.push(Shape::rect_filled(rect, 0.0, color));
            }
        }),
    }
}

/// Labels an axis of decimal logarithms with the numbers themselves.
fn decades<'a>(plot: Plot<'a>, ui: &Ui, label: String) -> Plot<'a> {
    let palette = style::palette(ui);
    let axis = AxisHints::new_y()
        .label(RichText::new(label).size(AXIS_TEXT).color(palette.text))
        .tick_label_font(FontId::proportional(AXIS_TEXT))
        .tick_label_color(palette.text)
        .min_thickness(AXIS_WIDTH)
        .formatter(|mark: GridMark, _| number(10f64.powf(mark.value)));
    plot.custom_y_axes(vec![axis]).y_grid_spacer(log_marks)
}

/// 1, 2 and 5 of each decade, or whole decades where there are many.
fn log_marks(input: GridInput) -> Vec<GridMark> {
    let (from, to) = input.bounds;
    let digits: &[f64] = match to - from {
        span if span < 1.2 => &[1.0, 2.0, 3.0, 5.0],
        span if span < 2.2 => &[1.0, 3.0],
        _ => &[1.0],
    };
    let (first, last) = (from.floor() as i32, to.ceil() as i32);
    (first..=last)
        .take(40)
        .flat_map(|power| digits.iter().map(move |d| f64::from(power) + d.log10()))
        .filter(|value| (from..=to).contains(value))
        .map(|value| GridMark {
            value,
            step_size: 0.5 * (to - from).max(0.1),
        })
        .collect()
}

fn number(value: f64) -> String {
    let decimals = (-value.max(1e-12).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}

/// Legend entries for the model before and, if an effect was named, after.
pub fn model_entries(ui: &Ui, d: &Diagnosis) -> Vec<(&'static str, Color32)> {
    let mut entries = vec![("re-tuned model", colors::before(ui))];
    if !d.named.is_empty() {
        entries.push((after_text(d), colors::after(ui)));
    }
    entries
}

/// A legend in a line above a plot.
pub fn legend(ui: &mut Ui, entries: &[(&str, Color32)]) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(12.0, 1.0);
        for (text, color) in entries {
            entry(ui, text, *color);
        }
    });
}

/// A coloured patch and a name, never broken over two lines.
fn entry(ui: &mut Ui, text: &str, color: Color32) {
    let (font, ink) = (FontId::proportional(11.5), ui.visuals().text_color());
    let galley = ui.painter().layout_no_wrap(text.to_owned(), font, ink);
    let size = vec2(galley.size().x + 15.0, galley.size().y.max(12.0));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
    let patch = Rect::from_center_size(rect.left_center() + vec2(5.0, 0.0), vec2(9.0, 9.0));
    ui.painter().rect_filled(patch, 2.0, color);
    let at = pos2(rect.left() + 14.0, rect.center().y - 0.5 * galley.size().y);
    ui.painter().galley(at, galley, ink);
}
