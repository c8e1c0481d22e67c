//! Proof mass and cantilever against time, with recordings and the reference curve.

use std::sync::Arc;

use eframe::egui::{Id, Ui};

use super::event_corners::EventCorners;
use super::frame::cache::Source;
use super::frame::curve::{Curve, Placed};
use super::frame::style::{THICK_LINE, THIN_LINE};
use super::frame::time_plot::{Level, TimePlot};
use super::frame::{cache, style};
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::Picture;
use crate::app::state::State;
use crate::recording::Channel;
use crate::sim::Trace;

/// The picture.
pub fn describe(ui: &Ui, state: &State) -> TimePlot {
    let palette = style::palette(ui);
    let mut plot = TimePlot::new(Picture::Trajectory, "displacement x", "m");
    plot.least = 1e-10;
    if let Some(reference) = &state.reference {
        let pyramid = Arc::clone(&reference.proof_mass_pyramid);
        let curve = Curve::new("A: xp", pyramid, palette.reference).width(1.5);
        let curve = curve.through(corners(ui, "reference", &reference.trace));
        plot.curves.push(curve.dashed());
    }
    plot.curves.extend(recorded(ui, state, Channel::Cantilever));
    if let Some(snapshot) = &state.snapshot {
        if !snapshot.cantilever_pyramid.is_empty() {
            let pyramid = Arc::clone(&snapshot.cantilever_pyramid);
            let curve = Curve::new("xc", pyramid, palette.cantilever);
            plot.curves.push(curve.width(1.0));
        }
        let proof_mass = Curve::new(
            "xp",
            Arc::clone(&snapshot.proof_mass_pyramid),
            palette.proof_mass,
        )
        .through(corners(ui, "run", &snapshot.trace));
        plot.curves.push(proof_mass.clone().width(THICK_LINE));
        if let Some(value) = snapshot.trace.ground_level {
            plot.levels.push(Level {
                value,
                text: "ground",
                color: palette.ground,
            });
        }
        plot.contacts = Some(Arc::clone(&snapshot.trace));
        plot.events = Some((Arc::clone(&snapshot.trace), proof_mass));
    } else if state.setup.overlays.iter().all(|overlay| !overlay.visible) {
        plot.message = Some("The first result is being computed.".to_owned());
    }
    // Recordings are drawn over the simulation, which has to match them.
    plot.curves.extend(recorded(ui, state, Channel::ProofMass));
    plot
}

/// The points of a run at its events. `slot` distinguishes the runs that are shown.
pub fn corners(ui: &Ui, slot: &'static str, trace: &Arc<Trace>) -> Arc<EventCorners> {
    let id = Id::unique(("event corners", slot));
    cache::cached(ui, id, Source::of(trace), || EventCorners::of(trace))
}

/// A channel of every visible recording that has it, aligned, in its colour.
pub fn recorded(ui: &Ui, state: &State, channel: Channel) -> Vec<Curve> {
    let curve = |overlay: &Overlay| {
        let mut color = style::overlay_color(ui, overlay.color);
        if channel == Channel::Cantilever {
            color = color.gamma_multiply(0.55);
        }
        let name = format!("{} {}", channel.symbol(), overlay.recording.name);
        let curve = Curve::new(name, cache::channel(ui, overlay, channel)?, color);
        let placed = Placed::aligned(&overlay.alignment, channel);
        let curve = curve.placed(placed).owned(overlay.id);
        Some(curve.width(THIN_LINE).dots())
    };
    let overlays = &state.setup.overlays;
    overlays
        .iter()
        .filter(|overlay| overlay.visible)
        .filter_map(curve)
        .collect()
}
