//! An interval of a recording: the measured position, and below it the residual before and
//! after on one scale.

use eframe::egui::{Event, Response, Ui};

use super::frame::{Axis, Figure, Item};
use super::{frame, residual_strip};
use crate::app::analysis::diagnosis_answer::{Answer, Used};
use crate::app::plots::frame::style;
use crate::app::state::State;
use crate::app::widgets::text::small;
use crate::app::workspaces::diagnose::colors;
use crate::app::workspaces::diagnose::words::role_text;
use crate::diagnose::diagnosis::Strip;
use crate::model::parameter::ParameterId;
use crate::recording::Recording;

/// A curve is drawn with at most this many columns; more than a screen can show.
const MAX_COLUMNS: usize = 900;
/// The residual plot is at least this high \[points\].
const MIN_PLOT_HEIGHT: f32 = 80.0;
/// Shortest interval that can be zoomed to \[s\].
const MIN_INTERVAL: f64 = 1e-4;

/// Draws the chosen recording.
pub fn show(ui: &mut Ui, state: &mut State, answer: &Answer) {
    let d = &answer.diagnosis;
    let look = &state.diagnosing.look;
    let chosen = |s: &&Strip| look.recording.as_ref() == Some(&(s.recording.clone(), s.held_out));
    let Some(strip) = d.strips.iter().find(chosen).or(d.strips.first()) else {
        ui.weak("No residuals over time are available.");
        return;
    };
    let Some(whole) = residual_strip::span(strip) else {
        ui.weak("This recording was not compared.");
        return;
    };
    let window = look.window.unwrap_or(whole);
    let zoomed = look.window.is_some();
    ui.horizontal_wrapped(|ui| {
        let kind = role_text(strip.held_out);
        ui.label(small(format!("{} ({kind})", strip.recording)).strong());
        let back = ui.add_enabled(zoomed, eframe::egui::Button::new(small("Whole recording")));
        if back.on_hover_text("Show the whole recording").clicked() {
            state.diagnosing.look.window = None;
        }
    });
    let room = ui.available_height() - 24.0;
    let upper = (0.38 * room).max(70.0);
    let measured = match answer.asked.find(&strip.recording) {
        Some(used) => {
            let level = ground(state, answer, used);
            Some(measured(ui, level, &used.recording, window, upper))
        }
        None => {
            // An answer of a session, whose file is missing or has changed.
            let text =
                "The recording is not open, or has changed since: only its residual is shown.";
            ui.label(small(text).color(ui.visuals().warn_fg_color));
            None
        }
    };
    if answer.is_thinned {
        let text = "The session has not every sample of the residual. Diagnose again to see each.";
        ui.label(small(text).weak());
    }
    frame::legend(ui, &frame::model_entries(ui, d));
    let residual = residual(
        ui,
        answer,
        strip,
        window,
        (ui.available_height() - 2.0).max(MIN_PLOT_HEIGHT),
    );
    for response in measured.into_iter().chain([residual]) {
        if let Some(moved) = moved(ui, &response, window, whole) {
            state.diagnosing.look.window = moved;
        }
    }
}

fn measured(
    ui: &mut Ui,
    ground: Option<f64>,
    recording: &Recording,
    window: (f64, f64),
    height: f32,
) -> Response {
    let points = thinned(recording, window);
    let values = points.iter().map(|p| p[1]);
    let mut items = Vec::new();
    if let Some(value) = ground {
        items.push(Item::Level {
            value,
            text: "ground",
            color: style::palette(ui).ground,
        });
    }
    let y = Axis::holding("xp", "m", values);
    items.push(Item::Line {
        points,
        color: style::palette(ui).text,
        width: 1.2,
        dashed: false,
    });
    Figure {
        height,
        has_x: false,
        ..over_time("recording over time", window, y, items)
    }
    .show(ui)
}

fn residual(
    ui: &mut Ui,
    answer: &Answer,
    strip: &Strip,
    window: (f64, f64),
    height: f32,
) -> Response {
    let d = &answer.diagnosis;
    if let Some(items) = samples(ui, strip, window, !d.named.is_empty()) {
        return of_samples(ui, (answer, strip), window, height, items);
    }
    let line = |values: &[f64]| -> Vec<[f64; 2]> {
        strip
            .time
            .iter()
            .zip(values)
            .map(|(t, v)| [*t, *v])
            .collect()
    };
    let noise = noise_of(answer, strip);
    // One scale for the whole recording, so that an interval can be compared with the rest.
    let all = strip.before.iter().chain(&strip.after).copied();
    let y = Axis::holding_log("rms residual", "m", all.chain([0.6 * noise, 3.0 * noise]));
    let mut items = vec![
        Item::Level {
            value: noise,
            text: "noise",
            color: colors::noise(ui),
        },
        Item::Line {
            points: line(&strip.before),
            color: colors::before(ui),
            width: 1.6,
            dashed: false,
        },
    ];
    if !d.named.is_empty() {
        items.push(Item::Line {
            points: line(&strip.after),
            color: colors::after(ui),
            width: 1.6,
            dashed: false,
        });
    }
    let mut all = shades(ui, answer, strip);
    all.append(&mut items);
    Figure {
        log: true,
        height,
        ..over_time("residual over time", window, y, all)
    }
    .show(ui)
}

/// A plot over the time in view, of the least height.
fn over_time<'a>(name: &'a str, window: (f64, f64), y: Axis<'a>, items: Vec<Item>) -> Figure<'a> {
    Figure {
        name,
        x: Axis {
            quantity: "time t",
            base: "s",
            range: window,
        },
        y,
        log: false,
        height: MIN_PLOT_HEIGHT,
        has_x: true,
        items,
    }
}

/// The intervals of mismatch of a recording, as shaded areas.
fn shades(ui: &Ui, answer: &Answer, strip: &Strip) -> Vec<Item> {
    let color = ui.visuals().selection.bg_fill.gamma_multiply(0.22);
    let all = answer.diagnosis.mismatch.iter();
    all.filter(|m| m.recording == strip.recording)
        .map(|m| Item::Shade {
            from: m.start,
            to: m.end,
            color,
        })
        .collect()
}

/// Noise of a recording \[m\], or of all recordings if its own is unknown.
fn noise_of(answer: &Answer, strip: &Strip) -> f64 {
    let d = &answer.diagnosis;
    let mut proofs = d.proof.iter();
    let proof = proofs.find(|p| p.recording == strip.recording && p.held_out == strip.held_out);
    proof.map_or(d.noise, |p| p.noise)
}

/// The residual of every sample in view, or `None` if there are too many to see each.
fn samples(ui: &Ui, strip: &Strip, (from, to): (f64, f64), named: bool) -> Option<Vec<Item>> {
    let inside = |all: &[[f64; 2]]| {
        let first = all.partition_point(|p| p[0] < from);
        let last = all.partition_point(|p| p[0] <= to);
        all[first..last.max(first)].to_vec()
    };
    let before = inside(&strip.samples_before);
    let known = before.iter().filter(|p| p[1].is_finite()).count();
    if known < 2 || before.len() > MAX_COLUMNS {
        return None;
    }
    let line = |points, color| Item::Line {
        points,
        color,
        width: 1.0,
        dashed: false,
    };
    let mut items = vec![line(before, colors::before(ui))];
    if named {
        items.push(line(inside(&strip.samples_after), colors::after(ui)));
    }
    Some(items)
}

/// Plots the residuals of single samples between lines at plus and minus the noise.
fn of_samples(
    ui: &mut Ui,
    (answer, strip): (&Answer, &Strip),
    window: (f64, f64),
    height: f32,
    mut lines: Vec<Item>,
) -> Response {
    let noise = noise_of(answer, strip);
    let values = lines.iter().flat_map(|item| match item {
        Item::Line { points, .. } => points.iter().map(|p| p[1]).collect(),
        _ => Vec::new(),
    });
    let values = values.filter(|v| v.is_finite());
    let y = Axis::holding("residual", "m", values.chain([-3.0 * noise, 3.0 * noise]));
    let mut items = shades(ui, answer, strip);
    let color = colors::noise(ui);
    for (value, text) in [(noise, "noise"), (-noise, "")] {
        items.push(Item::Level { value, text, color });
    }
    items.append(&mut lines);
    Figure {
        height,
        ..over_time("residual over time", window, y, items)
    }
    .show(ui)
}

/// The ground level \[m\]: measured in this recording, or else that of the re-tuned model.
fn ground(state: &State, answer: &Answer, used: &Used) -> Option<f64> {
    let snapshot = state.snapshot.as_ref()?;
    let compared = snapshot.comparisons.iter().find(|c| c.id == used.id);
    let measured = compared
        .and_then(|c| c.features.as_ref())
        .and_then(|f| f.contact_level.as_ref().ok().copied());
    let model = &answer.diagnosis.baseline;
    let modelled = model.parameters[ParameterId::OffsetP] - model.parameters[ParameterId::Dp];
    measured.or(model.has_ground.then_some(modelled))
}

/// The samples in view, or the minimum and maximum of each column if there are many.
fn thinned(recording: &Recording, (from, to): (f64, f64)) -> Vec<[f64; 2]> {
    let time = &recording.time;
    let first = time.partition_point(|t| *t < from).saturating_sub(1);
    let last = (time.partition_point(|t| *t <= to) + 1).min(time.len());
    let values = &recording.proof_mass[first..last.max(first)];
    let times = &time[first..last.max(first)];
    if values.len() <= 2 * MAX_COLUMNS {
        return times.iter().zip(values).map(|(t, x)| [*t, *x]).collect();
    }
    let step = values.len().div_ceil(MAX_COLUMNS);
    times
        .chunks(step)
        .zip(values.chunks(step))
        .flat_map(|(t, x)| {
            let known = x.iter().copied().filter(|x| x.is_finite());
            let (low, high) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
                (a.min(v), b.max(v))
            });
            if low > high {
                return [[t[0], f64::NAN], [t[0], f64::NAN]];
            }
            let rising = x.first() <= x.last();
            let (a, b) = if rising { (low, high) } else { (high, low) };
            [[t[0], a], [t[t.len() - 1], b]]
        })
        .collect()
}

/// The interval to show after a drag, the wheel or a double click. `None` if nothing was done,
/// `Some(None)` for the whole recording.
fn moved(
    ui: &Ui,
    response: &Response,
    (from, to): (f64, f64),
    whole: (f64, f64),
) -> Option<Option<(f64, f64)>> {
    if response.double_clicked() {
        return Some(None);
    }
    let width = f64::from(response.rect.width()).max(1.0);
    let span = to - from;
    let limit = |a: f64, b: f64| {
        let length = (b - a).clamp(MIN_INTERVAL, whole.1 - whole.0);
        let a = a.clamp(whole.0, whole.1 - length);
        Some((a, a + length))
    };
    if response.dragged() {
        let shift = -f64::from(response.drag_delta().x) / width * span;
        return Some(limit(from + shift, to + shift));
    }
    let at = response.hover_pos()?;
    let wheel: f32 = ui.input(|input| {
        let turns = input.events.iter().filter_map(|event| match event {
            Event::MouseWheel {
                delta, modifiers, ..
            } if modifiers.is_none() => Some(delta.y),
            _ => None,
        });
        turns.sum()
    });
    if wheel == 0.0 {
        return None;
    }
    let factor = 0.8f64.powf(f64::from(wheel.clamp(-3.0, 3.0)));
    let share = f64::from(at.x - response.rect.left()) / width;
    let pivot = from + share * span;
    let length = (span * factor).clamp(MIN_INTERVAL, whole.1 - whole.0);
    let a = pivot - share * length;
    Some(limit(a, a + length))
}
