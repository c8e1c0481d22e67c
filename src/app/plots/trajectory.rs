//! Proof mass and cantilever against time, with recordings and kept curves.

use std::sync::Arc;

use eframe::egui::{Id, Ui};

use super::event_corners::EventCorners;
use super::frame::cache::Source;
use super::frame::curve::{Curve, Placed};
use super::frame::style::{KEPT_LINE, THICK_LINE, THIN_LINE};
use super::frame::time_plot::{Level, TimePlot};
use super::frame::{cache, style};
use super::residual;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::Picture;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::state::State;
use crate::recording::Channel;
use crate::sim::Trace;

/// Points at which a recording's own run is compared with the simulation.
const COMPARED_POINTS: usize = 400;
/// Share of the motion's range that is about the width of a line.
const COINCIDENCE_SHARE: f64 = 5e-3;

/// The picture.
pub fn describe(ui: &Ui, state: &State) -> TimePlot {
    let palette = style::palette(ui);
    let mut plot = TimePlot::new(Picture::Trajectory, "displacement x", "m");
    plot.least = 1e-10;
    plot.curves.extend(kept(ui, state));
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
    plot.curves.extend(own_runs(ui, state));
    // Recordings are drawn over the simulation, which has to match them.
    plot.curves.extend(recorded(ui, state, Channel::ProofMass));
    plot
}

/// The points of a run at its events. `slot` distinguishes the runs that are shown.
pub fn corners(
    ui: &Ui,
    slot: impl std::hash::Hash + std::fmt::Debug,
    trace: &Arc<Trace>,
) -> Arc<EventCorners> {
    let id = Id::unique(("event corners", slot));
    cache::cached(ui, id, Source::of(trace), || EventCorners::of(trace))
}

/// The kept curves, in their colours, and their runs under the recordings' own drives.
fn kept(ui: &Ui, state: &State) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (kept, run) in state.kept_in_view() {
        let color = style::kept_color(ui, kept.color);
        let line = |name: String, pyramid: &Arc<Pyramid>, corners| {
            let curve = Curve::new(name, Arc::clone(pyramid), color).width(KEPT_LINE);
            curve.through(corners).of_kept(&kept.name)
        };
        let at_events = corners(ui, ("kept", &kept.name), &run.trace);
        let name = format!("{}: xp", kept.name);
        curves.push(line(name, &run.proof_mass_pyramid, at_events));
        for overlay in state.setup.overlays.iter().filter(|o| o.visible) {
            let compared = run.comparisons.iter().find(|c| c.id == overlay.id);
            let own = compared.and_then(|compared| compared.own.as_ref());
            let Some(own) = own.filter(|own| !coincides(&own.trace, &run.trace)) else {
                continue;
            };
            let slot = ("kept own run", &kept.name, overlay.id);
            let at_events = corners(ui, slot, &own.trace);
            let name = format!("{}: xp simulated as {}", kept.name, overlay.recording.name);
            let curve = line(name, &own.proof_mass_pyramid, at_events);
            curves.push(curve.owned(overlay.id));
        }
    }
    curves
}

/// The runs of the recordings that have a drive of their own, in their colours.
fn own_runs(ui: &Ui, state: &State) -> Vec<Curve> {
    let Some(snapshot) = &state.snapshot else {
        return Vec::new();
    };
    let shared = &snapshot.trace;
    let curve = |overlay: &Overlay| {
        let own = residual::comparison(state, overlay)?.own.as_ref()?;
        let curve = run_of(ui, overlay, &own.trace, &own.proof_mass_pyramid);
        (!coincides(&own.trace, shared)).then_some(curve)
    };
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    visible.filter_map(curve).collect()
}

/// The run that a recording is compared with, in the recording's colour.
fn run_of(ui: &Ui, overlay: &Overlay, trace: &Arc<Trace>, xp: &Arc<Pyramid>) -> Curve {
    let color = style::strong_overlay_color(ui, overlay.color);
    let name = format!("xp simulated as {}", overlay.recording.name);
    let curve = Curve::new(name, Arc::clone(xp), color);
    let curve = curve.through(corners(ui, ("own run", overlay.id), trace));
    curve.width(THICK_LINE).owned(overlay.id)
}

/// The picture of one recording and the run that it is compared with.
pub fn describe_one(ui: &Ui, state: &State, overlay: &Overlay) -> TimePlot {
    let palette = style::palette(ui);
    let mut plot = TimePlot::new(Picture::Trajectory, "displacement x", "m");
    plot.short_quantity = Some("x");
    plot.least = 1e-10;
    plot.curves
        .extend(recorded_one(ui, state, overlay, Channel::Cantilever));
    if let Some(snapshot) = &state.snapshot {
        let own = residual::comparison(state, overlay).and_then(|c| c.own.as_ref());
        let (trace, xp, xc) = match own {
            Some(own) => (&own.trace, &own.proof_mass_pyramid, &own.cantilever_pyramid),
            None => (
                &snapshot.trace,
                &snapshot.proof_mass_pyramid,
                &snapshot.cantilever_pyramid,
            ),
        };
        if !xc.is_empty() {
            let name = format!("xc simulated as {}", overlay.recording.name);
            let curve = Curve::new(name, Arc::clone(xc), palette.cantilever);
            plot.curves.push(curve.width(1.0).owned(overlay.id));
        }
        let proof_mass = run_of(ui, overlay, trace, xp);
        plot.curves.push(proof_mass.clone());
        if let Some(value) = trace.ground_level {
            plot.levels.push(Level {
                value,
                text: "ground",
                color: palette.ground,
            });
        }
        plot.contacts = Some(Arc::clone(trace));
        plot.events = Some((Arc::clone(trace), proof_mass));
    }
    plot.curves
        .extend(recorded_one(ui, state, overlay, Channel::ProofMass));
    plot
}

/// Whether two runs are one line on the screen.
fn coincides(own: &Trace, shared: &Trace) -> bool {
    let value = |trace: &Trace, t: f64| {
        let i = ((t - trace.t0) / trace.dt).round();
        (i >= 0.0)
            .then(|| trace.proof_mass.get(i as usize).copied())
            .flatten()
    };
    let (low, high) = crate::recording::extremes(&own.proof_mass);
    let most = COINCIDENCE_SHARE * (high - low);
    let end = own.end();
    (0..COMPARED_POINTS).all(|k| {
        let t = own.t0 + (end - own.t0) * k as f64 / (COMPARED_POINTS - 1) as f64;
        match (value(own, t), value(shared, t)) {
            (Some(a), Some(b)) => (a - b).abs() <= most,
            _ => false,
        }
    })
}

/// A channel of every visible recording that has it, aligned, in its colour.
pub fn recorded(ui: &Ui, state: &State, channel: Channel) -> Vec<Curve> {
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    visible
        .filter_map(|overlay| recorded_one(ui, state, overlay, channel))
        .collect()
}

/// A channel of a recording, if it has it.
fn recorded_one(ui: &Ui, state: &State, overlay: &Overlay, channel: Channel) -> Option<Curve> {
    let mut color = style::overlay_color(ui, overlay.color);
    if channel == Channel::Cantilever {
        color = color.gamma_multiply(0.55);
    }
    let name = format!("{} {}", channel.symbol(), overlay.recording.name);
    let curve = Curve::new(name, cache::channel(ui, overlay, channel)?, color);
    // As it was compared: with zero and clock as estimated.
    let compared = residual::comparison(state, overlay);
    let alignment = compared.map_or(overlay.alignment, |c| c.alignment);
    let placed = Placed::aligned(&alignment, channel);
    let curve = curve.placed(placed).owned(overlay.id);
    Some(curve.width(THIN_LINE).dots())
}
