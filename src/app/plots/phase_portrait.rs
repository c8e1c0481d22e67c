//! Velocity of the proof mass against its displacement, over the time in view. The velocity
//! of recordings is computed by smoothed differences.

use std::sync::Arc;

use eframe::egui::Ui;

use super::frame::cache::Source;
use super::frame::curve::Placed;
use super::frame::{axes, cache, readout, style, time_window, xy};
use super::trajectory;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::Picture;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::recording::Channel;

/// The picture, `size` points big.
pub fn describe(ui: &Ui, state: &State, size: [f32; 2]) -> xy::XyPlot {
    let palette = style::palette(ui);
    let view = time_window::in_view(state);
    let runs: Vec<(&'static str, &Arc<Snapshot>)> = [
        ("velocity A", state.reference.as_ref()),
        ("velocity", state.snapshot.as_ref()),
    ]
    .into_iter()
    .filter_map(|(name, run)| Some((name, run?)))
    .collect();
    let velocity = |name, run: &Arc<Snapshot>| {
        cache::column(ui, name, &run.trace, |trace| &trace.proof_mass_velocity)
    };
    let corners = |name: &str, run: &Arc<Snapshot>| {
        let slot = if name == "velocity" {
            "run"
        } else {
            "reference"
        };
        trajectory::corners(ui, slot, &run.trace)
    };
    let (from, to) = view;
    let overlays: Vec<&Overlay> = (state.setup.overlays.iter())
        .filter(|overlay| overlay.visible)
        .collect();
    let recorded = trajectory::recorded(ui, state, Channel::ProofMass);
    let x = (runs.iter())
        .filter_map(|(_, run)| run.proof_mass_pyramid.value_range(from, to))
        .chain(
            recorded
                .iter()
                .filter_map(|curve| curve.value_range(from, to)),
        );
    let y = (runs.iter())
        .flat_map(|(name, run)| {
            let at_events = corners(name, run).velocity_range(from, to);
            [velocity(name, run).value_range(from, to), at_events]
        })
        .flatten()
        .chain((overlays.iter()).filter_map(|overlay| recorded_range(ui, overlay, view)));
    let frame = [
        xy::axis("xp", "m", axes::union(x), 1e-10),
        xy::axis("vp", "m/s", axes::union(y), 1e-7),
    ];
    let mut plot = xy::XyPlot::new(Picture::PhasePortrait, frame, size);
    for overlay in overlays {
        add_recorded(ui, &mut plot, overlay, view);
    }
    for (name, run) in &runs {
        let is_reference = *name != "velocity";
        let color = if is_reference {
            palette.reference
        } else {
            palette.proof_mass
        };
        let trace = &run.trace;
        let count = trace.len().min(trace.proof_mass_velocity.len());
        let path = xy::Path {
            name: if is_reference { "A: xp" } else { "xp" }.to_owned(),
            slot: (*name, 0),
            source: Source::of(trace),
            stroke: xy::stroke(color),
            dashed: is_reference,
        };
        let samples = xy::samples(trace.t0, trace.dt, count, view);
        // An impact is a jump of the velocity, not a slanted line between two samples.
        let corners = corners(name, run);
        let next = samples.1;
        plot.add_through(ui, path, samples, |i| {
            let sample = [trace.proof_mass[i], trace.proof_mass_velocity[i]];
            let events = corners.between(i).filter(move |_| i + 1 < next);
            std::iter::once(sample).chain(events)
        });
    }
    if let Some((time, run)) = readout::time(state).zip(state.snapshot.as_ref()) {
        let at = run.proof_mass_pyramid.value_at(time);
        if let Some((x, y)) = at.zip(velocity("velocity", run).value_at(time)) {
            plot.dot([x, y], palette.cursor[0]);
        }
    }
    plot
}

/// Range of a recording's velocity as it is drawn [m/s].
fn recorded_range(ui: &Ui, overlay: &Overlay, (from, to): (f64, f64)) -> Option<(f64, f64)> {
    let shift = overlay.alignment.time_shift;
    let (low, high) = (cache::velocity(ui, overlay).1).value_range(from - shift, to - shift)?;
    let scale = overlay.alignment.xp_scale;
    Some((
        (low * scale).min(high * scale),
        (low * scale).max(high * scale),
    ))
}

fn add_recorded(ui: &Ui, plot: &mut xy::XyPlot, overlay: &Overlay, view: (f64, f64)) {
    let recording = &overlay.recording;
    let alignment = overlay.alignment;
    let xp = Placed::aligned(&alignment, Channel::ProofMass);
    let velocity = cache::velocity(ui, overlay);
    let path = xy::recorded_path(ui, overlay);
    plot.add(ui, path, xy::recorded_samples(overlay, view), |i| {
        [
            xp.value(recording.proof_mass[i]),
            velocity.0[i] * alignment.xp_scale,
        ]
    });
}
