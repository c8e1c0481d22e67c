//! A map of a measure over two numbers: regimes in the colours of categories, other measures on a
//! scale. The paper's cases are marked where the axes are frequency and amplitude.

use eframe::egui::{Color32, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};

use super::cells::CellPicture;
use super::colors::{pending_color, regime_color, scale_color};
use super::plane::{PlaneAxis, PlaneOutput, Scales};
use crate::app::plots::frame::layer::Layer;
use crate::explore::map::{Axis, MapResult, PointState};
use crate::explore::measures::{Drawn, MeasureId, Regime};

/// Decades of a logarithmic scale at most: what is smaller is nothing.
const MAX_DECADES: f64 = 6.0;
/// Half the side of the mark of a case \[points\].
const CASE_RADIUS: f32 = 5.0;

/// A marked case.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseMark {
    /// Where; SI.
    pub place: [f64; 2],
    /// What it is, for the pointer.
    pub name: String,
    /// Whether it has the same form of drive as the map; others are drawn hollow.
    pub has_same_form: bool,
}

/// The map of a measure.
pub struct MapPicture<'a> {
    /// The points.
    pub map: &'a MapResult,
    /// What is drawn.
    pub measure: MeasureId,
    /// Changes with the points.
    pub version: u64,
    /// Cases to mark.
    pub cases: &'a [CaseMark],
    /// The point that keys or the pointer are at.
    pub point: Option<usize>,
    /// A path; SI.
    pub path: &'a [[f64; 2]],
}

/// The axis of a map as it is drawn.
#[must_use]
pub fn plane_axis(axis: &Axis) -> PlaneAxis {
    PlaneAxis {
        quantity: axis.name.clone(),
        base: axis.unit.clone(),
        range: (axis.from, axis.to),
        is_logarithmic: axis.is_logarithmic,
    }
}

/// The scale of a measure over the points that are known; `None` for categories, and without any
/// value.
#[must_use]
pub fn value_axis(map: &MapResult, measure: MeasureId) -> Option<PlaneAxis> {
    let spec = measure.spec();
    if spec.drawn == Drawn::Category {
        return None;
    }
    let is_logarithmic = spec.drawn == Drawn::Logarithmic;
    let values = map.of(measure)?.iter().copied();
    let counts = values.filter(|v| v.is_finite() && (!is_logarithmic || *v > 0.0));
    let (low, high) = counts.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    if low > high {
        return None;
    }
    let low = if is_logarithmic {
        low.max(high * 10f64.powf(-MAX_DECADES))
    } else {
        low
    };
    let high = if high > low {
        high
    } else {
        low + low.abs().max(1e-12)
    };
    Some(PlaneAxis {
        quantity: spec.name.to_owned(),
        base: spec.unit.to_owned(),
        range: (low, high),
        is_logarithmic,
    })
}

/// Colour of a value on a scale.
#[must_use]
pub fn value_color(axis: &PlaneAxis, value: f64) -> Color32 {
    let scale = axis.scale();
    let (low, high) = (scale.place(axis.range.0), scale.place(axis.range.1));
    scale_color((scale.place(value) - low) / (high - low))
}

impl MapPicture<'_> {
    /// Draws it.
    pub fn show(&self, ui: &mut Ui, size: Vec2) -> PlaneOutput {
        let [x, y] = [&self.map.axes[0], &self.map.axes[1]];
        let axes = [plane_axis(x), plane_axis(y)];
        let scales = Scales {
            x: axes[0].scale(),
            y: axes[1].scale(),
        };
        let dark = ui.visuals().dark_mode;
        let ink = ui.visuals().strong_text_color();
        let ground = ui.visuals().extreme_bg_color;
        let mut layers = vec![cases_layer(self.cases.to_vec(), scales, (ink, ground))];
        if self.path.len() > 1 {
            let stroke = Stroke::new(2.5, ink);
            layers.push(scales.line(self.path.to_vec(), stroke, false));
        }
        if let Some(index) = self.point {
            layers.push(self.point_layer(index, scales, (ink, ground)));
        }
        let version = self.version * 64 + self.measure as u64 * 2 + u64::from(dark);
        let picture = CellPicture {
            name: "map",
            axes,
            counts: [x.count, y.count],
            version,
        };
        picture.show(ui, size, || self.colors(dark), layers)
    }

    /// Colour of each point; holes are transparent.
    fn colors(&self, dark: bool) -> Vec<Color32> {
        let pending = pending_color(dark);
        let axis = value_axis(self.map, self.measure);
        let Some(values) = self.map.of(self.measure) else {
            return vec![pending; self.map.states.len()];
        };
        let is_category = self.measure.spec().drawn == Drawn::Category;
        let color = |(state, value): (&PointState, &f64)| match state {
            PointState::Pending => pending,
            PointState::Hole => Color32::TRANSPARENT,
            PointState::Filled | PointState::Solved if is_category => {
                let regime = Regime::from_code(value.round().max(0.0) as u32);
                regime.map_or(pending, regime_color)
            }
            PointState::Filled | PointState::Solved => match &axis {
                // A response without a value, such as an impact speed without contact.
                Some(axis) if value.is_finite() => value_color(axis, *value),
                _ => regime_color(Regime::NoContact)
                    .gamma_multiply(0.55)
                    .to_opaque(),
            },
        };
        self.map.states.iter().zip(values).map(color).collect()
    }

    fn point_layer(
        &self,
        index: usize,
        scales: Scales,
        (ink, ground): (Color32, Color32),
    ) -> Layer {
        let [x, y] = [&self.map.axes[0], &self.map.axes[1]];
        let place = [
            x.value(index % x.count.max(1)),
            y.value(index / x.count.max(1)),
        ];
        Layer::new(move |_, transform, shapes| {
            let at = scales.on_screen(transform, place);
            shapes.push(Shape::circle_stroke(at, 6.0, Stroke::new(3.5, ground)));
            shapes.push(Shape::circle_stroke(at, 6.0, Stroke::new(1.8, ink)));
        })
    }
}

/// The marked case near a place of the screen.
#[must_use]
pub fn case_at<'a>(output: &PlaneOutput, cases: &'a [CaseMark], pos: Pos2) -> Option<&'a CaseMark> {
    cases.iter().find(|case| {
        let at = output.on_screen(case.place);
        at.distance(pos) <= 1.8 * CASE_RADIUS
    })
}

fn cases_layer(cases: Vec<CaseMark>, scales: Scales, (ink, ground): (Color32, Color32)) -> Layer {
    Layer::new(move |_, transform, shapes| {
        for case in &cases {
            let at = scales.on_screen(transform, case.place);
            if !transform.frame().expand(CASE_RADIUS).contains(at) {
                continue;
            }
            let around = Rect::from_center_size(at, Vec2::splat(2.0 * CASE_RADIUS));
            if case.has_same_form {
                let corners = [
                    vec2(0.0, -1.4 * CASE_RADIUS),
                    vec2(1.4 * CASE_RADIUS, 0.0),
                    vec2(0.0, 1.4 * CASE_RADIUS),
                    vec2(-1.4 * CASE_RADIUS, 0.0),
                ];
                let corners = corners.map(|c| pos2(at.x + c.x, at.y + c.y)).to_vec();
                let edge = Stroke::new(1.5, ground);
                shapes.push(Shape::convex_polygon(corners, ink, edge));
            } else {
                for (width, color) in [(3.5, ground), (1.5, ink)] {
                    let stroke = Stroke::new(width, color);
                    shapes.push(Shape::rect_stroke(around, 1.0, stroke, StrokeKind::Middle));
                }
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::map::*;

    #[test]
    fn a_scale_holds_the_values_and_holes_show_hatching() {
        let axis = |id: &str| Axis {
            id: id.to_owned(),
            name: id.to_owned(),
            unit: "Hz".to_owned(),
            of: crate::explore::map::AxisOf::Drive,
            from: 1.0,
            to: 3.0,
            count: 2,
            is_logarithmic: false,
        };
        let map = MapResult {
            axes: vec![axis("a"), axis("b")],
            measures: vec![MeasureId::Regime, MeasureId::Margin],
            values: vec![
                vec![0.0, 1.0, f64::NAN, f64::NAN],
                vec![1e-9, 1.0, f64::NAN, 0.1],
            ],
            states: vec![
                PointState::Solved,
                PointState::Filled,
                PointState::Hole,
                PointState::Pending,
            ],
            holes: [(2, "impossible".to_owned())].into(),
        };
        let scale = value_axis(&map, MeasureId::Margin).unwrap();
        assert_eq!(scale.range, (1e-6, 1.0));
        assert_eq!(value_axis(&map, MeasureId::Regime), None);
        let picture = MapPicture {
            map: &map,
            measure: MeasureId::Regime,
            version: 0,
            cases: &[],
            point: None,
            path: &[],
        };
        let colors = picture.colors(true);
        assert_eq!(colors[0], regime_color(Regime::NoContact));
        assert_eq!(colors[2], Color32::TRANSPARENT);
        assert_eq!(colors[3], pending_color(true));
    }
}
