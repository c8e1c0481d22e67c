//! Basins of attraction: each start in the colour of the response that it leads to.

use eframe::egui::{Color32, Ui, Vec2};

use super::cells::CellPicture;
use super::colors::{RESPONSE_COLORS, pending_color};
use super::plane::{PlaneAxis, PlaneOutput};
use crate::explore::basin::{BasinMap, BasinPoint, BasinRequest, Beginnings};

/// Colour of a response by its number.
#[must_use]
pub fn response_color(number: usize) -> Color32 {
    RESPONSE_COLORS[number % RESPONSE_COLORS.len()]
}

/// Axes of the starts: displacement and velocity, or phase and nothing.
#[must_use]
pub fn start_axes(request: &BasinRequest) -> [PlaneAxis; 2] {
    match request.beginnings {
        Beginnings::Plane {
            displacement,
            velocity,
            ..
        } => [
            PlaneAxis::linear("initial xp", "m", displacement),
            PlaneAxis::linear("initial xp'", "m/s", velocity),
        ],
        Beginnings::Phases { count } => {
            let last = 1.0 - 1.0 / count.max(1) as f64;
            [
                PlaneAxis::linear("phase of switching on", "", (0.0, last)),
                PlaneAxis::linear("from rest", "", (0.0, 1.0)),
            ]
        }
    }
}

/// Draws basins.
pub fn show(
    ui: &mut Ui,
    (request, map): (&BasinRequest, &BasinMap),
    version: u64,
    size: Vec2,
) -> PlaneOutput {
    let dark = ui.visuals().dark_mode;
    // A single row is drawn twice, as an image needs a height.
    let rows = map.shape.1.max(2);
    let colors = || {
        let color = |point: &BasinPoint| match point {
            BasinPoint::Pending => pending_color(dark),
            BasinPoint::Response(number) => response_color(*number),
            BasinPoint::Hole => Color32::TRANSPARENT,
        };
        let all: Vec<Color32> = map.points.iter().map(color).collect();
        all.repeat(rows / map.shape.1.max(1))
    };
    let picture = CellPicture {
        name: "basins",
        axes: start_axes(request),
        counts: [map.shape.0, rows],
        version: 2 * version + u64::from(dark),
    };
    picture.show(ui, size, colors, Vec::new())
}
