//! The frame of every picture against time: curves, levels, contacts, events, cursors.

use std::sync::Arc;

use eframe::egui::{
    Align2, Color32, FontId, Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2,
};
use egui_plot::{Plot, PlotPoint, PlotTransform};

use super::axes::Unit;
use super::curve::{Curve, kept_key};
use super::layer::{Layer, Mark, label, mark};
use super::style::Palette;
use super::{axes, style};
use crate::app::setup::overlay::OverlayId;
use crate::app::setup::view::Picture;
use crate::app::state::Cursors;
use crate::sim::{EventKind, Trace};

/// Samples with at least this many pixels each are drawn as dots.
const DOT_PIXELS: usize = 5;

/// Radius of the dot at the moment that a picture has come to \[points\].
const PLAYHEAD_RADIUS: f32 = 5.0;
/// Height of ticks and label of the time axis \[points\].
pub const TIME_AXIS_HEIGHT: f32 = 36.0;

/// A horizontal line with its name.
#[derive(Debug, Clone)]
pub struct Level {
    /// SI.
    pub value: f64,
    /// What it is; empty for a line without a name.
    pub text: &'static str,
    /// Its colour.
    pub color: Color32,
}

/// A picture against time, as its file describes it; SI.
#[derive(Debug, Clone)]
pub struct TimePlot {
    /// Which picture.
    pub picture: Picture,
    /// Quantity on the vertical axis.
    pub quantity: &'static str,
    /// The same shorter, for a picture too low for it.
    pub short_quantity: Option<&'static str>,
    /// Its SI unit.
    pub base: &'static str,
    /// Name of its scale in `View::value_ranges`. Pictures with the same one have the same values
    /// in view.
    pub scale: String,
    /// The recording whose panel it belongs to, with its name, if each has a panel.
    pub panel: Option<(OverlayId, String)>,
    /// Its own time at t = 0 of the cursors \[s\].
    pub time_offset: f64,
    /// The smallest range that is shown.
    pub least: f64,
    /// The values in view as the person chose them or a drag holds them; all of them if `None`.
    pub chosen: Option<(f64, f64)>,
    /// Curves, from back to front.
    pub curves: Vec<Curve>,
    /// Horizontal lines.
    pub levels: Vec<Level>,
    /// Half widths of shaded stripes around zero, with their colours.
    pub bands: Vec<(f64, Color32)>,
    /// The run whose contacts are shaded.
    pub contacts: Option<Arc<Trace>>,
    /// The run and the curve on which events are marked.
    pub events: Option<(Arc<Trace>, Curve)>,
    /// The moment up to which the run is drawn, with a dot there \[s\]; all of it if `None`.
    pub playhead: Option<f64>,
    /// Text shown instead of curves.
    pub message: Option<String>,
}

/// What all pictures against time share in a frame.
#[derive(Debug, Clone, Copy)]
pub struct Common {
    /// Time in view \[s\].
    pub window: (f64, f64),
    /// Cursors to draw.
    pub cursors: Cursors,
}

/// The response of a plot to mouse and keys.
pub struct Reply {
    /// Response of the area inside the axes.
    pub response: Response,
    /// Time at its left and right edge \[s\].
    pub window: (f64, f64),
    /// Name of its scale in `View::value_ranges`.
    pub scale: String,
    /// Value at its lower and upper edge, SI.
    pub values: (f64, f64),
    /// Response of the vertical axis.
    pub axis: Response,
}

impl TimePlot {
    /// An empty picture.
    pub fn new(picture: Picture, quantity: &'static str, base: &'static str) -> Self {
        Self {
            picture,
            quantity,
            short_quantity: None,
            base,
            scale: picture.name().to_owned(),
            panel: None,
            time_offset: 0.0,
            least: 0.0,
            chosen: None,
            curves: Vec::new(),
            levels: Vec::new(),
            bands: Vec::new(),
            contacts: None,
            events: None,
            playhead: None,
            message: None,
        }
    }

    /// The curves that are drawn.
    pub fn drawn(&self) -> impl Iterator<Item = &Curve> {
        self.curves.iter().filter(|curve| !curve.hidden)
    }

    /// The key of a curve in `View::switched_curves`.
    pub fn key(&self, curve: &Curve) -> String {
        match &curve.kept {
            Some(name) => kept_key(name),
            None => format!("{}: {}", self.picture.name(), curve.name),
        }
    }

    /// Range of the values in view: as chosen, else all of them with a margin.
    pub fn range(&self, (from, to): (f64, f64)) -> (f64, f64) {
        if let Some(chosen) = self.chosen {
            return chosen;
        }
        let mut range = axes::union(self.drawn().filter_map(|c| c.value_range(from, to)));
        for &(half, _) in &self.bands {
            range = axes::union(range.into_iter().chain([(-half, half)]));
        }
        for level in &self.levels {
            // A distant level must not flatten the curve.
            let wide = axes::union(range.into_iter().chain([(level.value, level.value)]));
            let size = |r: Option<(f64, f64)>| r.map_or(0.0, |(low, high)| high - low);
            if size(wide) <= 1.5 * size(range).max(self.least) {
                range = wide;
            }
        }
        axes::room(range, self.least.max(1e-12))
    }

    /// Draws the picture `height` points high; the lowest one carries the time axis.
    pub fn show(self, ui: &mut Ui, common: &Common, height: f32, lowest: bool) -> Reply {
        let palette = style::palette(ui);
        let window = common.window;
        let time = Unit::of_times(window.0, window.1);
        let (low, high) = self.range(window);
        let unit = Unit::of_range(self.base, low, high);
        let label = unit.label(self.quantity);
        let title = match &self.panel {
            Some((_, of)) => format!("{} of {of}", self.picture.name()),
            None => self.picture.name().to_owned(),
        };
        let name = format!("{title}: {label} against {}", time.label("time t"));
        let x_label = lowest.then(|| time.label("time t"));
        let frame_height = height - if lowest { TIME_AXIS_HEIGHT } else { 0.0 };
        let label = match self.short_quantity {
            Some(short) if text_width(ui, &label) > frame_height => unit.label(short),
            _ => label,
        };
        let slot = (
            self.picture.name(),
            self.panel.as_ref().map(|(panel, _)| *panel),
        );
        let plot = Plot::new(("time plot", slot))
            .width(ui.available_width() - 14.0)
            .sense(Sense::click_and_drag());
        let pixels = (ui.available_width() - style::AXIS_WIDTH).max(16.0) as usize;
        let cursors = common.cursors;
        let seen = (
            window.0,
            self.playhead.map_or(window.1, |t| t.min(window.1)),
        );
        let reply = axes::dress(plot, ui, height, x_label, label).show(ui, |plot| {
            plot.set_plot_bounds_x(window.0 / time.factor..=window.1 / time.factor);
            plot.set_plot_bounds_y(low / unit.factor..=high / unit.factor);
            let scale = (time.factor, unit.factor);
            for (half, color) in self.bands {
                plot.add(stripe(half / unit.factor, color));
            }
            if let Some(trace) = &self.contacts {
                plot.add(contacts(trace, seen, time.factor, pixels, palette.contact));
            }
            for level in self.levels {
                plot.add(Layer::level(
                    level.value / unit.factor,
                    level.text,
                    level.color,
                ));
            }
            for curve in self.curves.iter().filter(|curve| !curve.hidden) {
                let stroke = Stroke::new(curve.width, curve.color);
                let drawn = if curve.is_whole { window } else { seen };
                let points = curve.draw(drawn, pixels, scale);
                if curve.dots && DOT_PIXELS * points.len() < pixels {
                    plot.add(Layer::dots(points.clone(), curve.color));
                }
                plot.add(Layer::line(points, stroke, curve.dashed));
            }
            if let Some((trace, curve)) = self.events {
                plot.add(events(&trace, &curve, seen, scale, pixels, palette));
            }
            if let Some(at) = self.playhead {
                plot.add(playhead_dots(&self.curves, at, scale));
            }
            plot.add(cursor_lines(cursors, time.factor, palette));
            if let Some(message) = self.message {
                plot.add(centred(message, palette.text));
            }
        });
        reply
            .response
            .widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
        let frame = reply.response.rect;
        let axis = Rect::from_min_max(
            pos2(frame.left() - style::AXIS_WIDTH, frame.top()),
            frame.left_bottom(),
        );
        // Of this plot: two may show the same quantity beside each other.
        let id = reply.response.id.with("value axis");
        let axis = ui.interact(axis, id, Sense::click_and_drag());
        let name = format!("Scale of {title}");
        axis.widget_info(|| WidgetInfo::labeled(Role::Splitter, true, &name));
        Reply {
            response: reply.response,
            window,
            scale: self.scale,
            values: (low, high),
            axis,
        }
    }
}

/// Width of a text on an axis \[points\].
fn text_width(ui: &Ui, text: &str) -> f32 {
    let font = FontId::proportional(style::AXIS_TEXT);
    let galley = ui
        .painter()
        .layout_no_wrap(text.to_owned(), font, Color32::PLACEHOLDER);
    galley.size().x
}

/// A rectangle over the whole height, from `from` to `to` in plot units.
fn upright(transform: &PlotTransform, from: f64, to: f64) -> Rect {
    let frame = transform.frame();
    let (a, b) = (
        transform.position_from_point_x(from).max(frame.left()),
        transform.position_from_point_x(to).min(frame.right()),
    );
    Rect::from_min_max(pos2(a, frame.top()), pos2(b.max(a + 0.5), frame.bottom()))
}

fn stripe(half: f64, color: Color32) -> Layer {
    Layer::new(move |_, transform, shapes| {
        let y = |value| transform.position_from_point_y(value);
        let frame = transform.frame();
        let rect = Rect::from_min_max(pos2(frame.left(), y(half)), pos2(frame.right(), y(-half)));
        shapes.push(Shape::rect_filled(rect, 0.0, color));
    })
}

/// The contacts in view \[s\]; contacts closer than a pixel are merged.
pub fn contact_stretches(trace: &Trace, (from, to): (f64, f64), pixels: usize) -> Vec<(f64, f64)> {
    let all = &trace.contacts;
    let pixel = (to - from) / pixels as f64;
    let mut pieces: Vec<(f64, f64)> = Vec::new();
    let mut next = all.partition_point(|contact| contact.1 < from);
    while let Some(&(start, end)) = all.get(next).filter(|contact| contact.0 <= to) {
        match pieces.last_mut() {
            Some(last) if start - last.1 < pixel => last.1 = end,
            _ => pieces.push((start, end)),
        }
        // Contacts that end within this pixel cannot be seen.
        next += 1;
        next += all[next..].partition_point(|contact| contact.1 < end + 0.5 * pixel);
    }
    pieces
}

/// Shades the contacts in view.
fn contacts(trace: &Trace, window: (f64, f64), unit: f64, pixels: usize, color: Color32) -> Layer {
    let pieces = contact_stretches(trace, window, pixels);
    Layer::new(move |_, transform, shapes| {
        for &(start, end) in &pieces {
            let rect = upright(transform, start / unit, end / unit);
            shapes.push(Shape::rect_filled(rect, 0.0, color));
        }
    })
}

/// A marker with its colour and place: time \[s\], value (SI).
pub type Marked = (Mark, Color32, [f64; 2]);

/// Impacts, sticks and releases. Of events closer than a marker, the first of each kind is
/// kept.
pub fn event_marks(
    trace: &Trace,
    curve: &Curve,
    (from, to): (f64, f64),
    pixels: usize,
    palette: &Palette,
) -> Vec<Marked> {
    let spacing = 7.0 * (to - from) / pixels as f64;
    let mut marks = Vec::new();
    let mut next = trace.events.partition_point(|event| event.time < from);
    let mut last = [f64::NEG_INFINITY; 3];
    while let Some(event) = trace.events.get(next).filter(|event| event.time <= to) {
        let (kind, color) = match event.kind {
            EventKind::Impact => (Mark::Impact, palette.impact),
            EventKind::Stick => (Mark::Stick, palette.stick),
            EventKind::Release => (Mark::Release, palette.release),
            EventKind::DriveStep => {
                next += 1;
                continue;
            }
        };
        if event.time - last[kind as usize] >= spacing {
            last[kind as usize] = event.time;
            if let Some(value) = curve.value_at(event.time) {
                marks.push((kind, color, [event.time, value]));
            }
        }
        next += 1;
        // Once all kinds are drawn here, continue after the marker.
        let first = last.iter().copied().fold(f64::INFINITY, f64::min);
        if first > event.time - spacing {
            next += trace.events[next..].partition_point(|e| e.time < first + spacing);
        }
        if marks.len() > 3 * pixels {
            break;
        }
    }
    marks
}

fn events(
    trace: &Trace,
    curve: &Curve,
    window: (f64, f64),
    (time_unit, unit): (f64, f64),
    pixels: usize,
    palette: &'static Palette,
) -> Layer {
    let marks = event_marks(trace, curve, window, pixels, palette);
    Layer::new(move |_, transform, shapes| {
        for &(kind, color, [x, y]) in &marks {
            let point = PlotPoint::new(x / time_unit, y / unit);
            let at = transform.position_from_point(&point);
            shapes.push(mark(kind, at, color));
        }
    })
}

fn cursor_lines(cursors: Cursors, unit: f64, palette: &'static Palette) -> Layer {
    Layer::new(move |ui, transform, shapes| {
        let frame = transform.frame();
        let mut line = |time: f64, color: Color32, name: &str| {
            let x = transform.position_from_point_x(time / unit);
            if !(frame.left()..=frame.right()).contains(&x) {
                return;
            }
            shapes.push(Shape::vline(x, frame.y_range(), Stroke::new(1.0, color)));
            if !name.is_empty() {
                let at = pos2(x + 3.0, frame.top() + 1.0);
                shapes.push(label(ui, at, Align2::LEFT_TOP, name, color));
            }
        };
        if let Some(time) = cursors.hover {
            line(time, palette.hover, "");
        }
        if let Some(time) = cursors.first {
            line(time, palette.cursor[0], "1");
        }
        if let Some(time) = cursors.second {
            line(time, palette.cursor[1], "2");
        }
    })
}

/// A dot on each curve at the moment that the picture has come to.
fn playhead_dots(curves: &[Curve], at: f64, (time_unit, unit): (f64, f64)) -> Layer {
    let shown = curves
        .iter()
        .filter(|curve| !curve.hidden && !curve.is_whole);
    let dots: Vec<([f64; 2], Color32)> = shown
        .filter_map(|curve| {
            let value = curve.value_at(at)?;
            Some(([at / time_unit, value / unit], curve.color))
        })
        .collect();
    Layer::new(move |_, transform, shapes| {
        for &([x, y], color) in &dots {
            let place = transform.position_from_point(&PlotPoint::new(x, y));
            shapes.push(Shape::circle_filled(place, PLAYHEAD_RADIUS, color));
        }
    })
}

fn centred(message: String, color: Color32) -> Layer {
    Layer::new(move |ui, transform, shapes| {
        let at = transform.frame().center();
        shapes.push(label(ui, at, Align2::CENTER_CENTER, &message, color));
    })
}
