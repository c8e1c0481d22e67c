//! Forces against time: drive, film, effects, and in contact the pull-off force against
//! the adhesion, as in the paper's figure 7.

use std::sync::Arc;

use eframe::egui::Ui;

use crate::app::setup::Picture;
use crate::app::state::State;
use crate::sim::{ForceTraces, Trace};

use super::cache;
use super::curve::Curve;
use super::style;
use super::time_plot::TimePlot;

/// The largest force, and a picture of the voltage: beside it the others are flat lines.
const DRIVE: &str = "drive";

type Column = fn(&ForceTraces) -> &[f64];

/// Name, whether it is one of the two that decide a release, and the samples.
const FORCES: [(&str, bool, Column); 6] = [
    (DRIVE, false, |forces| &forces.drive),
    ("film", false, |forces| &forces.film),
    ("effects", false, |forces| &forces.effects),
    ("ground", false, |forces| &forces.ground),
    ("pull-off", true, |forces| &forces.pull_off),
    ("adhesion", true, |forces| &forces.adhesion),
];

/// The picture.
pub fn describe(ui: &Ui, state: &State) -> TimePlot {
    let mut plot = TimePlot::new(Picture::Forces, "force", "N");
    plot.least = 1e-12;
    let snapshot = state.snapshot.as_ref();
    if let Some(trace) = snapshot.map(|snapshot| &snapshot.trace) {
        if trace.forces.is_some() {
            plot.curves = curves(ui, trace);
            plot.contacts = Some(Arc::clone(trace));
        } else {
            plot.message = Some("Forces are being computed.".to_owned());
        }
    }
    plot
}

fn curves(ui: &Ui, trace: &Arc<Trace>) -> Vec<Curve> {
    let palette = style::palette(ui);
    FORCES
        .into_iter()
        .zip(palette.forces)
        .filter_map(|((name, decides, values), color)| {
            let pyramid = cache::column(ui, name, trace, |trace| {
                trace.forces.as_ref().map_or(&[], values)
            });
            // A device without effects has no curve of them.
            let (low, high) = pyramid.extremes()?;
            let curve = Curve::new(name, pyramid, color);
            let curve = match name {
                DRIVE => curve.hidden(),
                _ => curve,
            };
            (low != 0.0 || high != 0.0).then(|| {
                if decides {
                    curve.width(style::THICK)
                } else {
                    curve
                }
            })
        })
        .collect()
}
