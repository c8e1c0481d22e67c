//! What is laid over the trajectory: a prediction, and a recording to compare with.

use std::sync::Arc;

use eframe::egui::{Align2, Color32, FontId, Pos2, Shape, Stroke, Ui, pos2};

use super::Stage;
use crate::app::plots::frame::curve::Curve;
use crate::app::plots::frame::style::{self, THICK_LINE, THIN_LINE};
use crate::app::plots::frame::time_plot::{Reply, TimePlot};
use crate::app::setup::view::Picture;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::learn::lesson::{Mark, MarkAxis};

/// Colour index of predictions among the colours of kept curves.
const PREDICTION_COLOR: usize = 2;
/// Colour index of a recording among those of recordings.
const RECORDING_COLOR: usize = 0;
/// Radius of a point of a drawn curve \[points\].
const POINT_RADIUS: f32 = 6.0;

/// A prediction as it is drawn.
#[derive(Debug, Clone, Copy)]
pub enum Predicted<'a> {
    /// A value of the displacement, or a time.
    Mark(&'a Mark, f64),
    /// Readings at even times, and the point that keys move.
    Curve {
        /// The readings \[m\].
        points: &'a [f64],
        /// Readings between which they move \[m\].
        range: (f64, f64),
        /// The point that keys move; `None` once it is handed in.
        selected: Option<usize>,
    },
}

/// What is laid over the trajectory.
#[derive(Debug, Clone, Copy, Default)]
pub struct Overlay<'a> {
    /// The prediction.
    pub predicted: Option<Predicted<'a>>,
    /// The value that the simulation gave for a mark \[SI\], once it may be seen.
    pub simulated: Option<f64>,
}

/// Colour of what a pupil predicts.
fn prediction_color(ui: &Ui) -> Color32 {
    style::kept_color(ui, PREDICTION_COLOR)
}

/// Adds the curves to the plot of the trajectory, and a scale that tells nothing beforehand.
pub(super) fn lay_over(ui: &Ui, plot: &mut TimePlot, stage: &Stage<'_>) {
    if let Some(target) = &stage.result.target {
        let color = style::overlay_color(ui, RECORDING_COLOR);
        let curve = Curve::new("recording", Arc::clone(&target.recorded), color);
        plot.curves.insert(0, curve.width(THIN_LINE).dots().whole());
    }
    let duration = stage.scene.duration;
    let range = match stage.overlay.predicted {
        Some(Predicted::Curve { points, range, .. }) => {
            let last = points.len().saturating_sub(1).max(1) as f64;
            let times: Vec<f64> = (0..points.len())
                .map(|i| duration * i as f64 / last)
                .collect();
            let pyramid = Arc::new(Pyramid::xy(&times, points));
            let curve = Curve::new("prediction", pyramid, prediction_color(ui));
            plot.curves.push(curve.width(THICK_LINE).dashed().whole());
            Some(range)
        }
        Some(Predicted::Mark(mark, _)) if mark.axis == MarkAxis::Displacement => Some(mark.range),
        _ => None,
    };
    if let Some((low, high)) = range {
        let margin = 0.06 * (high - low);
        let own = plot.range((0.0, duration));
        plot.chosen = Some((own.0.min(low - margin), own.1.max(high + margin)));
    }
}

/// The residual of a recording, in a plot of its own.
pub(super) fn residual(ui: &Ui, stage: &Stage<'_>) -> Option<TimePlot> {
    let target = stage.result.target.as_ref()?;
    let mut plot = TimePlot::new(Picture::Residual, "residual", "m");
    plot.least = target.target.noise;
    let color = style::palette(ui).proof_mass;
    let curve = Curve::new(
        "simulation - recording",
        Arc::clone(&target.residual),
        color,
    );
    plot.curves.push(curve.width(THIN_LINE).whole());
    plot.bands
        .push((2.0 * target.target.noise, style::palette(ui).contact));
    Some(plot)
}

/// A point of a plot on screen.
pub(crate) fn place(reply: &Reply, time: f64, value: f64) -> Pos2 {
    let frame = reply.response.rect;
    let across = (time - reply.window.0) / (reply.window.1 - reply.window.0);
    let up = (value - reply.values.0) / (reply.values.1 - reply.values.0);
    pos2(
        frame.left() + across as f32 * frame.width(),
        frame.bottom() - up as f32 * frame.height(),
    )
}

/// Paints marks and the points of a drawn curve.
pub(super) fn paint(ui: &Ui, stage: &Stage<'_>, reply: &Reply) {
    let painter = ui.painter().with_clip_rect(reply.response.rect.expand(4.0));
    let color = prediction_color(ui);
    match stage.overlay.predicted {
        Some(Predicted::Mark(mark, value)) => {
            let simulated = style::palette(ui).proof_mass;
            line(ui, (mark.axis, reply), value, "your mark", color);
            if let Some(found) = stage.overlay.simulated {
                line(ui, (mark.axis, reply), found, "simulated", simulated);
            }
        }
        Some(Predicted::Curve {
            points,
            selected: Some(selected),
            ..
        }) => {
            let last = points.len().saturating_sub(1).max(1) as f64;
            for (i, value) in points.iter().enumerate() {
                let at = place(reply, stage.scene.duration * i as f64 / last, *value);
                if i == selected {
                    painter.circle_stroke(at, POINT_RADIUS + 3.0, Stroke::new(1.5, color));
                }
                painter.circle_filled(at, POINT_RADIUS, color);
            }
        }
        _ => {}
    }
}

/// A dashed line across the plot at a value of a mark.
fn line(ui: &Ui, (axis, reply): (MarkAxis, &Reply), value: f64, name: &str, color: Color32) {
    let frame = reply.response.rect;
    let painter = ui.painter().with_clip_rect(frame);
    let (ends, at, anchor) = match axis {
        MarkAxis::Own => return,
        MarkAxis::Displacement => {
            let y = place(reply, 0.0, value).y;
            let ends = [pos2(frame.left(), y), pos2(frame.right(), y)];
            (ends, pos2(frame.left() + 6.0, y - 1.0), Align2::LEFT_BOTTOM)
        }
        MarkAxis::Time => {
            let x = place(reply, value, 0.0).x;
            let ends = [pos2(x, frame.top()), pos2(x, frame.bottom())];
            (ends, pos2(x + 4.0, frame.top() + 2.0), Align2::LEFT_TOP)
        }
    };
    painter.extend(Shape::dashed_line(&ends, Stroke::new(2.0, color), 8.0, 5.0));
    painter.text(at, anchor, name, FontId::proportional(13.0), color);
}
