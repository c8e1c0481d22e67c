//! The period that is drawn by handles, with the grid and the limits of amplifier and film. What
//! exceeds a limit is red.

use eframe::egui::{Color32, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, Vec2, pos2};

use super::plane::{Plane, PlaneAxis, PlaneOutput, Scales};
use crate::app::plots::frame::layer::Layer;
use crate::app::plots::frame::style;
use crate::app::widgets::text::error_color;
use crate::explore::waveform::{EditableWaveform, Excess, ExcessKind, excesses};
use crate::model::drive::{PeriodicDrive, Shape as Piece, Waveform};

/// A handle is hit within this distance \[points\].
const HIT_RADIUS: f32 = 11.0;
/// Radius of a handle, and of one that is selected \[points\].
const HANDLE_RADIUS: f32 = 4.5;
const SELECTED_RADIUS: f32 = 6.5;
/// Lines of the grid that are drawn at most in each direction.
const MAX_GRID_LINES: f64 = 60.0;
/// Points of a curved piece.
const POINTS_PER_CURVE: usize = 40;

/// The picture.
pub struct DrawingPicture<'a> {
    /// What is drawn.
    pub drawn: &'a EditableWaveform,
    /// The handle that keys and fields act on.
    pub selected: Option<usize>,
    /// Voltages in view \[V\].
    pub range: (f64, f64),
}

/// The drive without phase and bursts, which the picture shows.
fn plain_drive(drawn: &EditableWaveform) -> Option<Waveform> {
    let plain = PeriodicDrive {
        phase: 0.0,
        burst: None,
        ..drawn.drive()
    };
    plain.waveform().ok()
}

/// Voltages in view that hold the period and its limit \[V\].
pub fn voltages_in_view(drawn: &EditableWaveform) -> (f64, f64) {
    let handles = drawn.handles().iter();
    let largest = handles.fold(0.0f64, |most, h| most.max((h.voltage + drawn.offset).abs()));
    let limit = drawn.limits.voltage.unwrap_or(0.0);
    let top = 1.15 * largest.max(limit).max(0.5);
    (-top, top)
}

impl DrawingPicture<'_> {
    /// Draws it.
    pub fn show(&self, ui: &mut Ui, size: Vec2) -> PlaneOutput {
        let period = 1.0 / self.drawn.frequency;
        let plane = Plane {
            name: "drawn period",
            x: PlaneAxis::linear("time in the period", "s", (0.0, period)),
            y: PlaneAxis::linear("drive voltage", "V", self.range),
            size,
            has_x: true,
        };
        let scales = plane.scales();
        let palette = style::palette(ui);
        let mut layers = vec![self.grid(scales, palette.grid)];
        let warning = error_color(ui);
        if let Some(limit) = self.drawn.limits.voltage {
            for level in [limit, -limit] {
                let ends = [[0.0, level], [period, level]];
                let stroke = Stroke::new(1.0, warning.gamma_multiply(0.7));
                layers.push(scales.line(ends, stroke, true));
            }
        }
        if let Some(drive) = plain_drive(self.drawn) {
            let points = curve(&drive, period);
            let stroke = Stroke::new(style::THICK_LINE, palette.voltage);
            layers.push(scales.line(points.clone(), stroke, false));
            // A drive that repeats always has limits that can be compared.
            let found = excesses(&drive, &self.drawn.limits).unwrap_or_default();
            for excess in found {
                layers.extend(excess_layers(&excess, &points, period, scales, warning));
            }
        }
        layers.push(self.handles(scales, period, palette.cursor[1], palette.text));
        plane.show(ui, layers)
    }

    /// The points to which handles snap, as faint lines; none where they are too dense.
    fn grid(&self, scales: Scales, color: Color32) -> Layer {
        let period = 1.0 / self.drawn.frequency;
        let (low, high) = self.range;
        let lines = |step: Option<f64>, from: f64, to: f64| -> Vec<f64> {
            let step = step.filter(|step| *step > 0.0 && (to - from) / step <= MAX_GRID_LINES);
            let Some(step) = step else {
                return Vec::new();
            };
            let (first, last) = ((from / step).ceil() as i64, (to / step).floor() as i64);
            (first..=last).map(|i| i as f64 * step).collect()
        };
        let times = lines(self.drawn.grid.time, 0.0, 1.0);
        let offset = self.drawn.offset;
        let voltages = lines(self.drawn.grid.voltage, low - offset, high - offset);
        let stroke = Stroke::new(0.5, color.gamma_multiply(0.35));
        Layer::new(move |_, transform, shapes| {
            let frame = transform.frame();
            for share in &times {
                let x = transform.position_from_point_x(scales.x.place(share * period));
                shapes.push(Shape::vline(x, frame.y_range(), stroke));
            }
            for voltage in &voltages {
                let y = transform.position_from_point_y(scales.y.place(voltage + offset));
                shapes.push(Shape::hline(frame.x_range(), y, stroke));
            }
        })
    }

    fn handles(&self, scales: Scales, period: f64, color: Color32, ink: Color32) -> Layer {
        let offset = self.drawn.offset;
        let places = self.drawn.handles().iter();
        let places: Vec<[f64; 2]> = places
            .map(|h| [h.time * period, h.voltage + offset])
            .collect();
        let selected = self.selected;
        Layer::new(move |_, transform, shapes| {
            for (i, place) in places.iter().enumerate() {
                let at = scales.on_screen(transform, *place);
                if selected == Some(i) {
                    shapes.push(Shape::circle_filled(at, SELECTED_RADIUS, color));
                    let ring = Stroke::new(1.5, ink);
                    shapes.push(Shape::circle_stroke(at, SELECTED_RADIUS + 2.0, ring));
                } else {
                    shapes.push(Shape::circle_filled(at, HANDLE_RADIUS, color));
                }
            }
        })
    }
}

/// The nearest handle at a place of the screen.
pub fn handle_at(output: &PlaneOutput, drawn: &EditableWaveform, pos: Pos2) -> Option<usize> {
    let places = drawn.handles().iter().map(|handle| {
        let place = [handle.time / drawn.frequency, handle.voltage + drawn.offset];
        output.on_screen(place).distance(pos)
    });
    let near = places.enumerate().filter(|(_, far)| *far <= HIT_RADIUS);
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

/// One period as points `[time [s], voltage [V]]`, with all corners and steps.
fn curve(drive: &Waveform, period: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    // The second period: the first one may be entered differently.
    for index in drive.index_at(period).. {
        let piece = drive.segment(index);
        if piece.start >= 2.0 * period * (1.0 - 1e-12) {
            break;
        }
        let (start, end) = (piece.start.max(period), piece.end.min(2.0 * period));
        let parts = match piece.shape {
            Piece::Constant { .. } | Piece::Line { .. } => 1,
            Piece::Sine { .. } | Piece::Chirp { .. } | Piece::Cubic { .. } => POINTS_PER_CURVE,
        };
        for i in 0..=parts {
            let t = start + (end - start) * i as f64 / parts as f64;
            points.push([t - period, piece.shape.voltage(t)]);
        }
    }
    points
}

/// An excess, as a part of the curve drawn thick, or a mark at a step; that of the voltage is also
/// shaded over its time.
fn excess_layers(
    excess: &Excess,
    points: &[[f64; 2]],
    period: f64,
    scales: Scales,
    color: Color32,
) -> Vec<Layer> {
    let (from, to) = (excess.from * period, excess.to * period);
    if excess.from == excess.to {
        return vec![Layer::new(move |_, transform, shapes| {
            let x = transform.position_from_point_x(scales.x.place(from));
            let stroke = Stroke::new(2.0, color);
            shapes.push(Shape::vline(x, transform.frame().y_range(), stroke));
        })];
    }
    let slack = 1e-9 * period;
    let inside = points
        .iter()
        .filter(|p| p[0] >= from - slack && p[0] <= to + slack);
    let part: Vec<[f64; 2]> = inside.copied().collect();
    let mut layers = Vec::new();
    if excess.kind == ExcessKind::Voltage {
        let fill = color.gamma_multiply(0.18);
        layers.push(Layer::new(move |_, transform, shapes| {
            let frame = transform.frame();
            let x = |t: f64| transform.position_from_point_x(scales.x.place(t));
            let rect = Rect::from_min_max(pos2(x(from), frame.top()), pos2(x(to), frame.bottom()));
            shapes.push(Shape::rect_filled(rect, 0.0, fill));
            let edge = Stroke::new(0.5, color);
            shapes.push(Shape::rect_stroke(rect, 0.0, edge, StrokeKind::Inside));
        }));
    }
    layers.push(scales.line(part, Stroke::new(3.5, color), false));
    layers
}

#[cfg(test)]
mod tests {
    use super::super::drawing::*;

    #[test]
    fn a_period_starts_at_zero_and_ends_with_itself() {
        let square = Waveform::parse("square:10Hz:8V", 1.0).unwrap();
        let points = curve(&square, 0.1);
        assert!(points[0][0].abs() < 1e-9 && (points.last().unwrap()[0] - 0.1).abs() < 1e-9);
        // Both steps are there: four corners.
        assert_eq!(points.len(), 4);
        let sine = Waveform::parse("sine:10Hz:8V", 1.0).unwrap();
        let points = curve(&sine, 0.1);
        let top = points.iter().fold(0.0f64, |most, p| most.max(p[1]));
        assert!((top - 8.0).abs() < 1e-2, "{top}");
    }
}
