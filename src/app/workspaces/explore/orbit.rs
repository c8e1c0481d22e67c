//! The orbit panel: what is swept on the left, the diagram on the right.

use eframe::egui::{CentralPanel, Panel, ScrollArea, Ui};

use super::axis_picker::AxisPicker;
use super::fields::{Row, name, refusal, remark, source, within};
use super::progress;
use crate::app::analysis::explore::source::drive_of;
use crate::app::analysis::explore::sweeping::orbit_request;
use crate::app::plots::explore::legend;
use crate::app::plots::explore::orbit::{COEXISTING_SHARE, OrbitPicture, way_colors};
use crate::app::setup::explore::OrbitQuantity;
use crate::app::state::State;
use crate::explore::orbit::{OrbitDiagram, OrbitSlice};
use crate::model::drive::Waveform;
use crate::model::unit::{counted, format_quantity};

/// Width of the controls \[points\].
const CONTROLS_WIDTH: f32 = 286.0;
/// Values of the axis that can be asked for.
const VALUE_COUNTS: (f64, f64) = (2.0, 1000.0);

/// Draws the panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    let drive = drive_of(&state.setup, state.setup.explore.orbit.source);
    let again = Panel::left("orbit controls")
        .exact_size(CONTROLS_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("orbit controls")
                .auto_shrink([false, false])
                .show(ui, |ui| controls(ui, state, drive.as_ref().ok()))
                .inner
        })
        .inner;
    let request = drive.and_then(|drive| {
        let of = (&state.setup.preset.model, &drive);
        orbit_request(&state.setup.explore.orbit, of).map_err(|error| error.to_string())
    });
    state.exploring.orbit.update(request, again, ui.ctx());
    CentralPanel::default().show(ui, |ui| picture(ui, state));
}

/// The controls; returns whether the diagram is to be computed again.
fn controls(ui: &mut Ui, state: &mut State, drive: Option<&Waveform>) -> bool {
    let choices = &mut state.setup.explore.orbit;
    if let Some(chosen) = source(ui, choices.source) {
        choices.source = chosen;
    }
    if let Some(drive) = drive {
        remark(ui, &drive.to_string());
        let picker = AxisPicker {
            title: "Swept",
            scope: "orbit",
            of: (&state.setup.preset.model, drive),
        };
        picker.show(ui, &mut choices.axis);
    }
    let row = Row {
        label: "values of the sweep",
        name: "Values",
        help: "How many values the number takes on its way",
        value: choices.points as f64,
        unit: "",
    };
    let (fewest, most) = VALUE_COUNTS;
    if let Some(points) = row.show(ui, |v| within(v, fewest, most, "values")) {
        choices.points = points.round() as usize;
    }
    ui.horizontal_wrapped(|ui| {
        name(ui, "Points", "What is drawn over each value");
        let kinds = [
            (
                OrbitQuantity::Displacement,
                "displacement",
                "Displacement of the mass once in each period of the drive",
            ),
            (
                OrbitQuantity::ImpactSpeed,
                "impact speed",
                "Speed of each arrival at the ground",
            ),
            (
                OrbitQuantity::Bounces,
                "bounces",
                "Bounces in each period of the drive",
            ),
        ];
        for (kind, text, help) in kinds {
            ui.selectable_value(&mut choices.shown, kind, text)
                .on_hover_text(help);
        }
    });
    ui.separator();
    let orbit = &mut state.exploring.orbit;
    let asked = progress::show(ui, &orbit.run, orbit.is_stopped, |grown| {
        let done = grown.answer.up.len() + grown.answer.down.len();
        counted(done, "steady state")
    });
    if asked == progress::Asked::Stop {
        orbit.is_stopped = true;
        orbit.run.stop();
    }
    ui.separator();
    let [up, down] = way_colors(ui);
    legend::entry(ui, up, "on the way up", "");
    legend::entry(ui, down, "on the way down", "");
    let text = "Each value begins with the state in which the one before ended. Shaded: both ways \
                lead to different responses, which coexist. One point: it repeats each period; two: \
                every second; a cloud: it does not repeat. A Lyapunov exponent above 0 is chaos.";
    remark(ui, text);
    asked == progress::Asked::Again
}

fn picture(ui: &mut Ui, state: &mut State) {
    if let Some(error) = &state.exploring.orbit.run.error {
        refusal(ui, &format!("No diagram: {error}."));
        return;
    }
    let Some(growing) = state.exploring.orbit.run.growing().cloned() else {
        ui.spinner();
        return;
    };
    let grown = growing.lock();
    let diagram = &grown.answer;
    let room = ui.available_size();
    let picture = OrbitPicture {
        diagram,
        shown: state.setup.explore.orbit.shown,
    };
    let output = picture.show(ui, room - eframe::egui::vec2(0.0, 20.0));
    let hovered = output.hovered().map(|[x, _]| x);
    remark(ui, &line(diagram, hovered));
}

/// What is known at the value under the pointer, or of the whole.
fn line(diagram: &OrbitDiagram, hovered: Option<f64>) -> String {
    let Some(x) = hovered else {
        let coexisting = diagram.coexisting(COEXISTING_SHARE).len();
        let is_whole = diagram.down.len() == diagram.axis.count;
        return match coexisting {
            0 if is_whole => "Both ways lead to the same responses.".to_owned(),
            0 => "Not yet known whether both ways lead to the same responses.".to_owned(),
            n => format!(
                "Different responses up and down at {}.",
                counted(n, "value")
            ),
        };
    };
    let axis = &diagram.axis;
    let last = axis.count.saturating_sub(1) as f64;
    let index = axis.position(x).round().clamp(0.0, last) as usize;
    let value = format_quantity(axis.value(index), &axis.unit, 4);
    let way = |slices: &[OrbitSlice], name: &str| {
        let slice = slices.iter().find(|slice| slice.index == index);
        slice.map(|slice| match &slice.answer {
            Ok(answer) => {
                let periods = match answer.multiple {
                    Some(n) => counted(n, "period"),
                    None => "does not repeat".to_owned(),
                };
                let exponent = answer
                    .lyapunov
                    .map_or_else(String::new, |e| format!(", exponent {e:.2}/period"));
                format!("{name}: {}, {periods}{exponent}", answer.regime.label())
            }
            Err(reason) => format!("{name}: impossible, {reason}"),
        })
    };
    let ways = [way(&diagram.up, "up"), way(&diagram.down, "down")];
    let ways: Vec<String> = ways.into_iter().flatten().collect();
    format!("{} {value}. {}", axis.name, ways.join(". "))
}
