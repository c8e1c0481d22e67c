//! What is drawn inside the frame of a plot. The plot library's own items would search
//! every point for hovering and bounds, which is too slow for long curves.

use std::ops::RangeInclusive;

use eframe::egui::{Align2, Color32, FontId, Pos2, Shape, Stroke, Ui, pos2, vec2};
use egui_plot::{PlotBounds, PlotGeometry, PlotItem, PlotItemBase, PlotPoint, PlotTransform};

use super::style::AXIS_TEXT;

/// Longest line that is dashed \[points\]. A longer one covers the plot so densely that it is
/// drawn solid.
const MAX_DASHED_LENGTH: f32 = 12_000.0;

type Draw = dyn Fn(&Ui, &PlotTransform, &mut Vec<Shape>);

/// One layer of a picture, drawn by a closure.
pub struct Layer {
    base: PlotItemBase,
    draw: Box<Draw>,
}

impl Layer {
    /// Drawn by `draw`.
    pub fn new(draw: impl Fn(&Ui, &PlotTransform, &mut Vec<Shape>) + 'static) -> Self {
        Self {
            base: PlotItemBase::new(String::new()),
            draw: Box::new(draw),
        }
    }

    /// A line through `points`; `[NaN, NaN]` breaks it.
    pub fn line(points: Vec<[f64; 2]>, stroke: Stroke, dashed: bool) -> Self {
        Self::new(move |_, transform, shapes| {
            for piece in points.split(|point| point[0].is_nan()) {
                polyline(piece, stroke, dashed, transform, shapes);
            }
        })
    }

    /// A line across the frame at `y`, in the plot's own units, with `text` at its right
    /// end, if it has one: below the line if there is room, above it otherwise.
    pub fn level(y: f64, text: &'static str, color: Color32) -> Self {
        Self::new(move |ui, transform, shapes| {
            let frame = transform.frame();
            let y = transform.position_from_point_y(y);
            if !(frame.top()..=frame.bottom()).contains(&y) {
                return;
            }
            shapes.push(Shape::hline(frame.x_range(), y, Stroke::new(1.0, color)));
            if text.is_empty() {
                return;
            }
            let below = frame.bottom() - y > 16.0;
            let (anchor, shift) = if below {
                (Align2::RIGHT_TOP, 1.0)
            } else {
                (Align2::RIGHT_BOTTOM, -1.0)
            };
            let at = pos2(frame.right() - 6.0, y + shift);
            shapes.push(label(ui, at, anchor, text, color));
        })
    }

    /// A dot at each of `points`.
    pub fn dots(points: Vec<[f64; 2]>, color: Color32) -> Self {
        Self::new(move |_, transform, shapes| {
            let known = points.iter().filter(|point| !point[0].is_nan());
            shapes.extend(known.map(|&p| Shape::circle_filled(place(transform, p), 2.2, color)));
        })
    }
}

impl PlotItem for Layer {
    fn shapes(&self, ui: &Ui, transform: &PlotTransform, shapes: &mut Vec<Shape>) {
        (self.draw)(ui, transform, shapes);
    }

    fn initialize(&mut self, _x_range: RangeInclusive<f64>) {}

    fn color(&self) -> Color32 {
        Color32::TRANSPARENT
    }

    fn allow_hover(&self) -> bool {
        false
    }

    fn geometry(&self) -> PlotGeometry<'_> {
        PlotGeometry::None
    }

    fn bounds(&self) -> PlotBounds {
        PlotBounds::NOTHING
    }

    fn base(&self) -> &PlotItemBase {
        &self.base
    }

    fn base_mut(&mut self) -> &mut PlotItemBase {
        &mut self.base
    }
}

/// Position of a point on the screen. Far points are moved nearer, because single precision
/// does not resolve them.
fn place(transform: &PlotTransform, [x, y]: [f64; 2]) -> Pos2 {
    /// Largest coordinate on the screen [points].
    const MAX_COORDINATE: f32 = 1e5;
    let pos = transform.position_from_point(&PlotPoint::new(x, y));
    pos2(
        pos.x.clamp(-MAX_COORDINATE, MAX_COORDINATE),
        pos.y.clamp(-MAX_COORDINATE, MAX_COORDINATE),
    )
}

fn polyline(
    points: &[[f64; 2]],
    stroke: Stroke,
    dashed: bool,
    transform: &PlotTransform,
    shapes: &mut Vec<Shape>,
) {
    let path: Vec<Pos2> = points.iter().map(|&p| place(transform, p)).collect();
    match path.as_slice() {
        [] => {}
        [only] => shapes.push(Shape::circle_filled(
            *only,
            stroke.width + 1.0,
            stroke.color,
        )),
        _ => {
            let length: f32 = path.windows(2).map(|p| p[0].distance(p[1])).sum();
            if dashed && length < MAX_DASHED_LENGTH {
                shapes.extend(Shape::dashed_line(&path, stroke, 6.0, 4.0));
            } else {
                shapes.push(Shape::line(path, stroke));
            }
        }
    }
}

/// The marker of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A triangle that points down.
    Impact,
    /// A square.
    Stick,
    /// A triangle that points up.
    Release,
}

/// A marker at `at`.
pub fn mark(mark: Mark, at: Pos2, color: Color32) -> Shape {
    /// Half width of a marker [points].
    const R: f32 = 4.0;
    let corners = match mark {
        Mark::Impact => vec![vec2(-R, -R), vec2(R, -R), vec2(0.0, R)],
        Mark::Release => vec![vec2(-R, R), vec2(0.0, -R), vec2(R, R)],
        Mark::Stick => vec![vec2(-R, -R), vec2(R, -R), vec2(R, R), vec2(-R, R)],
    };
    let points = corners.into_iter().map(|corner| at + corner).collect();
    Shape::convex_polygon(points, color, Stroke::NONE)
}

/// Text in a plot.
pub fn label(ui: &Ui, at: Pos2, anchor: Align2, text: &str, color: Color32) -> Shape {
    let font = FontId::proportional(AXIS_TEXT);
    let galley = ui.painter().layout_no_wrap(text.to_owned(), font, color);
    let rect = anchor.anchor_size(at, galley.size());
    Shape::galley(rect.min, galley, color)
}
