//! Displacement against drive voltage, over the time in view, with recordings that have
//! a voltage.

use eframe::egui::Ui;

use super::frame::cache::Source;
use super::frame::curve::{Curve, Placed};
use super::frame::{axes, cache, readout, style, time_window, xy};
use super::trajectory;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::Picture;
use crate::app::state::State;
use crate::recording::Channel;

/// The picture, `size` points big.
pub fn describe(ui: &Ui, state: &State, size: [f32; 2]) -> xy::XyPlot {
    let palette = style::palette(ui);
    let view = time_window::in_view(state);
    let overlays: Vec<&Overlay> = state
        .setup
        .overlays
        .iter()
        .filter(|overlay| overlay.visible && overlay.recording.voltage.is_some())
        .collect();
    let mut curves = [
        trajectory::recorded(ui, state, Channel::Voltage),
        trajectory::recorded(ui, state, Channel::ProofMass),
    ];
    if let Some(run) = &state.snapshot {
        let volts = cache::column(ui, "voltage", &run.trace, |trace| &trace.voltage);
        let xp = run.proof_mass_pyramid.clone();
        curves[0].push(Curve::new("V", volts, palette.voltage));
        curves[1].push(Curve::new("xp", xp, palette.proof_mass));
    }
    let ranges = curves
        .each_ref()
        .map(|curves| axes::union(curves.iter().filter_map(|c| c.value_range(view.0, view.1))));
    let frame = [
        xy::axis("drive V", "V", ranges[0], 1e-3),
        xy::axis("xp", "m", ranges[1], 1e-10),
    ];
    let mut plot = xy::XyPlot::new(Picture::DriveLoop, frame, size);
    for overlay in overlays {
        recorded(ui, &mut plot, overlay, view);
    }
    if let Some(run) = &state.snapshot {
        let trace = &run.trace;
        let count = trace.len().min(trace.voltage.len());
        let path = xy::Path {
            name: "xp".to_owned(),
            slot: ("run", 0),
            source: Source::of(trace),
            stroke: xy::stroke(palette.proof_mass),
            dashed: false,
        };
        let samples = xy::samples(trace.t0, trace.dt, count, view);
        plot.add(ui, path, samples, |i| {
            [trace.voltage[i], trace.proof_mass[i]]
        });
    }
    if let Some(time) = readout::time(state).filter(|_| state.snapshot.is_some()) {
        let at = |curves: &[Curve]| curves.last()?.value_at(time);
        if let Some((x, y)) = at(&curves[0]).zip(at(&curves[1])) {
            plot.dot([x, y], palette.cursor[0]);
        }
    }
    plot
}

fn recorded(ui: &Ui, plot: &mut xy::XyPlot, overlay: &Overlay, view: (f64, f64)) {
    let recording = &overlay.recording;
    let alignment = overlay.alignment;
    let placed = |channel| Placed::aligned(&alignment, channel);
    let (volts, xp) = (placed(Channel::Voltage), placed(Channel::ProofMass));
    let Some(voltage) = &recording.voltage else {
        return;
    };
    let path = xy::recorded_path(ui, overlay);
    plot.add(ui, path, xy::recorded_samples(overlay, view), |i| {
        [volts.value(voltage[i]), xp.value(recording.proof_mass[i])]
    });
}
