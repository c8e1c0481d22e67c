//! One cycle of a steady response: the drive voltage above, the displacement beneath, contact
//! shaded, impacts and releases marked.

use eframe::egui::{Rect, Shape, Stroke, Ui, pos2, vec2};

use super::plane::{Plane, PlaneAxis, Scales};
use crate::app::analysis::explore::steady::SteadyView;
use crate::app::plots::frame::layer::{Layer, Mark, mark};
use crate::app::plots::frame::{axes, style};
use crate::sim::{EventKind, Trace};

/// Share of the height that the voltage takes.
const VOLTAGE_SHARE: f32 = 0.38;
/// Of a response that does not repeat, so many periods of the drive are drawn.
const APERIODIC_PERIODS: f64 = 6.0;
/// Least span of a voltage \[V\] and of a displacement \[m\] on an axis.
const LEAST_VOLTAGE_SPAN: f64 = 1e-3;
const LEAST_DISPLACEMENT_SPAN: f64 = 1e-9;

/// Draws it into a width and a height; `name` tells pictures apart.
pub fn show(ui: &mut Ui, name: &str, view: &SteadyView, size: [f32; 2]) {
    let trace = &view.trace;
    let most = APERIODIC_PERIODS * view.response.period;
    let span = match view.response.multiple() {
        Some(_) => view.response.cycle.duration,
        None => view.response.cycle.duration.min(most),
    };
    let x = PlaneAxis::linear("time in the cycle", "s", (0.0, span));
    let upper = (VOLTAGE_SHARE * size[1]).floor();
    ui.spacing_mut().item_spacing.y = 0.0;
    voltage(ui, name, trace, (&x, span), vec2(size[0], upper));
    displacement(ui, name, trace, (x, span), vec2(size[0], size[1] - upper));
}

/// Samples in view as points in SI.
fn points(trace: &Trace, values: &[f64], span: f64) -> Vec<[f64; 2]> {
    let count = ((span / trace.dt).ceil() as usize + 1).min(values.len());
    (0..count)
        .map(|i| [trace.time(i) - trace.t0, values[i]])
        .collect()
}

fn range_of(points: &[[f64; 2]]) -> Option<(f64, f64)> {
    let values = points.iter().map(|p| p[1]).filter(|v| v.is_finite());
    axes::union(values.map(|v| (v, v)))
}

fn voltage(
    ui: &mut Ui,
    name: &str,
    trace: &Trace,
    (x, span): (&PlaneAxis, f64),
    size: eframe::egui::Vec2,
) {
    let line = points(trace, &trace.voltage, span);
    let range = axes::room(range_of(&line), LEAST_VOLTAGE_SPAN);
    let plane = Plane {
        name: &format!("{name}, drive"),
        x: x.clone(),
        y: PlaneAxis::linear("drive", "V", range),
        size,
        has_x: false,
    };
    let stroke = Stroke::new(1.6, style::palette(ui).voltage);
    let layers = vec![plane.scales().line(line, stroke, false)];
    plane.show(ui, layers);
}

fn displacement(
    ui: &mut Ui,
    name: &str,
    trace: &Trace,
    (x, span): (PlaneAxis, f64),
    size: eframe::egui::Vec2,
) {
    let palette = style::palette(ui);
    let line = points(trace, &trace.proof_mass, span);
    let ground = trace.ground_level;
    // The ground is in view only where the mass comes near it.
    let all = range_of(&line);
    let with_ground = match (all, ground) {
        (Some((low, high)), Some(level)) if level > low - 3.0 * (high - low) => {
            axes::union([(low, high), (level, level)])
        }
        _ => all,
    };
    let plane = Plane {
        name: &format!("{name}, response"),
        x,
        y: PlaneAxis::linear("xp", "m", axes::room(with_ground, LEAST_DISPLACEMENT_SPAN)),
        size,
        has_x: true,
    };
    let scales = plane.scales();
    let mut layers = vec![contact_layer(trace, span, scales, palette.contact)];
    if let Some(level) = ground {
        layers.push(Layer::level(
            scales.y.place(level),
            "ground",
            palette.ground,
        ));
    }
    let stroke = Stroke::new(style::THICK_LINE, palette.proof_mass);
    layers.push(scales.line(line, stroke, false));
    layers.push(event_layer(trace, span, scales, palette));
    plane.show(ui, layers);
}

/// Time in contact, shaded.
fn contact_layer(trace: &Trace, span: f64, scales: Scales, color: eframe::egui::Color32) -> Layer {
    let contacts: Vec<(f64, f64)> = trace
        .contacts
        .iter()
        .map(|(from, to)| (from - trace.t0, (to - trace.t0).min(span)))
        .filter(|(from, to)| to > from)
        .collect();
    Layer::new(move |_, transform, shapes| {
        let frame = transform.frame();
        for &(from, to) in &contacts {
            let x = |t: f64| transform.position_from_point_x(scales.x.place(t));
            let (left, right) = (x(from).max(frame.left()), x(to).min(frame.right()));
            let rect = Rect::from_min_max(pos2(left, frame.top()), pos2(right, frame.bottom()));
            shapes.push(Shape::rect_filled(rect, 0.0, color));
        }
    })
}

/// Impacts, contacts that begin, and releases.
fn event_layer(trace: &Trace, span: f64, scales: Scales, palette: &style::Palette) -> Layer {
    let level = trace.ground_level.unwrap_or(0.0);
    let events = trace.events.iter().filter_map(|event| {
        let (kind, color) = match event.kind {
            EventKind::Impact => (Mark::Impact, palette.impact),
            EventKind::Stick => (Mark::Stick, palette.stick),
            EventKind::Release => (Mark::Release, palette.release),
            EventKind::DriveStep => return None,
        };
        let at = event.time - trace.t0;
        (at <= span).then_some((at, kind, color))
    });
    let events: Vec<_> = events.collect();
    Layer::new(move |_, transform, shapes| {
        for &(time, kind, color) in &events {
            let at = scales.on_screen(transform, [time, level]);
            shapes.push(mark(kind, at, color));
        }
    })
}
