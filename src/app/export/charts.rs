//! What stands in each exported plot, in the units of its axes.

use crate::app::setup::{Overlay, Picture};
use crate::app::state::State;
use crate::model::unit::prefix_for;
use crate::recording::Channel;
use crate::recording::align::Alignment;
use crate::sim::{EventKind, Trace};

use crate::app::plots::pyramid::Pyramid;

/// Pixels for which curves are decimated.
const COLUMNS: usize = 1600;

/// Red, green, blue.
pub type Rgb = (u8, u8, u8);

const BLUE: Rgb = (0, 114, 178);
const GREY: Rgb = (130, 130, 130);
const BLACK: Rgb = (40, 40, 40);
/// Okabe and Ito's colours for recordings and forces.
const OTHERS: [Rgb; 6] = [
    (230, 159, 0),
    (0, 158, 115),
    (204, 121, 167),
    (213, 94, 0),
    (86, 180, 233),
    (160, 144, 20),
];

/// One curve; NaN breaks the line.
#[derive(Debug, Clone)]
pub struct Line {
    pub name: String,
    pub color: Rgb,
    pub points: Vec<(f64, f64)>,
}

/// One plot.
#[derive(Debug, Clone)]
pub struct Chart {
    pub x_label: String,
    pub y_label: String,
    pub x_range: (f64, f64),
    pub y_range: (f64, f64),
    pub lines: Vec<Line>,
    /// Shaded stretches of x.
    pub shaded: Vec<(f64, f64)>,
    /// A level with its name.
    pub level: Option<(f64, &'static str)>,
    /// Places with a mark.
    pub marks: Vec<(f64, f64, EventKind)>,
}

/// The plots that are in view, from top to bottom.
pub fn of(state: &State) -> Vec<Chart> {
    let Some(snapshot) = &state.snapshot else {
        return Vec::new();
    };
    let trace = snapshot.trace.as_ref();
    let range = state.view.time_range.unwrap_or((trace.t0, trace.end()));
    let mut charts = Vec::new();
    for picture in &state.view.pictures {
        let chart = match picture {
            Picture::Voltage => voltage(state, trace, range),
            Picture::Trajectory => trajectory(state, trace, range),
            Picture::Residual => residual(state, range),
            Picture::Forces => forces(trace, range),
            Picture::PhasePortrait => phase_portrait(trace, range),
            Picture::DriveLoop => drive_loop(trace, range),
            // Drawn by hand in the window: it is no plot.
            Picture::Device => None,
        };
        charts.extend(chart);
    }
    charts
}

/// Builds a chart against time from curves in SI.
fn against_time(
    quantity: &str,
    unit: &str,
    range: (f64, f64),
    mut lines: Vec<Line>,
    level: Option<(f64, &'static str)>,
) -> Option<Chart> {
    let (t_prefix, t_factor) = prefix_for(range.1 - range.0, "s");
    let values = lines
        .iter()
        .flat_map(|line| line.points.iter().map(|p| p.1));
    let (low, high) = extremes(values.chain(level.map(|(value, _)| value)))?;
    let (prefix, factor) = prefix_for(low.abs().max(high.abs()), unit);
    for line in &mut lines {
        for point in &mut line.points {
            *point = (point.0 / t_factor, point.1 / factor);
        }
    }
    let room = 0.05 * (high - low).max(1e-12 * high.abs()).max(1e-15);
    Some(Chart {
        x_label: format!("time [{t_prefix}s]"),
        y_label: format!("{quantity} [{prefix}{unit}]"),
        x_range: (range.0 / t_factor, range.1 / t_factor),
        y_range: ((low - room) / factor, (high + room) / factor),
        lines,
        shaded: Vec::new(),
        level: level.map(|(value, name)| (value / factor, name)),
        marks: Vec::new(),
    })
}

fn extremes(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    (low <= high).then_some((low, high))
}

fn line(name: impl Into<String>, color: Rgb, pyramid: &Pyramid, range: (f64, f64)) -> Line {
    Line {
        name: name.into(),
        color,
        points: pyramid
            .draw(range.0, range.1, COLUMNS)
            .into_iter()
            .map(|[t, value]| (t, value))
            .collect(),
    }
}

fn uniform(name: &str, color: Rgb, trace: &Trace, values: &[f64], range: (f64, f64)) -> Line {
    line(
        name,
        color,
        &Pyramid::new(trace.t0, trace.dt, values),
        range,
    )
}

/// A recording's channel as it is laid over the simulation.
fn recorded(overlay: &Overlay, channel: Channel, range: (f64, f64)) -> Option<Line> {
    let recording = &overlay.recording;
    let alignment: &Alignment = &overlay.alignment;
    let times: Vec<f64> = recording.time.iter().map(|&t| alignment.time(t)).collect();
    let values: Vec<f64> = recording
        .channel(channel)?
        .iter()
        .map(|&value| alignment.value(channel, value))
        .collect();
    let color = OTHERS[overlay.color % OTHERS.len()];
    let pyramid = Pyramid::xy(&times, &values);
    Some(line(recording.name.clone(), color, &pyramid, range))
}

fn recordings(state: &State, channel: Channel, range: (f64, f64)) -> Vec<Line> {
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    visible
        .filter_map(|overlay| recorded(overlay, channel, range))
        .collect()
}

fn voltage(state: &State, trace: &Trace, range: (f64, f64)) -> Option<Chart> {
    let mut lines = vec![uniform("drive", BLACK, trace, &trace.voltage, range)];
    lines.extend(recordings(state, Channel::Voltage, range));
    against_time("V", "V", range, lines, None)
}

fn trajectory(state: &State, trace: &Trace, range: (f64, f64)) -> Option<Chart> {
    let mut lines = Vec::new();
    if let Some(ghost) = &state.ghost {
        let kept = &ghost.trace;
        lines.push(uniform("kept (A)", GREY, kept, &kept.proof_mass, range));
    }
    if state.view.show_cantilever && !trace.cantilever.is_empty() {
        lines.push(uniform("xc", GREY, trace, &trace.cantilever, range));
    }
    lines.push(uniform("xp", BLUE, trace, &trace.proof_mass, range));
    lines.extend(recordings(state, Channel::ProofMass, range));
    let level = trace.ground_level.map(|level| (level, "ground"));
    let mut chart = against_time("displacement", "m", range, lines, level)?;
    let scale = (chart.x_range.1 - chart.x_range.0) / (range.1 - range.0);
    let inside = |t: &f64| (range.0..=range.1).contains(t);
    chart.shaded = trace
        .contacts
        .iter()
        .filter(|contact| contact.1 >= range.0 && contact.0 <= range.1)
        .map(|contact| {
            (
                contact.0.max(range.0) * scale,
                contact.1.min(range.1) * scale,
            )
        })
        .collect();
    if let (true, Some((level, _))) = (state.view.show_events, chart.level) {
        let marked = trace
            .events
            .iter()
            .filter(|event| event.kind != EventKind::DriveStep && inside(&event.time));
        chart.marks = marked
            .map(|event| (event.time * scale, level, event.kind))
            .take(400)
            .collect();
    }
    Some(chart)
}

fn residual(state: &State, range: (f64, f64)) -> Option<Chart> {
    let snapshot = state.snapshot.as_ref()?;
    let lines = snapshot
        .comparisons
        .iter()
        .filter_map(|comparison| {
            let overlay = state
                .setup
                .overlays
                .iter()
                .find(|o| o.id == comparison.id)?;
            let pyramid = comparison.residual_pyramid.as_ref()?;
            let color = OTHERS[overlay.color % OTHERS.len()];
            Some(line(overlay.recording.name.clone(), color, pyramid, range))
        })
        .collect();
    against_time("residual", "m", range, lines, None)
}

fn forces(trace: &Trace, range: (f64, f64)) -> Option<Chart> {
    let forces = trace.forces.as_ref()?;
    let columns = [
        ("drive", &forces.drive),
        ("film", &forces.film),
        ("effects", &forces.effects),
        ("ground", &forces.ground),
        ("pull-off", &forces.pull_off),
        ("adhesion", &forces.adhesion),
    ];
    let lines = columns
        .into_iter()
        .zip(OTHERS)
        .filter(|((_, values), _)| values.iter().any(|&value| value != 0.0))
        .map(|((name, values), color)| uniform(name, color, trace, values, range))
        .collect();
    against_time("force", "N", range, lines, None)
}

fn phase_portrait(trace: &Trace, range: (f64, f64)) -> Option<Chart> {
    let axes = [("displacement xp", "m"), ("velocity vp", "m/s")];
    loop_chart(
        axes,
        &trace.proof_mass,
        &trace.proof_mass_velocity,
        trace,
        range,
    )
}

fn drive_loop(trace: &Trace, range: (f64, f64)) -> Option<Chart> {
    let axes = [("V", "V"), ("displacement xp", "m")];
    loop_chart(axes, &trace.voltage, &trace.proof_mass, trace, range)
}

/// One quantity against another; points closer than a pixel to the last are left out.
fn loop_chart(
    axes: [(&str, &str); 2],
    x: &[f64],
    y: &[f64],
    trace: &Trace,
    range: (f64, f64),
) -> Option<Chart> {
    let index = |t: f64| (((t - trace.t0) / trace.dt).max(0.0).round() as usize).min(x.len());
    let samples = index(range.0)..index(range.1);
    let (x, y) = (x.get(samples.clone())?, y.get(samples)?);
    let (x_low, x_high) = extremes(x.iter().copied())?;
    let (y_low, y_high) = extremes(y.iter().copied())?;
    let (x_prefix, x_factor) = prefix_for(x_low.abs().max(x_high.abs()), axes[0].1);
    let (y_prefix, y_factor) = prefix_for(y_low.abs().max(y_high.abs()), axes[1].1);
    let width = (x_high - x_low).max(1e-15);
    let height = (y_high - y_low).max(1e-15);
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut last = (f64::NAN, f64::NAN);
    for (&x, &y) in x.iter().zip(y) {
        let near = ((x - last.0) / width).abs() < 1e-3 && ((y - last.1) / height).abs() < 3e-3;
        if !near {
            last = (x, y);
            points.push((x / x_factor, y / y_factor));
        }
    }
    Some(Chart {
        x_label: format!("{} [{x_prefix}{}]", axes[0].0, axes[0].1),
        y_label: format!("{} [{y_prefix}{}]", axes[1].0, axes[1].1),
        x_range: (
            (x_low - 0.05 * width) / x_factor,
            (x_high + 0.05 * width) / x_factor,
        ),
        y_range: (
            (y_low - 0.05 * height) / y_factor,
            (y_high + 0.05 * height) / y_factor,
        ),
        lines: vec![Line {
            name: "simulation".to_owned(),
            color: BLUE,
            points,
        }],
        shaded: Vec::new(),
        level: None,
        marks: Vec::new(),
    })
}
