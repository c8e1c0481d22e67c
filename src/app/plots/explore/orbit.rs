//! The orbit diagram: points over a swept number, up and down in two colours, and the largest
//! Lyapunov exponent beneath.

use eframe::egui::{Color32, Rect, Shape, Stroke, Ui, Vec2, pos2, vec2};

use super::map::plane_axis;
use super::plane::{Plane, PlaneAxis, PlaneOutput, Scales};
use crate::app::plots::frame::layer::Layer;
use crate::app::plots::frame::{axes, style};
use crate::app::setup::explore::OrbitQuantity;
use crate::explore::orbit::{OrbitAnswer, OrbitDiagram, OrbitSlice};

/// Share of the height that the exponent takes.
const EXPONENT_SHARE: f32 = 0.26;
/// The vertical axis spans at least this share of the largest value shown.
const LEAST_SPAN_SHARE: f64 = 0.05;
/// Radius of a point \[points\].
const POINT_RADIUS: f32 = 1.3;
/// Share of the extent by which responses up and down differ where they coexist.
pub const COEXISTING_SHARE: f64 = 0.02;

/// Colours of the way up and of the way down.
#[must_use]
pub fn way_colors(ui: &Ui) -> [Color32; 2] {
    let palette = style::palette(ui);
    [palette.proof_mass, palette.impact]
}

/// The diagram.
pub struct OrbitPicture<'a> {
    /// What is drawn.
    pub diagram: &'a OrbitDiagram,
    /// Which numbers are the points.
    pub shown: OrbitQuantity,
}

impl OrbitPicture<'_> {
    /// Draws it; returns the upper part.
    pub fn show(&self, ui: &mut Ui, size: Vec2) -> PlaneOutput {
        ui.spacing_mut().item_spacing.y = 0.0;
        let lower = (EXPONENT_SHARE * size.y).floor();
        let output = self.points(ui, vec2(size.x, size.y - lower));
        self.exponent(ui, vec2(size.x, lower));
        output
    }

    /// Values of a slice that are drawn.
    fn values(&self, answer: &OrbitAnswer) -> Vec<f64> {
        match self.shown {
            OrbitQuantity::Displacement => answer.strobes.iter().map(|s| s.displacement).collect(),
            OrbitQuantity::ImpactSpeed => answer.impact_speeds.clone(),
            OrbitQuantity::Bounces => answer.bounces.iter().map(|n| *n as f64).collect(),
        }
    }

    fn axis(&self, points: [&[[f64; 2]]; 2]) -> PlaneAxis {
        let (quantity, base, least) = match self.shown {
            OrbitQuantity::Displacement => ("xp at the strobe", "m", 1e-9),
            OrbitQuantity::ImpactSpeed => ("impact speed", "m/s", 1e-6),
            OrbitQuantity::Bounces => ("bounces per period", "", 1.0),
        };
        let all = points.into_iter().flatten().map(|p| (p[1], p[1]));
        let range = axes::union(all);
        // One response that hardly changes must not look like a cloud.
        let largest = range.map_or(0.0, |(a, b)| f64::max(a.abs(), b.abs()));
        let least = f64::max(least, LEAST_SPAN_SHARE * largest);
        PlaneAxis::linear(quantity, base, axes::room(range, least))
    }

    fn points(&self, ui: &mut Ui, size: Vec2) -> PlaneOutput {
        let of = |slices: &[OrbitSlice]| -> Vec<[f64; 2]> {
            let known = slices
                .iter()
                .filter_map(|slice| Some((slice.value, slice.answer.as_ref().ok()?)));
            known
                .flat_map(|(x, answer)| self.values(answer).into_iter().map(move |y| [x, y]))
                .collect()
        };
        let (up, down) = (of(&self.diagram.up), of(&self.diagram.down));
        let plane = Plane {
            name: "orbit diagram",
            x: plane_axis(&self.diagram.axis),
            y: self.axis([&up, &down]),
            size,
            has_x: false,
        };
        let scales = plane.scales();
        let [up_color, down_color] = way_colors(ui);
        let coexisting = self.diagram.coexisting(COEXISTING_SHARE);
        let coexisting: Vec<f64> = coexisting
            .into_iter()
            .map(|index| self.diagram.axis.value(index))
            .collect();
        let shade = style::palette(ui).contact;
        let half_cell = self.half_cell(scales);
        let layers = vec![
            bands(coexisting, half_cell, scales, shade),
            dots(up, scales, up_color, 1.4 * POINT_RADIUS),
            dots(down, scales, down_color, POINT_RADIUS),
            holes(self.diagram, scales, style::palette(ui).ground),
        ];
        plane.show(ui, layers)
    }

    /// Half the distance of two values of the axis, in the plot's coordinates.
    fn half_cell(&self, scales: Scales) -> f64 {
        let axis = &self.diagram.axis;
        let (a, b) = (scales.x.place(axis.from), scales.x.place(axis.to));
        0.5 * (b - a).abs() / axis.count.saturating_sub(1).max(1) as f64
    }

    fn exponent(&self, ui: &mut Ui, size: Vec2) {
        let of = |slices: &[OrbitSlice]| -> Vec<[f64; 2]> {
            let known = slices.iter().filter_map(|slice| {
                let exponent = slice.answer.as_ref().ok()?.lyapunov?;
                exponent.is_finite().then_some([slice.value, exponent])
            });
            known.collect()
        };
        let (up, down) = (of(&self.diagram.up), of(&self.diagram.down));
        let all = up.iter().chain(&down).map(|p| (p[1], p[1]));
        let range = axes::union(all.chain([(0.0, 0.0)]));
        let plane = Plane {
            name: "largest Lyapunov exponent",
            x: plane_axis(&self.diagram.axis),
            y: PlaneAxis::linear("Lyapunov", "1/period", axes::room(range, 0.1)),
            size,
            has_x: true,
        };
        let scales = plane.scales();
        let [up_color, down_color] = way_colors(ui);
        let ground = style::palette(ui).ground;
        let ends = (self.diagram.axis.from, self.diagram.axis.to);
        let zero = scales.line(
            [[ends.0, 0.0], [ends.1, 0.0]],
            Stroke::new(1.0, ground),
            false,
        );
        let layers = vec![
            zero,
            scales.line(up, Stroke::new(1.4, up_color), false),
            scales.line(down, Stroke::new(1.1, down_color), false),
        ];
        plane.show(ui, layers);
    }
}

fn dots(points: Vec<[f64; 2]>, scales: Scales, color: Color32, radius: f32) -> Layer {
    Layer::new(move |_, transform, shapes| {
        for point in &points {
            let at = scales.on_screen(transform, *point);
            let side = Rect::from_center_size(at, Vec2::splat(2.0 * radius));
            shapes.push(Shape::rect_filled(side, 0.0, color));
        }
    })
}

/// Where responses coexist: the ways up and down differ.
fn bands(values: Vec<f64>, half: f64, scales: Scales, color: Color32) -> Layer {
    Layer::new(move |_, transform, shapes| {
        let frame = transform.frame();
        for value in &values {
            let x = |place: f64| transform.position_from_point_x(place);
            let place = scales.x.place(*value);
            let (left, right) = (x(place - half), x(place + half));
            let rect = Rect::from_min_max(pos2(left, frame.top()), pos2(right, frame.bottom()));
            shapes.push(Shape::rect_filled(rect, 0.0, color));
        }
    })
}

/// Values that are impossible, as short ticks at the bottom.
fn holes(diagram: &OrbitDiagram, scales: Scales, color: Color32) -> Layer {
    let slices = diagram.up.iter().chain(&diagram.down);
    let values: Vec<f64> = slices
        .filter(|slice| slice.answer.is_err())
        .map(|slice| slice.value)
        .collect();
    Layer::new(move |_, transform, shapes| {
        let bottom = transform.frame().bottom();
        for value in &values {
            let x = transform.position_from_point_x(scales.x.place(*value));
            shapes.push(Shape::vline(
                x,
                bottom - 8.0..=bottom,
                Stroke::new(1.0, color),
            ));
        }
    })
}
