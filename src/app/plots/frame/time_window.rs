//! The time in view, and how dragging, the wheel and clicks change it and the cursors.

use eframe::egui::{Id, Modifiers, PointerButton, Ui};

use super::axes::union;
use super::time_plot::Reply;
use crate::app::simulation::snapshot::LiveState;
use crate::app::state::{Cursors, State};

/// Shortest time span that can be shown \[s\].
const MIN_SPAN: f64 = 1e-7;

/// First and last simulated time \[s\].
fn simulated(state: &State) -> Option<(f64, f64)> {
    let trace = &state.snapshot.as_ref()?.trace;
    let span = (trace.t0, trace.end());
    let usable = !trace.is_empty() && span.0.is_finite() && span.1.is_finite();
    usable.then_some(span)
}

/// First and last time of the visible recordings, as aligned \[s\].
pub fn recorded(state: &State) -> Option<(f64, f64)> {
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    union(visible.map(|overlay| {
        let (first, last) = overlay.recording.span();
        (overlay.alignment.time(first), overlay.alignment.time(last))
    }))
}

/// How far the live run is, if there is one.
fn live(state: &State) -> Option<LiveState> {
    state.snapshot.as_ref()?.live
}

/// Latest time in view of a live run \[s\].
fn live_end(state: &State, live: &LiveState) -> f64 {
    let oldest = live.history_start.min(live.time);
    state.scrub.unwrap_or(live.time).clamp(oldest, live.time)
}

/// All of the simulation, or of the recordings without one.
fn all(state: &State) -> (f64, f64) {
    simulated(state)
        .filter(|(from, to)| to > from)
        .or_else(|| recorded(state))
        .unwrap_or((0.0, state.setup.duration.max(MIN_SPAN)))
}

/// The time that the person chose to look at \[s\]; `None` for all of it.
pub fn chosen(state: &State) -> Option<(f64, f64)> {
    state
        .view
        .time_range
        .filter(|(from, to)| from.is_finite() && to.is_finite() && to > from)
}

/// Time in view \[s\]. A live run is shown up to the right edge.
pub fn in_view(state: &State) -> (f64, f64) {
    let chosen = chosen(state);
    if let Some(live) = live(state) {
        let end = live_end(state, &live);
        let width = chosen.map_or(state.setup.duration, |(from, to)| to - from);
        let width = width.max(MIN_SPAN);
        // A young run grows from the left until the view is full.
        let from = (end - width).max(live.history_start.min(end));
        return (from, from + width);
    }
    chosen.unwrap_or_else(|| all(state))
}

/// First and last time of simulation and recordings together \[s\].
fn widest(state: &State) -> (f64, f64) {
    union([simulated(state), recorded(state)].into_iter().flatten()).unwrap_or_else(|| all(state))
}

/// Longest time span that can be shown \[s\].
fn longest(state: &State) -> f64 {
    let (first, last) = widest(state);
    match live(state) {
        Some(_) => state.setup.duration.max(MIN_SPAN),
        None => (1.2 * (last - first)).max(MIN_SPAN),
    }
}

/// Shows `from` to `to` \[s\], limited to times with something to see.
fn look_at(state: &mut State, from: f64, to: f64) {
    let live = live(state);
    let widest = widest(state);
    let width = (to - from).clamp(MIN_SPAN, longest(state));
    let middle = 0.5 * (from + to);
    let (mut from, mut to) = (middle - 0.5 * width, middle + 0.5 * width);
    if let Some(live) = live {
        // Going back in time is scrubbing; at the newest time the view follows the run.
        to = to.clamp(live.history_start.min(live.time), live.time);
        from = to - width;
        let following = state.scrub.is_none() && !live.paused;
        let back = live.time - to > 1e-3 * width;
        if back || !following {
            state.scrub = back.then_some(to);
        }
    } else {
        // A tenth of the view keeps showing curves.
        let (first, last) = (widest.0 - 0.9 * width, widest.1 + 0.9 * width);
        let shift = (first - from).max(0.0) - (to - last).max(0.0);
        (from, to) = (from + shift, to + shift);
    }
    state.view.time_range = Some((from, to));
}

/// Shows the whole simulation; the second time also the recordings beyond it.
fn show_all(state: &mut State) {
    // A zoom of the values is undone first.
    if state.view.zoom_out_values() && state.view.time_range.is_none() {
        return;
    }
    let all = all(state);
    let widest = union([all].into_iter().chain(recorded(state)));
    let more = widest.filter(|&widest| widest != all && live(state).is_none());
    state.view.time_range = match state.view.time_range {
        None => more,
        Some(_) => None,
    };
    if live(state).is_some() {
        state.scrub = None;
    }
}

/// Reacts to mouse and keys over a plot against time.
pub fn react(ui: &Ui, state: &mut State, reply: &Reply) {
    let Reply {
        response, window, ..
    } = reply;
    let (from, to) = *window;
    let rect = response.rect;
    if rect.width() < 1.0 {
        return;
    }
    let seconds = (to - from) / f64::from(rect.width());
    let time_at = |x: f32| from + f64::from(x - rect.left()) * seconds;
    if response.dragged_by(PointerButton::Primary) || response.dragged_by(PointerButton::Middle) {
        let shift = -f64::from(response.drag_delta().x) * seconds;
        if shift != 0.0 {
            look_at(state, from + shift, to + shift);
        }
    }
    let Some(pointer) = response.hover_pos().filter(|pos| rect.contains(*pos)) else {
        return;
    };
    let time = time_at(pointer.x);
    state.cursors.hover = Some(time);
    zoom(ui, state, (from, to), time);
    // The first click of a double click has moved a cursor; that is undone.
    let before = Id::unique("cursors before click");
    if response.double_clicked() {
        // Both clicks may come in one frame: then there is nothing to undo.
        let stored = ui.data_mut(|data| data.remove_temp::<(Option<f64>, Option<f64>)>(before));
        if let Some(cursors) = stored {
            (state.cursors.first, state.cursors.second) = cursors;
        }
        show_all(state);
    } else if response.clicked() && !response.triple_clicked() {
        let Cursors { first, second, .. } = state.cursors;
        ui.data_mut(|data| data.insert_temp(before, (first, second)));
        if ui.input(|input| input.modifiers.contains(Modifiers::SHIFT)) {
            state.cursors.second = Some(time);
        } else {
            state.cursors.first = Some(time);
        }
    }
}

fn zoom(ui: &Ui, state: &mut State, (from, to): (f64, f64), time: f64) {
    let (scroll, pinch) = ui.input_mut(|input| {
        // Consumed, so that the area around the plot does not scroll as well.
        let scroll = std::mem::take(&mut input.smooth_scroll_delta);
        (scroll, input.zoom_delta())
    });
    if scroll.x != 0.0 {
        let shift = -f64::from(scroll.x) / 600.0 * (to - from);
        look_at(state, from + shift, to + shift);
    }
    let factor = f64::from((-scroll.y / 220.0).exp() / pinch);
    // At the widest and the narrowest view nothing moves.
    let width = (to - from).max(MIN_SPAN);
    let factor = factor.clamp(MIN_SPAN / width, (longest(state) / width).max(1.0));
    if factor != 1.0 && factor.is_finite() {
        let following = live(state).is_some_and(|live| state.scrub.is_none() && !live.paused);
        let fixed = if following { to } else { time };
        look_at(
            state,
            fixed - (fixed - from) * factor,
            fixed + (to - fixed) * factor,
        );
    }
}
