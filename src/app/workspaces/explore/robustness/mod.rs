//! The robustness panel: what is uncertain and what is wanted on the left, the map of probabilities
//! in the middle, the present drive and the search for a robust waveform on the right.

mod answer;
mod choices;
mod search;

use eframe::egui::{CentralPanel, Id, Panel, ScrollArea, Ui, UiBuilder, vec2};

use super::fields::{refusal, remark};
use crate::app::analysis::explore::robust::{map_question, point_question};
use crate::app::analysis::explore::source::drive_of;
use crate::app::plots::explore::plane::PlaneOutput;
use crate::app::plots::explore::{legend, robust};
use crate::app::state::State;
use crate::explore::map::Axis;
use crate::explore::robustness::RobustnessMap;
use crate::model::unit::format_quantity;

/// Widths of the choices, of the answers, and of the bar that scrolls them \[points\].
const CHOICES_WIDTH: f32 = 304.0;
const ANSWERS_WIDTH: f32 = 356.0;
const SCROLL_BAR_WIDTH: f32 = 10.0;

/// Draws the panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    let drive = drive_of(&state.setup, state.setup.explore.robustness.source);
    let asked = Panel::left("robustness choices")
        .exact_size(CHOICES_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("robustness choices")
                .auto_shrink([false, false])
                .show(ui, |ui| choices::show(ui, state, drive.as_ref().ok()))
                .inner
        })
        .inner;
    act(ui, state, asked, drive.as_ref());
    let refused = drive.err();
    Panel::right("robustness answers")
        .exact_size(ANSWERS_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("robustness answers")
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    // The scroll bar lies over what is at its edge.
                    ui.set_max_width(ui.available_width() - SCROLL_BAR_WIDTH);
                    answer::show(ui, state);
                    ui.separator();
                    // An id of its own, because the answer above comes and goes: else the focus
                    // of the keyboard is lost each time.
                    let own = UiBuilder::new().scope_id(Id::unique("robust search"));
                    ui.scope_builder(own, |ui| search::show(ui, state));
                });
        });
    CentralPanel::default().show(ui, |ui| match refused {
        Some(reason) => refusal(ui, &format!("No robustness: {reason}.")),
        None => picture(ui, state),
    });
}

/// Asks for the answer on the present drive, and begins what was pressed.
fn act(
    ui: &Ui,
    state: &mut State,
    is_map_asked: bool,
    drive: Result<&crate::model::drive::Waveform, &String>,
) {
    let robust = &mut state.exploring.robust;
    robust.map.poll();
    robust.search.poll();
    let Ok(drive) = drive else {
        return;
    };
    let of = (&state.setup.preset.model, drive);
    let choices = &state.setup.explore.robustness;
    let fit = state.fitting.result.as_deref();
    match point_question(choices, fit, of) {
        Ok(question) => {
            robust.refusal = None;
            robust.point.ask(question, ui.ctx());
        }
        Err(reason) => robust.refusal = Some(reason),
    }
    if is_map_asked {
        robust.start_map(map_question(choices, fit, of), ui.ctx());
    }
}

fn picture(ui: &mut Ui, state: &mut State) {
    let run = &state.exploring.robust.map;
    if let Some(error) = &run.error {
        refusal(ui, &format!("No map: {error}."));
        return;
    }
    let Some(growing) = run.growing().cloned() else {
        let text = "Press \"Compute the map\" to see over two numbers how likely the wanted \
                    response is. Each point is computed for every device of the ensemble.";
        remark(ui, text);
        return;
    };
    let grown = growing.lock();
    let room = ui.available_size();
    let height = (room.y - 76.0).max(100.0);
    let output = robust::show(ui, &grown.answer, grown.version, vec2(room.x, height));
    let text = under_pointer(&grown.answer, &output);
    remark(ui, &text);
    legend::scale(ui, &robust::probability_axis());
}

/// What the ensemble says of the point under the pointer.
fn under_pointer(map: &RobustnessMap, output: &PlaneOutput) -> String {
    let Some([x, y]) = output.hovered() else {
        return "Move the pointer over the map to read it. Hatched: impossible.".to_owned();
    };
    let along = |axis: &Axis, value: f64| {
        let last = axis.count.saturating_sub(1) as f64;
        axis.position(value).round().clamp(0.0, last) as usize
    };
    let (i, j) = (along(&map.axes[0], x), along(&map.axes[1], y));
    let at = |axis: &Axis, k: usize| {
        let value = format_quantity(axis.value(k), &axis.unit, 4);
        format!("{} {value}", axis.name)
    };
    let place = format!("{}, {}", at(&map.axes[0], i), at(&map.axes[1], j));
    let answer = match map.points.get(i + j * map.axes[0].count) {
        Some(Some(Ok(found))) => {
            let breaker = found.breaker.as_ref().map_or_else(String::new, |b| {
                let way = if b.difference > 0.0 { "high" } else { "low" };
                format!("; breaks first with {way} {}", b.id)
            });
            format!("{:.0} %{breaker}", 100.0 * found.probability)
        }
        Some(Some(Err(reason))) => format!("impossible: {reason}"),
        Some(None) | None => "not computed yet".to_owned(),
    };
    format!("{place}: {answer}")
}
