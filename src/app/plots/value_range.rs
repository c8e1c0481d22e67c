//! The values in view of a picture against time, and how the wheel and dragging on its vertical
//! axis change them. A range that a person chose stays until it is given up: the same residual is
//! then drawn at the same height while a slider is dragged.

use eframe::egui::{Button, CursorIcon, EventFilter, Id, Key, Response, StrokeKind, Ui};

use super::frame::time_plot::{Reply, TimePlot};
use crate::app::state::State;

/// Points of the wheel that change the span of the values by the factor e.
const WHEEL_POINTS: f32 = 220.0;
/// Factor on the span of one press of an arrow key.
const KEY_FACTOR: f64 = 1.25;
/// Shortest span of values in view, as a share of the larger of the two edges: more than the
/// rounding of a number on screen.
const MIN_RELATIVE_SPAN: f64 = 1e-7;
/// Longest span of values in view, and shortest near zero, SI. No quantity of the device is beyond.
const SPAN_LIMITS: (f64, f64) = (1e-18, 1e6);

/// What the pointer does on the axis.
const AXIS_HELP: &str = "Wheel: zoom in values (in the plot: Alt and wheel). Drag: move. \
     Double-click or Backspace: show all values. Up and down keys: zoom. \
     Right-click: keep this scale.";

/// How many steps the up and down keys ask to zoom in.
fn key_steps(ui: &Ui, axis: &Response) -> i32 {
    let filter = EventFilter {
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(axis.id, filter));
    let pressed = |key| ui.input(|input| input.num_presses(key)) as i32;
    pressed(Key::ArrowUp) - pressed(Key::ArrowDown)
}

/// Sets the range that the person chose for a picture.
pub fn choose(plot: &mut TimePlot, state: &State) {
    let chosen = state.view.value_ranges.get(&plot.scale);
    plot.chosen = chosen.copied().filter(|&range| is_valid(range));
}

/// Range of values to show on the scale of that name, where all of them are in view: during a drag
/// of whatever kind it grows at once, and shrinks only after it, so that a curve does not seem to
/// stay as it is while its axis changes. `window` is the time in view: another one begins anew.
pub fn held(ui: &Ui, scale: &str, window: (f64, f64), now: (f64, f64)) -> (f64, f64) {
    type Shown = ((f64, f64), (f64, f64));
    let id = Id::unique(("values shown", scale));
    // A slider is moved by keys as well.
    let dragging = ui.input(|input| input.pointer.any_down() || !input.keys_down.is_empty());
    let before: Option<Shown> = ui.data(|data| data.get_temp(id));
    let range = match before {
        Some((of, (low, high))) if dragging && of == window => (now.0.min(low), now.1.max(high)),
        _ => now,
    };
    ui.data_mut(|data| data.insert_temp(id, (window, range)));
    range
}

/// Lets a drag hold the values in view of a picture, unless the person chose them.
pub fn hold(ui: &Ui, plot: &mut TimePlot, window: (f64, f64)) {
    if plot.chosen.is_none() {
        plot.chosen = Some(held(ui, &plot.scale, window, plot.range(window)));
    }
}

/// Whether a range of values can be shown; SI.
pub fn is_valid((low, high): (f64, f64)) -> bool {
    let size = low.abs().max(high.abs());
    let least = SPAN_LIMITS.0.max(MIN_RELATIVE_SPAN * size);
    low.is_finite() && high.is_finite() && (least..=SPAN_LIMITS.1).contains(&(high - low))
}

/// Reacts to mouse and wheel over the axis of a plot. It takes the wheel before the zoom in time.
pub fn react(ui: &Ui, state: &mut State, reply: &Reply) {
    let (axis, frame) = (&reply.axis, reply.response.rect);
    let name = reply.scale.as_str();
    let (low, high) = reply.values;
    let span = high - low;
    let height = f64::from(frame.height());
    if height < 1.0 {
        return;
    }
    let mut range = None;
    if axis.dragged() {
        let shift = span * f64::from(axis.drag_delta().y) / height;
        range = (shift != 0.0).then_some((low + shift, high + shift));
    }
    let in_plot = reply.response.hover_pos();
    let with_alt = in_plot.filter(|_| ui.input(|input| input.modifiers.alt));
    if let Some(pointer) = axis.hover_pos().or(with_alt) {
        // Consumed, so that neither the time nor the area around the plot moves as well.
        let scroll = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta));
        let factor = f64::from((-scroll.y / WHEEL_POINTS).exp());
        if factor != 1.0 && factor.is_finite() {
            let fixed = high - span * f64::from(pointer.y - frame.top()) / height;
            range = Some((
                fixed - (fixed - low) * factor,
                fixed + (high - fixed) * factor,
            ));
        }
    }
    if axis.has_focus() {
        let steps = key_steps(ui, axis);
        if steps != 0 {
            let (middle, half) = (0.5 * (low + high), 0.5 * span);
            let half = half * KEY_FACTOR.powi(-steps);
            range = Some((middle - half, middle + half));
        }
        let ring = ui.visuals().selection.stroke;
        ui.painter()
            .rect_stroke(axis.rect, 2.0, ring, StrokeKind::Inside);
    }
    if let Some(range) = range.filter(|&range| is_valid(range)) {
        state.view.value_ranges.insert(name.to_owned(), range);
    }
    let reset = axis.has_focus() && ui.input(|input| input.key_pressed(Key::Backspace));
    if axis.double_clicked() || reset {
        state.view.release_values(name);
    }
    axis.context_menu(|ui| {
        if ui.button("Keep this scale").clicked() {
            state.view.fix_values(name, reply.values);
            ui.close();
        }
        let is_chosen = state.view.value_ranges.contains_key(name);
        let automatic = ui.add_enabled(is_chosen, Button::new("Automatic scale"));
        if automatic.clicked() {
            state.view.release_values(name);
            ui.close();
        }
    });
    if axis.hovered() || axis.dragged() {
        ui.set_cursor_icon(CursorIcon::ResizeVertical);
    }
    axis.clone().on_hover_text(AXIS_HELP);
}
