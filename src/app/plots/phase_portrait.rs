//! Velocity of the proof mass against its displacement, over the time in view. The velocity
//! of recordings is computed by smoothed differences.

use std::sync::Arc;

use eframe::egui::{Color32, Id, Ui};

use super::event_corners::EventCorners;
use super::frame::cache::Source;
use super::frame::curve::{Placed, kept_key};
use super::frame::{axes, cache, readout, style, time_window, xy};
use super::trajectory;
use crate::app::setup::kept_curve::KeptCurve;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::Picture;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::recording::Channel;

/// The picture, `size` points big.
pub fn describe(ui: &Ui, state: &State, size: [f32; 2]) -> xy::XyPlot {
    let palette = style::palette(ui);
    let view = time_window::in_view(state);
    let runs: Vec<Run<'_>> = runs(ui, state);
    let (from, to) = view;
    let overlays: Vec<&Overlay> = (state.setup.overlays.iter())
        .filter(|overlay| overlay.visible)
        .collect();
    let recorded = trajectory::recorded(ui, state, Channel::ProofMass);
    let x = (runs.iter())
        .filter_map(|run| run.of.proof_mass_pyramid.value_range(from, to))
        .chain(
            recorded
                .iter()
                .filter_map(|curve| curve.value_range(from, to)),
        );
    let y = (runs.iter())
        .flat_map(|run| {
            let at_events = run.corners.velocity_range(from, to);
            [run.velocity.value_range(from, to), at_events]
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
    for (i, run) in runs.iter().enumerate() {
        let trace = &run.of.trace;
        let count = trace.len().min(trace.proof_mass_velocity.len());
        let path = xy::Path {
            name: run.name.clone(),
            slot: ("run", i as u64),
            source: Source::of(trace),
            stroke: xy::stroke(run.color),
            dashed: run.is_kept,
        };
        let samples = xy::samples(trace.t0, trace.dt, count, view);
        // An impact is a jump of the velocity, not a slanted line between two samples.
        let next = samples.1;
        plot.add_through(ui, path, samples, |i| {
            let sample = [trace.proof_mass[i], trace.proof_mass_velocity[i]];
            let events = run.corners.between(i).filter(move |_| i + 1 < next);
            std::iter::once(sample).chain(events)
        });
    }
    let present = runs.last().filter(|run| !run.is_kept);
    if let Some((time, run)) = readout::time(state).zip(present) {
        let at = run.of.proof_mass_pyramid.value_at(time);
        if let Some((x, y)) = at.zip(run.velocity.value_at(time)) {
            plot.dot([x, y], palette.cursor[0]);
        }
    }
    plot
}

/// A run that is drawn.
struct Run<'a> {
    name: String,
    of: &'a Arc<Snapshot>,
    color: Color32,
    is_kept: bool,
    velocity: Arc<Pyramid>,
    corners: Arc<EventCorners>,
}

/// The kept curves, then the present run.
fn runs<'a>(ui: &Ui, state: &'a State) -> Vec<Run<'a>> {
    let run = |kept: Option<&KeptCurve>, of: &'a Arc<Snapshot>| {
        let slot = kept.map(|curve| curve.name.as_str());
        let color = match kept {
            Some(curve) => style::kept_color(ui, curve.color),
            None => style::palette(ui).proof_mass,
        };
        let corners = match slot {
            Some(name) => trajectory::corners(ui, ("kept", name), &of.trace),
            None => trajectory::corners(ui, "run", &of.trace),
        };
        let trace = &of.trace;
        let id = Id::unique(("velocity of a run", slot));
        Run {
            name: slot.map_or_else(|| "xp".to_owned(), |name| format!("{name}: xp")),
            of,
            color,
            is_kept: kept.is_some(),
            velocity: cache::cached(ui, id, Source::of(trace), || {
                Pyramid::new(trace.t0, trace.dt, &trace.proof_mass_velocity)
            }),
            corners,
        }
    };
    let is_shown = |curve: &KeptCurve| {
        let key = kept_key(&curve.name);
        !state.view.switched_curves.contains(&key)
    };
    let kept = state.kept_in_view().filter(|(curve, _)| is_shown(curve));
    let kept = kept.map(|(curve, of)| run(Some(curve), of));
    let present = state.snapshot.iter().map(|of| run(None, of));
    // The present run is drawn over the others.
    kept.collect::<Vec<_>>()
        .into_iter()
        .chain(present)
        .collect()
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
