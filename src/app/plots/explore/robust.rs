//! A map of the probability of the wanted response.

use eframe::egui::{Color32, Ui, Vec2};

use super::cells::CellPicture;
use super::colors::{pending_color, scale_color};
use super::map::plane_axis;
use super::plane::{PlaneAxis, PlaneOutput};
use crate::explore::robustness::RobustnessMap;

/// The scale of probabilities.
#[must_use]
pub fn probability_axis() -> PlaneAxis {
    PlaneAxis::linear("probability of the wanted response", "", (0.0, 1.0))
}

/// Draws it.
pub fn show(ui: &mut Ui, map: &RobustnessMap, version: u64, size: Vec2) -> PlaneOutput {
    let dark = ui.visuals().dark_mode;
    let (x, y) = (&map.axes[0], &map.axes[1]);
    let colors = || {
        let points = map.points.iter();
        points
            .map(|point| match point {
                None => pending_color(dark),
                Some(Ok(found)) => scale_color(found.probability),
                Some(Err(_)) => Color32::TRANSPARENT,
            })
            .collect()
    };
    let picture = CellPicture {
        name: "robustness map",
        axes: [plane_axis(x), plane_axis(y)],
        counts: [x.count, y.count],
        version: 2 * version + u64::from(dark),
    };
    picture.show(ui, size, colors, Vec::new())
}
