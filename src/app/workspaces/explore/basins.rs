//! The basin panel: starts on the left, basins in the middle with the shares of the responses.

use eframe::egui::{CentralPanel, Panel, ScrollArea, Ui, vec2};

use super::fields::{Row, name, refusal, remark, source, within};
use super::progress;
use crate::app::analysis::explore::source::drive_of;
use crate::app::analysis::explore::sweeping::basin_request;
use crate::app::plots::explore::basin::{self, response_color};
use crate::app::plots::explore::legend;
use crate::app::plots::explore::plane::PlaneOutput;
use crate::app::setup::explore::BasinChoices;
use crate::app::state::State;
use crate::app::widgets::text::heading;
use crate::explore::basin::{BasinMap, BasinPoint, BasinRequest, BasinResponse};
use crate::model::drive::Waveform;
use crate::model::unit::{counted, format_quantity};

/// Width of the controls \[points\].
const CONTROLS_WIDTH: f32 = 286.0;
/// Starts along each direction that can be asked for.
const START_COUNTS: (f64, f64) = (2.0, 1000.0);

/// Draws the panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    let drive = drive_of(&state.setup, state.setup.explore.basins.source);
    let again = Panel::left("basin controls")
        .exact_size(CONTROLS_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("basin controls")
                .auto_shrink([false, false])
                .show(ui, |ui| controls(ui, state, drive.as_ref().ok()))
                .inner
        })
        .inner;
    let request = drive.and_then(|drive| {
        let of = (&state.setup.preset.model, &drive);
        basin_request(&state.setup.explore.basins, of).map_err(|error| error.to_string())
    });
    state.exploring.basins.update(request, again, ui.ctx());
    CentralPanel::default().show(ui, |ui| picture(ui, state));
}

/// The controls; returns whether the basins are to be computed again.
fn controls(ui: &mut Ui, state: &mut State, drive: Option<&Waveform>) -> bool {
    let choices = &mut state.setup.explore.basins;
    if let Some(chosen) = source(ui, choices.source) {
        choices.source = chosen;
    }
    if let Some(drive) = drive {
        remark(ui, &drive.to_string());
    }
    starts(ui, choices);
    ui.separator();
    let basins = &mut state.exploring.basins;
    let asked = progress::show(ui, &basins.run, basins.is_stopped, |grown| {
        let points = &grown.answer.points;
        let done = points.iter().filter(|p| **p != BasinPoint::Pending).count();
        format!("{done} of {}", counted(points.len(), "start"))
    });
    if asked == progress::Asked::Stop {
        basins.is_stopped = true;
        basins.run.stop();
    }
    ui.separator();
    if let Some(growing) = basins.run.growing() {
        shares(ui, &growing.lock().answer);
    }
    asked == progress::Asked::Again
}

fn starts(ui: &mut Ui, choices: &mut BasinChoices) {
    ui.horizontal(|ui| {
        name(ui, "Starts", "What differs from start to start");
        let kinds = [
            (
                false,
                "state",
                "Initial displacement and velocity of the mass, the drive switched on at one phase",
            ),
            (
                true,
                "phase",
                "Phase at which the drive is switched on, from rest",
            ),
        ];
        for (kind, text, help) in kinds {
            ui.selectable_value(&mut choices.over_phase, kind, text)
                .on_hover_text(help);
        }
    });
    if !choices.over_phase {
        let (x, v) = (&mut choices.displacement, &mut choices.velocity);
        let rows = [
            ("lowest initial displacement", "xp from", &mut x.0, "m"),
            ("highest initial displacement", "xp to", &mut x.1, "m"),
            ("lowest initial velocity", "xp' from", &mut v.0, "m/s"),
            ("highest initial velocity", "xp' to", &mut v.1, "m/s"),
        ];
        for (label, name, value, unit) in rows {
            let row = Row {
                label,
                name,
                help: "Range of the starts; a start must lie above the ground",
                value: *value,
                unit,
            };
            let finite = |v: f64| (!v.is_finite()).then(|| "give a finite number".to_owned());
            if let Some(new) = row.show(ui, finite) {
                *value = new;
            }
        }
        let row = Row {
            label: "phase of switching on",
            name: "Switched on",
            help: "Phase of the drive at the start, as a share of its period",
            value: choices.switched_on,
            unit: "",
        };
        if let Some(new) = row.show(ui, |v| within(v, 0.0, 0.999_999, "the phase")) {
            choices.switched_on = new;
        }
    }
    let row = Row {
        label: "starts along each direction",
        name: "Points",
        help: "Starts along each direction; each is a whole transient",
        value: choices.points as f64,
        unit: "",
    };
    let (fewest, most) = START_COUNTS;
    if let Some(points) = row.show(ui, |v| within(v, fewest, most, "points")) {
        choices.points = points.round() as usize;
    }
}

/// Responses with the shares of the starts that lead to them.
fn shares(ui: &mut Ui, map: &BasinMap) {
    heading(ui, "Responses, share of the starts");
    for (number, response) in map.responses.iter().enumerate() {
        let share = format!("{:.1} %", 100.0 * response.share);
        legend::entry(ui, response_color(number), &title(response), &share);
    }
    if map.responses.len() == 1 {
        remark(
            ui,
            "All starts lead to one response: a kick does not change it.",
        );
    }
    if !map.holes.is_empty() {
        let holes = counted(map.holes.len(), "start");
        remark(
            ui,
            &format!("Hatched: {holes} impossible; the pointer shows why."),
        );
    }
    let text = "The share of a response is its robustness against kicks: the part of all starts \
                from which the device comes back to it.";
    remark(ui, text);
}

/// A response in a few words.
fn title(response: &BasinResponse) -> String {
    match response.multiple {
        Some(1) => response.regime.label(),
        Some(n) => format!("{}, every {n} periods", response.regime.label()),
        None => "does not repeat".to_owned(),
    }
}

fn picture(ui: &mut Ui, state: &mut State) {
    let run = &state.exploring.basins.run;
    if let Some(error) = &run.error {
        refusal(ui, &format!("No basins: {error}."));
        return;
    }
    let (Some(growing), Some(request)) = (run.growing().cloned(), run.asked().cloned()) else {
        ui.spinner();
        return;
    };
    let grown = growing.lock();
    let room = ui.available_size();
    let height = if request.shape().1 == 1 {
        // A strip is enough for one direction.
        room.y.min(160.0)
    } else {
        room.y - 20.0
    };
    let of = (&*request, &grown.answer);
    let output = basin::show(ui, of, grown.version, vec2(room.x, height));
    let text = under_pointer(&request, &grown.answer, &output);
    remark(ui, &text);
}

/// The start under the pointer, and where it leads.
fn under_pointer(request: &BasinRequest, map: &BasinMap, output: &PlaneOutput) -> String {
    let Some([x, y]) = output.hovered() else {
        return "Move the pointer over the picture to see where a start leads.".to_owned();
    };
    let axes = basin::start_axes(request);
    let along = |value: f64, (low, high): (f64, f64), count: usize| {
        let last = count.saturating_sub(1) as f64;
        ((value - low) / (high - low) * last)
            .round()
            .clamp(0.0, last) as usize
    };
    let i = along(x, axes[0].range, map.shape.0);
    let j = if map.shape.1 > 1 {
        along(y, axes[1].range, map.shape.1)
    } else {
        0
    };
    let index = i + j * map.shape.0;
    let start = match request.beginning(index) {
        (Some((x, v)), _) => format!(
            "xp = {}, xp' = {}",
            format_quantity(x, "m", 3),
            format_quantity(v, "m/s", 3)
        ),
        (None, phase) => format!("switched on at {:.1} % of the period", 100.0 * phase),
    };
    let leads = match map.points.get(index) {
        Some(BasinPoint::Response(number)) => match map.responses.get(*number) {
            Some(response) => title(response),
            None => "a response that is being told apart".to_owned(),
        },
        Some(BasinPoint::Hole) => {
            let reason = map.holes.get(&index).map_or("", String::as_str);
            format!("impossible: {reason}")
        }
        Some(BasinPoint::Pending) | None => "not followed yet".to_owned(),
    };
    format!("{start}: {leads}")
}
