//! Forces against time: drive, film, effects, and in contact the pull-off force against
//! the adhesion, as in the paper's figure 7.

use std::sync::Arc;

use eframe::egui::Ui;

use crate::app::setup::Picture;
use crate::app::state::State;
use crate::model::Model;
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
            if plot.curves.is_empty() && !trace.proof_mass.is_empty() {
                plot.message = Some(why_none(&state.setup.preset.model));
            }
            plot.contacts = Some(Arc::clone(trace));
        } else {
            plot.message = Some("Forces are being computed.".to_owned());
        }
    }
    plot
}

/// Why no force is drawn.
fn why_none(model: &Model) -> String {
    if model.piezo.is_none() && !model.has_ground && model.effects.is_empty() {
        let device = &model.name;
        return format!("No forces to show: {device} has no drive, no ground and no effects.");
    }
    "No forces to show: all are zero in this run.".to_owned()
}

fn curves(ui: &Ui, trace: &Arc<Trace>) -> Vec<Curve> {
    let palette = style::palette(ui);
    let mut curves: Vec<Curve> = FORCES
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
        .collect();
    // The drive hides behind its name so that the others are seen, where there are others.
    if let [only] = curves.as_mut_slice() {
        only.hidden = false;
    }
    curves
}
