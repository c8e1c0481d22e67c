//! The frame of pictures without a time axis: paths in a plane, thinned to the pixels they
//! cover.

use std::sync::Arc;

use eframe::egui::{Color32, Id, Role, Sense, Stroke, Ui, WidgetInfo};
use egui_plot::{Plot, PlotPoint};

use super::axes::Unit;
use super::cache::Source;
use super::layer::Layer;
use super::{axes, cache, style};
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::Picture;
use crate::recording::Recording;
use crate::recording::align::Alignment;

/// Most samples used for one path; of a longer one, the last are used.
const MAX_SAMPLES: usize = 100_000;
/// Most points drawn for one path.
const MAX_POINTS: usize = 12_000;
/// Side of a cell in which a path is drawn once \[points\].
const CELL_SIZE: f64 = 1.5;

/// A path to be drawn. Its source shows whether the cached points are still valid.
pub struct Path<K> {
    /// Its name in a legend.
    pub name: String,
    /// Its identity among the paths of a picture.
    pub slot: (&'static str, u64),
    /// What it is computed from.
    pub source: K,
    /// Colour and width.
    pub stroke: Stroke,
    /// Whether it is dashed.
    pub dashed: bool,
}

/// The path of a recording, in the colour of its overlay.
pub fn recorded_path(ui: &Ui, overlay: &Overlay) -> Path<(Source<Recording>, Alignment)> {
    Path {
        name: format!("xp of {}", overlay.recording.name),
        slot: ("recording", overlay.id),
        source: (Source::of(&overlay.recording), overlay.alignment),
        stroke: Stroke::new(style::THIN_LINE, style::overlay_color(ui, overlay.color)),
        dashed: false,
    }
}

/// Indices of the samples of a recording between two times \[s\], after its time shift.
pub fn recorded_samples(overlay: &Overlay, (from, to): (f64, f64)) -> (usize, usize) {
    let index = |t: f64| {
        let time = t - overlay.alignment.time_shift;
        let samples = &overlay.recording.time;
        samples.partition_point(|&sample| sample < time)
    };
    (index(from), index(to))
}

/// An axis of such a picture.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    /// What is shown.
    pub quantity: &'static str,
    /// SI unit.
    pub base: &'static str,
    /// Range with margin, SI.
    pub range: (f64, f64),
}

/// A path as it is drawn; SI.
pub struct XyLine {
    /// Its name in a legend.
    pub name: String,
    /// Its points; `[NaN, NaN]` breaks it.
    pub points: Arc<Vec<[f64; 2]>>,
    /// Colour and width.
    pub stroke: Stroke,
    /// Whether it is dashed.
    pub dashed: bool,
}

/// A picture without a time axis, as its file describes it.
pub struct XyPlot {
    /// Which one.
    pub picture: Picture,
    /// Horizontal and vertical axis.
    pub axes: [Axis; 2],
    size: [f32; 2],
    /// Paths, the lowest first.
    pub lines: Vec<XyLine>,
    dot: Option<([f64; 2], Color32)>,
}

impl XyPlot {
    /// An empty picture of `size` points.
    pub fn new(picture: Picture, axes: [Axis; 2], size: [f32; 2]) -> Self {
        Self {
            picture,
            axes,
            size,
            lines: Vec::new(),
            dot: None,
        }
    }

    /// Adds a path through the samples that `point` gives for `first..last`, SI.
    pub fn add<K>(
        &mut self,
        ui: &Ui,
        path: Path<K>,
        range: (usize, usize),
        point: impl Fn(usize) -> [f64; 2],
    ) where
        K: PartialEq + Clone + Send + Sync + 'static,
    {
        self.add_through(ui, path, range, |i| [point(i)]);
    }

    /// Adds a path through the points that `points` gives for each of `first..last`, SI: a sample
    /// and what happened before the next one.
    pub fn add_through<K, I>(
        &mut self,
        ui: &Ui,
        path: Path<K>,
        (first, last): (usize, usize),
        points: impl Fn(usize) -> I,
    ) where
        K: PartialEq + Clone + Send + Sync + 'static,
        I: IntoIterator<Item = [f64; 2]>,
    {
        let [x, y] = self.axes.map(|axis| axis.range);
        let first = first.max(last.saturating_sub(MAX_SAMPLES));
        let id = Id::unique(("xy path", self.picture.name(), path.slot));
        let size = self.size.map(|side| side.round() as u32);
        let key = (path.source, first, last, (x, y), size);
        let points = cache::cached(ui, id, key, || {
            thin((first..last).flat_map(points), [x, y], self.size)
        });
        self.lines.push(XyLine {
            name: path.name,
            points,
            stroke: path.stroke,
            dashed: path.dashed,
        });
    }

    /// Marks the point at the cursor; SI.
    pub fn dot(&mut self, at: [f64; 2], color: Color32) {
        self.dot = Some((at, color));
    }

    /// Draws it.
    pub fn show(self, ui: &mut Ui) {
        let units = self
            .axes
            .map(|axis| Unit::of_range(axis.base, axis.range.0, axis.range.1));
        let [x, y] = &units;
        let labels = [0, 1].map(|i| units[i].label(self.axes[i].quantity));
        let name = format!(
            "{}: {} against {}",
            self.picture.name(),
            labels[1],
            labels[0]
        );
        let [x_label, y_label] = labels;
        let plot = Plot::new(("xy plot", self.picture.name()))
            .width(self.size[0])
            .sense(Sense::hover());
        let factors = [x.factor, y.factor];
        let reply = axes::dress(plot, ui, self.size[1], Some(x_label), y_label).show(ui, |plot| {
            let [(x0, x1), (y0, y1)] = self.axes.map(|axis| axis.range);
            plot.set_plot_bounds_x(x0 / factors[0]..=x1 / factors[0]);
            plot.set_plot_bounds_y(y0 / factors[1]..=y1 / factors[1]);
            for line in self.lines {
                let scaled = line
                    .points
                    .iter()
                    .map(|p| [p[0] / factors[0], p[1] / factors[1]])
                    .collect();
                plot.add(Layer::line(scaled, line.stroke, line.dashed));
            }
            if let Some(([x, y], color)) = self.dot {
                let at = PlotPoint::new(x / factors[0], y / factors[1]);
                plot.add(Layer::new(move |_, transform, shapes| {
                    let at = transform.position_from_point(&at);
                    shapes.push(eframe::egui::Shape::circle_filled(at, 4.0, color));
                }));
            }
        });
        reply
            .response
            .widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    }
}

/// Keeps the points of a path that change the picture: those that have moved by a cell,
/// unless they and their predecessor lie in cells already drawn. `[NaN, NaN]` breaks the
/// path.
fn thin(
    points: impl Iterator<Item = [f64; 2]>,
    [x, y]: [(f64, f64); 2],
    size: [f32; 2],
) -> Vec<[f64; 2]> {
    let columns = (f64::from(size[0]) / CELL_SIZE).clamp(1.0, 2000.0) as usize;
    let rows = (f64::from(size[1]) / CELL_SIZE).clamp(1.0, 2000.0) as usize;
    let cell = |[a, b]: [f64; 2]| {
        let i = (a - x.0) / (x.1 - x.0) * columns as f64;
        let j = (b - y.0) / (y.1 - y.0) * rows as f64;
        let inside = (0.0..columns as f64).contains(&i) && (0.0..rows as f64).contains(&j);
        inside.then(|| j as usize * columns + i as usize)
    };
    let mut drawn = vec![false; columns * rows];
    let mut line: Vec<[f64; 2]> = Vec::new();
    // The last point skipped, and the cell and state of the last point visited.
    let mut waiting: Option<[f64; 2]> = None;
    let mut last_cell = None;
    for point in points {
        if line.len() >= MAX_POINTS {
            break;
        }
        let Some(here) = cell(point) else {
            // Outside, or not a number.
            if line.last().is_some_and(|p| !p[0].is_nan()) {
                line.push([f64::NAN; 2]);
            }
            (waiting, last_cell) = (None, None);
            continue;
        };
        if last_cell == Some(here) {
            continue;
        }
        let fresh = !std::mem::replace(&mut drawn[here], true);
        if fresh {
            if let Some(before) = waiting.take() {
                line.push(before);
            }
            line.push(point);
        } else {
            if waiting.is_none() && line.last().is_some_and(|p| !p[0].is_nan()) {
                // The segment into a drawn cell still counts; the following ones do not.
                line.push(point);
                line.push([f64::NAN; 2]);
            }
            waiting = Some(point);
        }
        last_cell = Some(here);
    }
    if line.last().is_some_and(|p| p[0].is_nan()) {
        line.pop();
    }
    line
}

/// Axis with a margin around `range`.
pub fn axis(
    quantity: &'static str,
    base: &'static str,
    range: Option<(f64, f64)>,
    least: f64,
) -> Axis {
    Axis {
        quantity,
        base,
        range: axes::room(range, least),
    }
}

/// Samples `first..last` of an even series in `from..=to` \[s\].
pub fn samples(t0: f64, dt: f64, count: usize, (from, to): (f64, f64)) -> (usize, usize) {
    if dt.is_nan() || dt <= 0.0 {
        return (0, count.min(1));
    }
    let index = |t: f64| (((t - t0) / dt).max(0.0) as usize).min(count);
    (index(from), (index(to) + 1).min(count))
}

/// The thick stroke of the run in view.
pub fn stroke(color: Color32) -> Stroke {
    Stroke::new(1.3 * style::THIN_LINE, color)
}

#[cfg(test)]
mod tests {
    use super::super::xy::*;

    const UNIT: [(f64, f64); 2] = [(-1.2, 1.2), (-1.2, 1.2)];

    #[test]
    fn a_path_run_through_often_is_drawn_once() {
        let circle = |i: u32| {
            let (sine, cosine) = (f64::from(i) * 0.01).sin_cos();
            [cosine, sine]
        };
        let once = thin((0..629).map(circle), UNIT, [300.0, 300.0]).len();
        let often = thin((0..90_000).map(circle), UNIT, [300.0, 300.0]).len();
        assert!(once > 300 && often < 4 * once, "{once}, {often}");
    }

    #[test]
    fn missing_points_break_a_path() {
        let points = [
            [0.0, 0.0],
            [0.5, 0.0],
            [f64::NAN, 0.0],
            [0.5, 0.5],
            [0.0, 0.5],
        ];
        let line = thin(points.into_iter(), UNIT, [300.0, 300.0]);
        assert_eq!(line.len(), 5);
        assert!(line[2][0].is_nan());
        assert!(thin([].into_iter(), UNIT, [0.0, 0.0]).is_empty());
    }
}
