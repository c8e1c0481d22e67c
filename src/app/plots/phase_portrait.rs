//! Velocity of the proof mass against its displacement, over the time in view.

use std::sync::Arc;

use eframe::egui::Ui;

use crate::app::setup::Picture;
use crate::app::snapshot::Snapshot;
use crate::app::state::State;

use super::cache::{self, Source};
use super::{axes, readout, style, window, xy};

/// The picture, `size` points big.
pub fn describe(ui: &Ui, state: &State, size: [f32; 2]) -> xy::XyPlot {
    let palette = style::palette(ui);
    let view = window::in_view(state);
    let runs: Vec<(&'static str, &Arc<Snapshot>)> = [
        ("velocity A", state.ghost.as_ref()),
        ("velocity", state.snapshot.as_ref()),
    ]
    .into_iter()
    .filter_map(|(name, run)| Some((name, run?)))
    .collect();
    let velocity = |name, run: &Arc<Snapshot>| {
        cache::column(ui, name, &run.trace, |trace| &trace.proof_mass_velocity)
    };
    let (from, to) = view;
    let x = runs
        .iter()
        .filter_map(|(_, run)| run.proof_mass_pyramid.value_range(from, to));
    let y = runs
        .iter()
        .filter_map(|(name, run)| velocity(name, run).value_range(from, to));
    let frame = [
        xy::axis("xp", "m", axes::union(x), 1e-10),
        xy::axis("vp", "m/s", axes::union(y), 1e-7),
    ];
    let mut plot = xy::XyPlot::new(Picture::PhasePortrait, frame, size);
    for (name, run) in &runs {
        let ghost = *name != "velocity";
        let color = if ghost {
            palette.ghost
        } else {
            palette.proof_mass
        };
        let trace = &run.trace;
        let count = trace.len().min(trace.proof_mass_velocity.len());
        let path = xy::Path {
            name: if ghost { "A: xp" } else { "xp" }.to_owned(),
            slot: (*name, 0),
            source: Source::of(trace),
            stroke: xy::stroke(color),
            dashed: ghost,
        };
        let samples = xy::samples(trace.t0, trace.dt, count, view);
        plot.add(ui, path, samples, |i| {
            [trace.proof_mass[i], trace.proof_mass_velocity[i]]
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
