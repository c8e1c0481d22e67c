//! The frame of the pictures of the Explore workspace: two axes with units, each linear or
//! logarithmic, and layers in SI between them.

use eframe::egui::{FontId, Pos2, Rect, Response, RichText, Role, Sense, Ui, Vec2, WidgetInfo};
use egui_plot::{AxisHints, GridInput, GridMark, Plot, PlotPoint, PlotTransform};

use crate::app::plots::frame::axes::{self, Unit};
use crate::app::plots::frame::layer::Layer;
use crate::app::plots::frame::style::{self, AXIS_TEXT, AXIS_WIDTH};

/// Room at the right for the half of a label that stands at the end of the axis \[points\].
const END_LABEL_ROOM: f32 = 14.0;

/// Least argument of a logarithm: what is not positive lies far below the axis.
const LEAST_ARGUMENT: f64 = 1e-300;
/// Units that take no prefix on an axis, as nobody writes 1 kdeg.
const PLAIN_UNITS: [&str; 2] = ["deg", "%"];

/// An axis: quantity, SI unit and range.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneAxis {
    /// Quantity.
    pub quantity: String,
    /// SI unit; empty for a number.
    pub base: String,
    /// Value at the left or lower end, and at the other one, SI.
    pub range: (f64, f64),
    /// Whether equal ratios are equally far apart.
    pub is_logarithmic: bool,
}

impl PlaneAxis {
    /// A linear axis.
    pub fn linear(quantity: &str, base: &str, range: (f64, f64)) -> Self {
        Self {
            quantity: quantity.to_owned(),
            base: base.to_owned(),
            range,
            is_logarithmic: false,
        }
    }

    /// The unit in which it is labelled.
    #[must_use]
    pub fn unit(&self) -> Unit {
        if self.base.is_empty() || PLAIN_UNITS.contains(&self.base.as_str()) {
            return Unit {
                text: self.base.clone(),
                factor: 1.0,
            };
        }
        Unit::of_range(&self.base, self.range.0, self.range.1)
    }

    /// Quantity with unit.
    #[must_use]
    pub fn label(&self) -> String {
        let unit = self.unit();
        if unit.text.is_empty() {
            self.quantity.clone()
        } else {
            unit.label(&self.quantity)
        }
    }

    /// How values are placed on it.
    #[must_use]
    pub fn scale(&self) -> AxisScale {
        AxisScale {
            factor: self.unit().factor,
            is_logarithmic: self.is_logarithmic,
        }
    }
}

/// How SI values are placed in the plot's own coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisScale {
    factor: f64,
    is_logarithmic: bool,
}

impl AxisScale {
    /// The plot's coordinate of an SI value.
    #[must_use]
    pub fn place(self, value: f64) -> f64 {
        let value = value / self.factor;
        if self.is_logarithmic {
            value.max(LEAST_ARGUMENT).log10()
        } else {
            value
        }
    }

    /// The SI value of a coordinate.
    #[must_use]
    pub fn value(self, place: f64) -> f64 {
        self.factor
            * if self.is_logarithmic {
                10f64.powf(place)
            } else {
                place
            }
    }
}

/// Both scales of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Horizontal.
    pub x: AxisScale,
    /// Vertical.
    pub y: AxisScale,
}

impl Scales {
    /// The plot's coordinates of a point in SI; NaN stays NaN.
    #[must_use]
    pub fn place(self, [x, y]: [f64; 2]) -> [f64; 2] {
        if x.is_nan() || y.is_nan() {
            return [f64::NAN; 2];
        }
        [self.x.place(x), self.y.place(y)]
    }

    /// Where a point in SI is on the screen.
    #[must_use]
    pub fn on_screen(self, transform: &PlotTransform, point: [f64; 2]) -> Pos2 {
        let [x, y] = self.place(point);
        transform.position_from_point(&PlotPoint::new(x, y))
    }

    /// A line through points in SI; NaN breaks it.
    #[must_use]
    pub fn line(
        self,
        points: impl IntoIterator<Item = [f64; 2]>,
        stroke: eframe::egui::Stroke,
        dashed: bool,
    ) -> Layer {
        let placed = points.into_iter().map(|p| self.place(p)).collect();
        Layer::line(placed, stroke, dashed)
    }
}

/// A picture.
pub struct Plane<'a> {
    /// Its id, and the beginning of its name for screen readers.
    pub name: &'a str,
    /// Horizontal axis.
    pub x: PlaneAxis,
    /// Vertical axis.
    pub y: PlaneAxis,
    /// Width and height with ticks and labels \[points\].
    pub size: Vec2,
    /// Whether the horizontal axis has ticks and a label.
    pub has_x: bool,
}

/// What was drawn.
pub struct PlaneOutput {
    /// The area inside the axes.
    pub response: Response,
    /// From coordinates to the screen.
    pub transform: PlotTransform,
    /// From SI to coordinates.
    pub scales: Scales,
}

impl PlaneOutput {
    /// The area inside the axes.
    #[must_use]
    pub fn frame(&self) -> Rect {
        *self.transform.frame()
    }

    /// The point in SI at a place of the screen.
    #[must_use]
    pub fn value_at(&self, pos: Pos2) -> [f64; 2] {
        let point = self.transform.value_from_position(pos);
        [self.scales.x.value(point.x), self.scales.y.value(point.y)]
    }

    /// The point in SI under the pointer, if it is over the picture.
    #[must_use]
    pub fn hovered(&self) -> Option<[f64; 2]> {
        Some(self.value_at(self.response.hover_pos()?))
    }

    /// Where a point in SI is on the screen.
    #[must_use]
    pub fn on_screen(&self, point: [f64; 2]) -> Pos2 {
        self.scales.on_screen(&self.transform, point)
    }
}

impl Plane<'_> {
    /// Both scales.
    #[must_use]
    pub fn scales(&self) -> Scales {
        Scales {
            x: self.x.scale(),
            y: self.y.scale(),
        }
    }

    /// Draws it with layers from back to front.
    pub fn show(self, ui: &mut Ui, layers: Vec<Layer>) -> PlaneOutput {
        let scales = self.scales();
        let (x_label, y_label) = (self.x.label(), self.y.label());
        let spoken = format!("{}: {y_label} against {x_label}", self.name);
        let plot = Plot::new(("explore plane", self.name))
            .width(self.size.x - END_LABEL_ROOM)
            .sense(Sense::click_and_drag());
        let shown_label = self.has_x.then(|| x_label.clone());
        let mut plot = axes::dress(plot, ui, self.size.y, shown_label, y_label.clone());
        let own = |axis: AxisHints<'static>, label: &str| {
            let palette = style::palette(ui);
            axis.label(RichText::new(label).size(AXIS_TEXT).color(palette.text))
                .tick_label_font(FontId::proportional(AXIS_TEXT))
                .tick_label_color(palette.text)
                .formatter(|mark: GridMark, _| number(10f64.powf(mark.value)))
        };
        if self.x.is_logarithmic {
            let axis = own(AxisHints::new_x(), if self.has_x { &x_label } else { "" });
            plot = plot.custom_x_axes(vec![axis]).x_grid_spacer(decade_marks);
        }
        if self.y.is_logarithmic {
            let axis = own(AxisHints::new_y(), &y_label).min_thickness(AXIS_WIDTH);
            plot = plot.custom_y_axes(vec![axis]).y_grid_spacer(decade_marks);
        }
        let ends = |axis: &PlaneAxis, scale: AxisScale| {
            let (a, b) = (scale.place(axis.range.0), scale.place(axis.range.1));
            a.min(b)..=a.max(b)
        };
        let (x_range, y_range) = (ends(&self.x, scales.x), ends(&self.y, scales.y));
        let reply = plot.show(ui, |plot| {
            plot.set_plot_bounds_x(x_range);
            plot.set_plot_bounds_y(y_range);
            for layer in layers {
                plot.add(layer);
            }
        });
        let response = reply.response;
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &spoken));
        PlaneOutput {
            response,
            transform: reply.transform,
            scales,
        }
    }
}

/// 1, 2 and 5 of each decade, or whole decades where there are many.
fn decade_marks(input: GridInput) -> Vec<GridMark> {
    let (from, to) = input.bounds;
    let digits: &[f64] = match to - from {
        span if span < 0.7 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        span if span < 2.2 => &[1.0, 2.0, 5.0],
        span if span < 4.2 => &[1.0, 3.0],
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
    crate::model::unit::format_number(value, 3)
}

#[cfg(test)]
mod tests {
    use super::super::plane::*;

    #[test]
    fn values_come_back_from_both_scales() {
        for is_logarithmic in [false, true] {
            let axis = PlaneAxis {
                is_logarithmic,
                ..PlaneAxis::linear("impact speed", "m/s", (1e-4, 2e-2))
            };
            let scale = axis.scale();
            for value in [1e-4, 3e-3, 2e-2] {
                let back = scale.value(scale.place(value));
                assert!((back - value).abs() < 1e-12 * value, "{back} {value}");
            }
        }
        let phase = PlaneAxis::linear("phase", "deg", (0.0, 1080.0));
        assert_eq!(phase.label(), "phase [deg]");
        let share = PlaneAxis::linear("contact share", "", (0.0, 1.0));
        assert_eq!(share.label(), "contact share");
    }
}
