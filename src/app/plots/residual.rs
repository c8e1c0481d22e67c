//! Simulation minus recording against time.

use std::sync::Arc;

use eframe::egui::Ui;

use super::frame::curve::Curve;
use super::frame::style;
use super::frame::time_plot::TimePlot;
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::Picture;
use crate::app::simulation::snapshot::OverlayComparison;
use crate::app::state::State;

/// The picture, or a line of text that says why it is empty.
pub fn describe(ui: &Ui, state: &State) -> Result<TimePlot, String> {
    let mut plot = TimePlot::new(Picture::Residual, "residual", "m");
    plot.least = 1e-10;
    let mut reason = None;
    let visible: Vec<&Overlay> = state
        .setup
        .overlays
        .iter()
        .filter(|overlay| overlay.visible)
        .collect();
    for overlay in &visible {
        let Some(compared) = comparison(state, overlay) else {
            continue;
        };
        if let Err(why) = &compared.comparison {
            reason.get_or_insert_with(|| format!("{}: {why}", overlay.recording.name));
        }
        let Some(pyramid) = &compared.residual_pyramid else {
            continue;
        };
        let color = style::overlay_color(ui, overlay.color);
        let name = format!("residual {}", overlay.recording.name);
        plot.curves
            .push(Curve::new(name, Arc::clone(pyramid), color).owned(overlay.id));
        if let Some(noise) = compared.noise {
            plot.bands.push((noise, color.gamma_multiply(0.18)));
        }
    }
    // Under the present residuals, which have to become flat.
    let present = std::mem::replace(&mut plot.curves, kept(ui, state, &visible));
    plot.curves.extend(present);
    if !plot.curves.is_empty() {
        return Ok(plot);
    }
    Err(reason.unwrap_or_else(|| why_empty(state, visible.is_empty())))
}

/// The residuals of the kept curves on the recordings shown, in the curves' colours.
fn kept(ui: &Ui, state: &State, visible: &[&Overlay]) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (kept, run) in state.kept_in_view() {
        let color = style::kept_color(ui, kept.color);
        for overlay in visible {
            let compared = run.comparisons.iter().find(|c| c.id == overlay.id);
            let Some(pyramid) = compared.and_then(|c| c.residual_pyramid.as_ref()) else {
                continue;
            };
            let name = format!("{}: residual {}", kept.name, overlay.recording.name);
            let curve = Curve::new(name, Arc::clone(pyramid), color);
            curves.push(curve.owned(overlay.id).of_kept(&kept.name));
        }
    }
    curves
}

/// The comparison of a recording with the run.
pub fn comparison<'a>(state: &'a State, overlay: &Overlay) -> Option<&'a OverlayComparison> {
    let comparisons = &state.snapshot.as_ref()?.comparisons;
    comparisons.iter().find(|c| c.id == overlay.id)
}

fn why_empty(state: &State, none_visible: bool) -> String {
    let live = state.snapshot.as_ref().is_some_and(|s| s.live.is_some());
    let whole_span = Command::SetMode(Mode::WholeSpan);
    let switch = whole_span.with_keys("recordings are compared in whole-span mode");
    let reason: &str = if state.setup.overlays.is_empty() {
        "open a recording to see its distance from the simulation"
    } else if none_visible {
        "make a recording visible to compare it with the simulation"
    } else if live {
        &switch
    } else {
        "the comparison is being computed"
    };
    format!("Residual: {reason}.")
}
