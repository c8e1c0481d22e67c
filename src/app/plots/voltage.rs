//! Drive voltage against time.

use eframe::egui::Ui;

use super::frame::curve::Curve;
use super::frame::time_plot::TimePlot;
use super::frame::{cache, style};
use super::trajectory::recorded;
use crate::app::setup::view::Picture;
use crate::app::state::State;
use crate::recording::Channel;

/// The picture.
pub fn describe(ui: &Ui, state: &State) -> TimePlot {
    let mut plot = TimePlot::new(Picture::Voltage, "drive V", "V");
    plot.least = 1e-3;
    plot.curves = recorded(ui, state, Channel::Voltage);
    if state.setup.preset.model.piezo.is_none() && plot.curves.is_empty() {
        plot.message = Some("This device has no drive.".to_owned());
        return plot;
    }
    if let Some(snapshot) = &state.snapshot {
        let pyramid = cache::column(ui, "voltage", &snapshot.trace, |trace| &trace.voltage);
        // A constant voltage must not be magnified to its last digits.
        let largest = pyramid.extremes().map(|(low, high)| high.max(-low));
        plot.least = plot.least.max(0.1 * largest.unwrap_or(0.0));
        let color = style::palette(ui).voltage;
        plot.curves.push(Curve::new("V", pyramid, color).width(1.5));
    }
    plot
}
