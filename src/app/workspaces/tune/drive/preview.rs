//! A small plot of the drive: two periods, or all of it if it is not periodic.

use std::sync::Arc;

use eframe::egui::{Id, Ui};
use egui_plot::{Line, Plot, PlotPoints};

use super::place::Place;
use crate::app::plots::frame::style;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::Overlay;
use crate::model::drive::{Shape, Waveform};

/// The curve is drawn with at most this many points.
const MAX_POINTS: usize = 1200;
/// Points on a curved segment.
const POINTS_PER_CURVE: usize = 24;

/// Draws the plot.
pub fn show(ui: &mut Ui, setup: &Setup, place: Place) {
    let points = match &setup.drive {
        DriveChoice::Waveform(waveform) => corners(waveform, span(setup, waveform)),
        DriveChoice::Recorded(id) => match setup.overlays.iter().find(|o| o.id == *id) {
            Some(overlay) => recorded(ui, overlay).as_ref().clone(),
            None => return,
        },
    };
    let milliseconds = points.last().is_some_and(|p| p[0] < 2.0);
    let factor = if milliseconds { 1e3 } else { 1.0 };
    let line: Vec<[f64; 2]> = points.iter().map(|p| [p[0] * factor, p[1]]).collect();
    let color = style::palette(ui).voltage;
    let height = if place == Place::Panel { 84.0 } else { 170.0 };
    Plot::new((place.scope(), "preview"))
        .height(height)
        .x_axis_label(if milliseconds { "t [ms]" } else { "t [s]" })
        .y_axis_label("V [V]")
        .x_grid_spacer(crate::app::widgets::text::round_steps())
        .y_grid_spacer(crate::app::widgets::text::round_steps())
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .show_y(false)
        .set_margin_fraction(eframe::egui::vec2(0.01, 0.12))
        .show(ui, |plot| {
            plot.line(
                Line::new("drive", PlotPoints::from(line))
                    // A band would smear the vertical edges.
                    .allow_band(false)
                    .color(color)
                    .width(1.5),
            )
        });
}

/// The time that is shown \[s\].
fn span(setup: &Setup, waveform: &Waveform) -> f64 {
    match waveform {
        Waveform::Table(table) => table.end().max(1e-6),
        Waveform::Chirp { duration, .. } => *duration,
        Waveform::Rest => setup.duration,
        _ => waveform
            .period()
            .map_or(setup.duration, |period| 2.0 * period),
    }
}

/// The voltage as a line through all corners, or evenly sampled if there are too many.
/// Points are `[time [s], voltage [V]]`.
pub(crate) fn corners(waveform: &Waveform, span: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    let mut index = waveform.index_at(0.0);
    while points.len() < MAX_POINTS {
        let segment = waveform.segment(index);
        let (start, end) = (segment.start.max(0.0), segment.end.min(span));
        let pieces = match segment.shape {
            Shape::Constant { .. } | Shape::Line { .. } => 1,
            Shape::Sine { .. } | Shape::Chirp { .. } | Shape::Cubic { .. } => POINTS_PER_CURVE,
        };
        for i in 0..=pieces {
            let t = start + (end - start) * i as f64 / pieces as f64;
            points.push([t, segment.shape.voltage(t)]);
        }
        if segment.end >= span {
            return points;
        }
        index += 1;
    }
    (0..=MAX_POINTS)
        .map(|i| span * i as f64 / MAX_POINTS as f64)
        .map(|t| [t, waveform.voltage(t)])
        .collect()
}

/// A recorded voltage as minimum and maximum of each piece, computed once and cached.
fn recorded(ui: &Ui, overlay: &Overlay) -> Arc<Vec<[f64; 2]>> {
    let key = Id::unique(("recorded drive", overlay.id));
    if let Some(points) = ui.data(|data| data.get_temp::<Arc<Vec<[f64; 2]>>>(key)) {
        return points;
    }
    let (time, voltage) = overlay.recording.drive_table().unwrap_or_default();
    let piece = (2 * time.len() / MAX_POINTS).max(1);
    let mut points = Vec::new();
    for (t, v) in time.chunks(piece).zip(voltage.chunks(piece)) {
        let least = (0..v.len()).min_by(|&a, &b| v[a].total_cmp(&v[b]));
        let greatest = (0..v.len()).max_by(|&a, &b| v[a].total_cmp(&v[b]));
        if let (Some(a), Some(b)) = (least, greatest) {
            points.push([t[a.min(b)], v[a.min(b)]]);
            if a != b {
                points.push([t[a.max(b)], v[a.max(b)]]);
            }
        }
    }
    let points = Arc::new(points);
    ui.data_mut(|data| data.insert_temp(key, points.clone()));
    points
}

#[cfg(test)]
mod tests {
    use super::super::preview::*;

    #[test]
    fn the_curve_has_all_corners_and_few_points() {
        let square = Waveform::Square {
            frequency: 10.0,
            amplitude: 8.0,
        };
        let points = corners(&square, 0.2);
        assert_eq!(points.len(), 8);
        assert_eq!(points[1], [0.05, 8.0]);
        assert_eq!(points[2], [0.05, -8.0]);
        let fast = Waveform::Chirp {
            from: 1.0,
            to: 1e5,
            amplitude: 1.0,
            duration: 10.0,
        };
        assert!(corners(&fast, 10.0).len() <= MAX_POINTS + 1);
    }
}
