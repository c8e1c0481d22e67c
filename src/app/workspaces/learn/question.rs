//! Questions of a step: by choosing, by a mark, by a curve. The prediction is laid over the run,
//! and then it is said why.

use eframe::egui::{Button, Id, Key, RichText, Ui, vec2};

use super::words::{TEXT_SIZE, hint, paragraphs, strong, verdict};
use crate::app::analysis::learning::{OpenStep, Phase};
use crate::app::theme;
use crate::app::widgets::slider_track::SliderTrack;
use crate::learn::lesson::{Choice, CurveTask, Mark, Written};
use crate::model::unit::format_quantity;

/// Keys that choose an answer, in its order.
const ANSWER_KEYS: [Key; 6] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
];

/// A choice: one answer of several.
pub(super) fn choice(ui: &mut Ui, open: &mut OpenStep, choice: &Choice, written: &Written) {
    strong(ui, &written.question);
    let is_predicting = open.phase == Phase::Predicting;
    for (i, option) in written.options.iter().enumerate() {
        let is_chosen = open.draft.choice == Some(i);
        let is_right = open.phase == Phase::Seen && i == choice.right;
        let mut text = RichText::new(format!("{}  {option}", i + 1)).size(TEXT_SIZE);
        if is_right {
            text = text.color(theme::good(ui.visuals().dark_mode)).strong();
        }
        let button = Button::new(text).selected(is_chosen).wrap();
        let button = button.min_size(vec2(ui.available_width(), 28.0));
        let clicked = ui.add_enabled(is_predicting, button).clicked();
        let key = ANSWER_KEYS.get(i);
        let pressed = key.is_some_and(|key| ui.input(|input| input.key_pressed(*key)));
        if is_predicting && (clicked || (pressed && !ui.ctx().text_edit_focused())) {
            open.draft.choice = Some(i);
        }
    }
    if is_predicting {
        hint(
            ui,
            "Choose by a click or by its number, then Predict (Enter).",
        );
    }
    outcome(ui, open, written);
}

/// An arrow key that was pressed while nothing has the focus: the slider gets it. Returns the step
/// of that first key.
fn first_arrow(ui: &Ui, slider: Id) -> Option<f64> {
    if ui.memory(|memory| memory.focused().is_some()) {
        return None;
    }
    let pressed = |key| ui.input(|input| input.key_pressed(key));
    let steps = match () {
        () if pressed(Key::ArrowRight) || pressed(Key::ArrowUp) => 1.0,
        () if pressed(Key::ArrowLeft) || pressed(Key::ArrowDown) => -1.0,
        () => return None,
    };
    ui.memory_mut(|memory| memory.request_focus(slider));
    Some(steps)
}

/// A mark that is moved to a value.
pub(super) fn mark(ui: &mut Ui, open: &mut OpenStep, mark: &Mark, written: &Written) {
    strong(ui, &written.question);
    let is_predicting = open.phase == Phase::Predicting;
    let value = open.draft.mark;
    let text = mark.text(value);
    ui.label(RichText::new(format!("{}: {text}", mark.label)).size(TEXT_SIZE));
    let (low, high) = mark.range;
    let id = Id::unique("mark of a lesson");
    if is_predicting && let Some(steps) = first_arrow(ui, id) {
        open.draft.move_mark(mark, steps);
    }
    let track = SliderTrack {
        id,
        label: &mark.label,
        text: &text,
        numeric: (value, low, high),
        fraction: (value - low) / (high - low),
        mark: None,
        extrapolated_from: 1.0,
        enabled: is_predicting,
        error: false,
        size: vec2(ui.available_width(), 24.0),
    };
    let moved = track.show(ui);
    if let Some(fraction) = moved.fraction {
        open.draft.set_mark(mark, low + fraction * (high - low));
    }
    if let Some(value) = moved.value {
        open.draft.set_mark(mark, value);
    }
    if is_predicting {
        hint(
            ui,
            "Drag the slider or the dashed line in the plot, or use the arrow keys; then Predict.",
        );
        if moved.response.has_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
            open.predict();
        }
    }
    outcome(ui, open, written);
}

/// A curve that is drawn.
pub(super) fn curve(ui: &mut Ui, open: &mut OpenStep, task: &CurveTask, written: &Written) {
    strong(ui, &written.question);
    if open.phase == Phase::Predicting {
        let last = task.points.saturating_sub(1);
        let point = open.draft.point.min(last);
        let time = open.scene.duration * point as f64 / last.max(1) as f64;
        ui.horizontal(|ui| {
            if ui
                .add_enabled(point > 0, Button::new("Previous point"))
                .clicked()
            {
                open.draft.point = point.saturating_sub(1);
            }
            if ui
                .add_enabled(point < last, Button::new("Next point"))
                .clicked()
            {
                open.draft.point = (point + 1).min(last);
            }
            let at = format_quantity(time, "s", 3);
            ui.label(format!("{} of {} at {at}", point + 1, task.points));
        });
        let value = open.draft.curve.get(point).copied().unwrap_or_default();
        let (low, high) = task.range;
        let unit = open.scene.preset.model.coordinate.base_unit();
        let text = format_quantity(value, unit, 3);
        let id = Id::unique("point of a curve");
        // Its slider then has the focus, and takes the next one.
        let _ = first_arrow(ui, id);
        let track = SliderTrack {
            id,
            label: "height of the point",
            text: &text,
            numeric: (value, low, high),
            fraction: (value - low) / (high - low),
            mark: None,
            extrapolated_from: 1.0,
            enabled: true,
            error: false,
            size: vec2(ui.available_width(), 24.0),
        };
        let moved = track.show(ui);
        let by_track = moved.fraction.map(|fraction| low + fraction * (high - low));
        if let Some(reading) = by_track.or(moved.value) {
            open.draft.set_point(task, point, reading);
        }
        hint(
            ui,
            "Draw in the plot with the pointer. By keys: the arrows move a point, . and , go to the next and to the one before. Predict when it is done.",
        );
        if moved.response.has_focus() {
            let pressed = |key| ui.input(|input| input.key_pressed(key));
            if pressed(Key::Period) {
                open.draft.point = (point + 1).min(last);
            } else if pressed(Key::Comma) {
                open.draft.point = point.saturating_sub(1);
            }
        }
        if moved.response.has_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
            open.predict();
        }
    }
    outcome(ui, open, written);
}

/// What came out, once it was seen.
fn outcome(ui: &mut Ui, open: &OpenStep, written: &Written) {
    match open.phase {
        Phase::Predicting => {}
        Phase::Watching => {
            ui.add_space(6.0);
            ui.weak("Watch. The answer comes at the end of the run.");
        }
        Phase::Seen => {
            ui.add_space(8.0);
            if let Some(scored) = &open.scored {
                verdict(ui, scored);
            }
            ui.add_space(4.0);
            paragraphs(ui, &written.because);
        }
    }
}
